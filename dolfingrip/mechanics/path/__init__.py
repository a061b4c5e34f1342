"""Load paths: adaptive steps, start values, limit points, failures."""
