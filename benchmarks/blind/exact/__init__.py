"""Evidence of simulated changes in closed form: what the best analysis of a case could say."""
