"""The kinds of geometry, one a file: their tables of dimensions, and the solids that these make."""
