"""Contact between surfaces, and with a rigid plate."""
