"""The solver: domain, total potential, Newton's method, contact, load path."""
