"""Strain energies as base material, one a file: their keys in ``[material]``, and their energy."""
