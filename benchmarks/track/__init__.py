"""Videos of the package's own fingers whose truth is known, and what ``track`` reads in them."""
