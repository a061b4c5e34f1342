"""Readings of a model: value, and derivatives by its state and by parameters; one kind a file."""
