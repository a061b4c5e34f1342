"""Derivatives of a model's state and readings with respect to its parameters."""
