"""Energies and observables in UFL, one per file: no solver, no input or output.

A total potential is a sum of these; residual, tangent and reactions are its derivatives. Each file
has an example that runs by itself: ``scripts/run python -m doctest -v forms/neo_hookean.py``.
"""
