"""The diagnosis closes the loop: what it advises is measured on the hidden finger.

A finger of another mesh and other elements, whose modulus, walls, regulator and plate are up to two
standard deviations off, is measured by a first protocol (``small``: five bellows; ``reference``).
``dolfingrip diagnose`` answers. What its ``diagnosis.json`` puts first of ``next_experiments`` is
done on the hidden finger, and both are diagnosed together; up to two such rounds.

- A further measurement is simulated as its ``tests`` tell it; the plate is set anew.
- A check returns the hidden number with the noise of ``std``. The number goes into the model that
  is diagnosed (``--set KEY=VALUE``), ``nuisance`` into ``[nuisance]`` of each TOML. An effect whose
  number is less than three standard deviations from doing nothing is not tried any more
  (``--effects``); else it acts, and counts as named where it is what is hidden.
- What cannot be done, or was done before, is passed over; ``undone`` of the table has it.

Hidden is one cause of the catalogue that changes the readings by 4 standard deviations or more
beside the modulus and the rig, by the hidden simulation. ``pull`` is the same on a coupon that is
pulled once, which is simulated in closed form; its cases are no fingers, and count by themselves.

**As it stands.** Of the 40 fingers (32 ``small``, 8 ``reference``) one is drawn and none is
finished. One of 12 coupons is finished: Mooney and Rivlin's law, 323 standard deviations.

| figure | target | after 0 | after 1 | after 2 |
|---|---|---|---|---|
| named in a set of at most three | ≥ 0.80 after 2 | 0 of 1 | 1 of 1 | 1 of 1 |
| wrong at 0.9 or more | 0 | 0 of 1 | 0 of 1 | 0 of 1 |
| modulus and walls in their 90 % intervals | 0.85 to 0.95 | 1 of 1 | 1 of 1 | 1 of 1 |

Its diagnoses took 33, 43 and 39 s of processor (AMD EPYC, beside many other runs).

    scripts/run python -m benchmarks.blind.loop freeze small reference   # draws what is not there
    scripts/run python -m benchmarks.blind.loop run small --only 4       # goes on where it stopped
    scripts/run python -m benchmarks.blind.loop score

- :mod:`cases`: what is hidden, drawn once and kept as files;
- :mod:`laboratory`: measures, checks, and writes what it knows;
- :mod:`rounds`: diagnoses, does what is advised, keeps a row for each answer;
- :mod:`scores`: figures of these rows.
"""
