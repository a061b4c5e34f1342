"""Energies and observables in UFL, one per file: no solver, no input or output.

A total potential is a sum of these; residual, tangent and reactions are its derivatives.
"""
