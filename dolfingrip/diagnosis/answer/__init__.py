"""What is answered: what was found, its gain on readings left out, ten lines, data."""
