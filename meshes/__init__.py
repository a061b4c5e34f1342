"""Meshes of the finger: geometry, generation, morph, files and checks; no UFL, no MPI."""
