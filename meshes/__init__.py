"""Tetrahedral meshes of the finger: geometry, generation, files and checks; no UFL, no MPI."""
