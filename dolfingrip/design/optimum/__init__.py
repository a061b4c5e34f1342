"""The best designs of a surrogate by NSGA-II, checked by finite elements; studies of both."""
