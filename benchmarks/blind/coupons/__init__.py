"""Coupons that share neither strengths, nuisances nor responses with the analyser.

    scripts/run python -m benchmarks.blind.coupons run --set development   # mended on these
    scripts/run python -m benchmarks.blind.coupons run --set confirmation  # final figures only
    scripts/run python -m benchmarks.blind.coupons run --set prior         # drawn from the priors
    scripts/run python -m benchmarks.blind.coupons score
    scripts/run python -m benchmarks.blind.coupons ranks

Every case is simulated on its own (``coupon.py``): each specimen with the true energy, modulus,
cross-section, gauge length and slack, at steps of half the analyser's length. No response is
interpolated in the strength, and nuisances are not linear. Two or three specimens differ in
stiffness and shape; the gauge of the travel scatters. The analyser is told the standard deviations
of the noise, of the gauge length and of the specimens' stiffness, and finds all else by itself.

Two causes, and nuisances, are compared with exact evidence: the same search under the true
covariance.
"""
