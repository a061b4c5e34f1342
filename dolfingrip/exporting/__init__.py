"""Fingers as files that other programs load, one file for each program."""
