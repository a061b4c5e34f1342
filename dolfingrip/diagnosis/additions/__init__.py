"""The next experiment: what could be added to a measurement, and what it would tell."""
