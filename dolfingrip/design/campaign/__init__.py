"""Design of experiments: which designs, simulated by workers, kept in a store."""
