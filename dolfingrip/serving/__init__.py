"""Pages of this package in the browser: who is let in, and how a server listens."""
