"""Measured data are read, checked and compared with a simulation for slips.

:func:`dolfingrip.diagnosis.data.measurement.read` makes a
:class:`~dolfingrip.diagnosis.data.measurement.Measurement` of CSV files. Bad data are refused in
one line (``ConfigError``). What can only be suspected is a sentence in ``Measurement.warnings``, or
is found by :func:`dolfingrip.diagnosis.data.suspicion.suspicions` once there is a simulation to
compare with.
"""
