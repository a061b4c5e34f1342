"""Neural surrogates of a campaign."""
