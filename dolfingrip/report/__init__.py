"""Pictures, curves and tables of results; nothing here computes mechanics."""
