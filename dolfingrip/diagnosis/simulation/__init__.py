"""Simulations of a measurement: its readings, and how they change with causes.

From the bottom up:

- :mod:`stops`: which stops a measurement asks for, at round values: one elastic curve, or the
  protocol in time; and the weights by which readings at the stops make those at the measured rows;
- :mod:`runner`: the requests of a diagnosis, on workers; answers are in a store, or come with the
  package;
- :mod:`simulated`: which specimens share a simulation;
  ``simulate(measurement, config, variants, workers)`` gives all readings of a measurement, and
  their derivatives, for each of several variants: this is what fits call, too; and at other walls,
  and moduli by exact scaling; and the interface of a simulator, which coupons and fingers have;
- :mod:`nuisances`: what else the readings change by;
- :mod:`unknowns`: the causes that may be named.

All arrays are aligned with ``Measurement.listed``
(:mod:`dolfingrip.diagnosis.data.measurement`); n is the number of single readings there.
"""
