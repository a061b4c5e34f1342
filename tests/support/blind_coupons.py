"""Coupons of the blind benchmark whose truth a test chooses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from support.hidden_coupon import PROTOCOLS, Truth, configured, measured, write

from dolfingrip.diagnosis.answer.diagnosis import Diagnosis
from dolfingrip.diagnosis.answer.diagnosis import diagnosed as of
from dolfingrip.diagnosis.data import measurement
from dolfingrip.diagnosis.screening import analyse, simulator_of
from dolfingrip.diagnosis.simulation.unknowns import unknowns

SEED = 4


def diagnosed(protocol: str, truth: Truth, folder: Path) -> Diagnosis:
    """Simulate coupons with what is hidden, and diagnose them by all causes."""
    print("seed", SEED)
    plan, config = PROTOCOLS[protocol], configured()
    file = write(plan, measured(plan, truth, np.random.default_rng(SEED)), folder)
    read, _ = measurement.selected(measurement.read([file], config), config)
    return of(analyse(simulator_of(read, config, None), unknowns(read, config)), config)
