"""Which effect a residual speaks for: closed forms on arrays, without simulations or files."""
