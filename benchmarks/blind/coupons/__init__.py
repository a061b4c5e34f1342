"""A blind benchmark of coupons that shares neither strengths, nuisances nor responses with what it
tests.

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

**Rules**, fixed before the confirmation set is drawn (their seeds differ: ``cases.SEEDS``):

- What is diagnosed is what ``dolfingrip diagnose`` does up to its verdict, on every case.
- *Named*: the answer is a cause, and the hidden cause is in one of its sets.
- *Wrong*: the answer is a cause of probability 0.9 or more, and one of its sets has no hidden
  cause.
- *Outsider claimed*: the same where only an outsider is hidden.
- Causes and outsiders are hidden at 6 standard deviations or more, by what they change after the
  modulus (an outsider alone: by what the best single cause of the catalogue leaves).
- A nuisance is hidden 3 to 5 standard deviations from what was told, however little the readings
  tell of it.
- *Alarm*: nothing is hidden, and the answer is not "none".
- Two causes, and nuisances, are compared with exact evidence: the same search under the true
  covariance.
- Priors are twice as wide in every second case.
"""
