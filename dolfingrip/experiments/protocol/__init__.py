"""The stops of an experiment: what is led to which value at which time."""
