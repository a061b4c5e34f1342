"""A mechanical model: mesh, unknowns, potential, internal variables, state."""
