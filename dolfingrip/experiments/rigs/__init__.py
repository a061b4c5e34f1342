"""Test rigs: a specimen, what leads it, and what reads it."""
