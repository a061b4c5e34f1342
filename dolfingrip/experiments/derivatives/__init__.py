"""Derivatives of readings by parameters."""
