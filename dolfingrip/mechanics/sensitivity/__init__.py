"""Derivatives of what a model yields with respect to its parameters."""
