"""Charts as plain data, and their pictures by Matplotlib."""
