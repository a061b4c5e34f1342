"""The engine: domain, total potential, Newton's method, contact, load path."""
