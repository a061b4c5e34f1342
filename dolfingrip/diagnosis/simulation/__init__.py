"""Simulations of a measurement: its readings, and how they change with causes.

From the bottom up:

- :mod:`legs`: the stops of a simulation, and the weights by which its readings at the stops make
  the readings at the measured rows;
- :mod:`routes`: which stops a measurement asks for: one elastic curve, or the protocol in time;
- :mod:`groups`: which specimens share a simulation;
- :mod:`runner`: the requests of a diagnosis, on workers and kept in a store;
- :mod:`simulated`: ``simulate(measurement, config, cases, workers)`` gives all readings of a
  measurement, and their derivatives, for each of several cases: this is what fits call, too;
- :mod:`modulus`: exact scaling of a base simulation by the modulus;
- :mod:`elastic_curve`: readings at another load than that of the protocol; :mod:`relaxation`:
  viscous effects, which nearly follow from it;
- :mod:`nuisances`: what else the readings change by; :mod:`walls`: at other walls.

All arrays are aligned with ``Measurement.listed()``
(:mod:`dolfingrip.diagnosis.data.measurement`); n is the number of single readings there.
"""
