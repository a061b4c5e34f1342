"""Fingers, and coupons beside them: emulators from finite-element simulations."""
