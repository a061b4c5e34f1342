"""What is answered: the result, its statistics, its gain on readings left out, what settles it."""
