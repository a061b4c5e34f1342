"""Sections of the configuration: tables with their keys, ranges and meanings; no solver."""
