"""Keys that are asked for and that do nothing in an experiment.

A key does nothing where no part of the experiment's rig feels its table, where the experiment does
without it, or where it needs another key beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Final, NamedTuple

from dolfingrip.config import Change, Config
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.extensions.camera import CameraError
from dolfingrip.sections import errors, tables


class Need(NamedTuple):
    """Another setting, without which a key does nothing.

    Attributes:
        met: whether a configuration has it.
        words: what messages call it.
    """

    met: Callable[[Config], bool]
    words: str


def source(*names: str) -> Need:
    """A supply of air with one of some sources."""
    words = " or ".join(f'supply.source = "{name}"' for name in names)
    return Need(lambda c: c.supply is not None and c.supply.source in names, words)


DYNAMIC: Final = Need(lambda c: c.experiment.dynamic, "experiment.dynamic = true")
VOLUME: Final = Need(
    lambda c: c.experiment.control != "pressure", 'experiment.control = "volume" or "auto"'
)
RAMPS: Final = Need(lambda c: not c.protocol.time_s, "the experiment's ramps, as [protocol] tells")
BESIDE_PROTOCOL: Final = ("snaps", "dynamic", "control")
"""Keys of ``[experiment]`` that act beside a protocol, too."""
CAMERA: Final = Need(lambda c: bool(c.extensions.active(CameraError)), "an effect of a camera")

TOUCH: Final = Need(lambda c: c.contact.self_contact, "contact.self_contact = true")

NEEDS: Final[Mapping[str, Need]] = {
    "solver.time_error_mm": DYNAMIC,
    "solver.hht_alpha": DYNAMIC,
    "release.over_s": Need(lambda c: c.release.acts, "release.held_x_mm or release.load_x_N"),
    "experiment.max_volume_ratio": VOLUME,
    "experiment.step_volume_ratio": VOLUME,
    "experiment.hold_readings": Need(
        lambda c: max(c.experiment.hold_s, c.experiment.rest_s) > 0, "experiment.hold_s or rest_s"
    ),
    "experiment.rest_s": Need(
        lambda c: c.experiment.unload or c.experiment.cycles > 1,
        "experiment.unload = true or experiment.cycles",
    ),
    "gravity.direction": Need(
        lambda c: c.gravity.acceleration_m_s2 != 0, "gravity.acceleration_m_s2"
    ),
    "base.direction": Need(lambda c: bool(c.base.time_s), "base.acceleration_m_s2"),
    "mesh.order": Need(lambda c: c.mesh.file is None, "a mesh of its own, as mesh.file has one"),
    "supply.tank_cm3": source("tank"),
    "supply.tank_kPa": source("tank"),
    "supply.pump_kPa": source("pump"),
    "supply.pump_l_per_min": source("pump"),
    "supply.syringe_cm3": source("syringe"),
    "supply.band_kPa": source("pump", "tank"),
    **dict.fromkeys(("camera.distance_mm", "camera.centre_mm", "camera.scale_mm"), CAMERA),
    **dict.fromkeys(("contact.barrier_mm", "contact.stiffness_MPa", "contact.spacing_mm"), TOUCH),
}
"""By key."""


def idle(experiment: Experiment, config: Config, change: Change) -> Iterator[str]:
    """Yield a sentence for each key of a change that does nothing.

    Keys that say how a solution is found are left out, as no answer depends on them.

    Args:
        experiment: that is run.
        config: with the change, and with the experiment's settings.
        change: values by key that someone asks for.
    """
    for key in change:
        path = [part for part in tables.parts(key) if isinstance(part, str)]
        holders = [errors.kinds(path[:end], Config)[0] for end in range(1, len(path))]
        need = NEEDS.get(key)
        if path[-1] in holders[-1].effort:
            continue
        felt = all(holder.felt_on(experiment.parts) for holder in holders)
        if key in experiment.does_without or not felt:
            yield f"{key}: {experiment.command} does not depend on it"
        elif path[0] == "experiment" and path[1] not in BESIDE_PROTOCOL and not RAMPS.met(config):
            yield f"{key}: does nothing without {RAMPS.words}"
        elif path[1] in config.tables[path[0]].unused:
            yield f"{key}: does nothing beside the table's other keys"
        elif need is not None and not need.met(config):
            yield f"{key}: does nothing without {need.words}"
