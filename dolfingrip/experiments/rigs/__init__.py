"""Test rigs: a specimen with its control and its readings."""
