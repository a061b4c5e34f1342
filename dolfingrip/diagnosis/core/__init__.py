"""One prior, one evidence and one decision for all hypotheses about a measurement."""
