"""What a run yields, and the files that it is written to."""
