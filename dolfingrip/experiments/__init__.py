"""Experiments on a finger and how each is observed."""
