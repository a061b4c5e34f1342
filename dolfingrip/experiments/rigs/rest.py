"""The finger at rest: unpressurised, hanging, without the plate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.mechanics.path.path import LoadPath, Observer

UNPRESSURISED = {"pressure_kPa": 0.0, "time_s": 0.0}


def has_weight(finger: FingerModel) -> bool:
    """Whether gravity deforms the finger at rest."""
    return bool(finger.config.gravity.acceleration_m_s2)


def go_to_rest(
    finger: FingerModel, newton: Newton, observers: Sequence[Observer] = ()
) -> Failure | None:
    """Let the finger hang without the plate, then put the plate at its gap from the skin.

    Args:
        finger: model of the finger, which is undeformed.
        newton: solver of its model; under volume control it comes to rest under pressure control.
        observers: called after each converged step.

    Returns:
        Why it did not come to rest; None if it did.
    """
    model, plate = finger.model, finger.plate
    if model is not finger.by_pressure:
        newton = Newton(finger.by_pressure, newton.settings, newton.profile)
    if plate is not None:
        plate.retract()
    longest = {"pressure_kPa": newton.settings.max_step_kPa}
    failure = LoadPath(newton, longest, observers=observers).advance(UNPRESSURISED).failure
    if plate is not None:
        plate.put()
        model.accept_step()  # effects remember where the plate stands
    return failure


@contextmanager
def at_rest(finger: FingerModel) -> Iterator[None]:
    """A context in which the finger is in its state ``rest``, without the plate."""
    model, plate = finger.model, finger.plate
    now = model.state()
    places = None if plate is None else (float(plate.offset.value), float(plate.unloaded.value))
    model.restore(finger.rest)
    if plate is not None:
        plate.retract()
    try:
        yield
    finally:
        if plate is not None and places is not None:
            offset, unloaded = places
            plate.put(unloaded)
            plate.offset.value = offset
        model.restore(now)
