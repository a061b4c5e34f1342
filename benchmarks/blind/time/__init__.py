"""Hidden causes in time: bodies that swing, fingers that fill through a valve, and long waits."""
