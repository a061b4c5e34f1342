"""The stops of an experiment: at which times the control has which values."""
