"""Faults that another program has simulated: CalculiX, on tetrahedra of Gmsh, read in holds."""
