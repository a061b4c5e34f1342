"""Designs by gradients: a question, its limits and any number of parameters, by finite elements."""
