"""What is reported of a fit is what the extended configuration has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.extend import extended, parameters
from dolfingrip.diagnosis.hypothesis import Hypothesis
from dolfingrip.diagnosis.inference.laplace import Estimate
from dolfingrip.diagnosis.model import SCALE, EffectModel, FreeParameter, free_parameters
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.strengths import ordinary
from dolfingrip.extensions.effect import Prior
from dolfingrip.parameter import find

MODULUS = FreeParameter(SCALE, Prior(1.0, 0.15, "test", positive=True), 0.1, 10.0)


class Alone(EffectModel):
    """Of one material, as it is configured."""

    @property
    def _configured(self) -> Config:
        return self.config


@pytest.mark.parametrize("factor", [1.0, 0.8])
@pytest.mark.parametrize("name", ["mooney_rivlin", "yeoh", "bulk_modulus", "prony"])
def test_reported_parameters_are_those_of_the_extended_configuration(
    name: str, factor: float
) -> None:
    """Those that are moduli are fitted by the configured one, and carry its factor."""
    config = Config()
    (tried,) = [each for each in ordinary(config) if each.effect == name]
    own = free_parameters(name, tried.shapes[0].overrides, config)
    model = Alone(cast(Measurement, None), config, cast(Workers, None), MODULUS, own)
    values: Sequence[float] = [factor, *(1.1 * p.prior.mean for p in own)]
    zeta = np.array([p.prior.zeta(v) for p, v in zip(model.parameters, values, strict=True)])
    fit = Hypothesis(
        (name,), tuple(model.parameters), zeta, np.zeros(0), np.zeros((0, len(values))),
        overrides=model.overrides(values),
    )  # fmt: skip
    estimates = [Estimate(value, 0.9 * value, 1.2 * value, 0.1) for value in values]
    reported = parameters(config, fit, estimates)
    found = extended(config, fit)
    keys = [key for key, _ in reported]
    assert {"material.mu_MPa", *(p.key for p in own)} <= {*keys}
    for parameter, (_, estimate) in zip(find(found, keys), reported, strict=True):
        assert estimate.value == pytest.approx(parameter.value(found))
        assert estimate.low == pytest.approx(0.9 * estimate.value)
        assert estimate.high == pytest.approx(1.2 * estimate.value)
