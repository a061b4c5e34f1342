"""The best designs of a surrogate: NSGA-II, Pareto fronts, studies of both."""
