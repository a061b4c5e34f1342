"""Food, one shape a file: its keys in ``[food]``, its portions, its distance and its skin."""
