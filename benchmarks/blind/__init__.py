"""A blind benchmark of the diagnosis: causes are hidden in measurements, which ``dolfingrip
diagnose`` then explains.

What is hidden is simulated in full by other settings than the analyser's, all of a case at once.

- :mod:`coupons`, :mod:`fingers`: what is measured, and what is hidden in it;
- :mod:`case`: what both have in common of a case;
- :mod:`said`: what was hidden and what was said, as tables;
- :mod:`score`: figures of a table;
- :mod:`loop`: what a diagnosis advises is done on hidden fingers, and all is diagnosed again;
- :mod:`command`: the command line;
- :mod:`ci`: few cases that continuous integration runs.

**Rules**, fixed before a confirmation set is drawn (``SEEDS`` of either half differ):

- What is diagnosed is what ``dolfingrip diagnose`` does up to its verdict, on every case.
- *Named*: the answer is a cause, and the hidden cause is in one of its sets.
- *Wrong*: the answer is a cause of probability 0.9 or more, and one of its sets has no hidden
  cause.
- *Outsider claimed*: the same where only an outsider is hidden.
- Causes and outsiders are hidden at 6 standard deviations or more, by what they change after the
  modulus. An outsider alone counts from 6 standard deviations that the best single cause of the
  catalogue leaves.
- A nuisance is hidden 3 to 5 standard deviations from what was told, however little the readings
  tell of it.
- *Alarm*: nothing is hidden, and the answer is not "none".
- Priors are twice as wide in every second case.
"""
