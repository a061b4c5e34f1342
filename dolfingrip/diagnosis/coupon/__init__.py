"""Coupons in closed form: every simulation is exact and costs next to nothing."""
