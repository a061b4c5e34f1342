"""Experiments on a finger and how each is observed."""

from dolfingrip.experiments.landings import landings, landings_kPa
from dolfingrip.experiments.run import Result, run

__all__ = ["Result", "landings", "landings_kPa", "run"]
