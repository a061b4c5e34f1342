"""Experiments on a finger and how each is observed."""

from dolfingrip.experiments.finger import landings_kPa
from dolfingrip.experiments.run import Result, run

__all__ = ["Result", "landings_kPa", "run"]
