"""The unloaded shape of a design, meshed from its configuration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.page.finger import unloaded
from dolfingrip.report.page.scene import FINGER_VIEW, Load, Scene, towards


def design_shape(base: Config, inputs: Mapping[str, float]) -> Scene:
    """The scene of one design without load.

    Args:
        base: configuration that the inputs are put into.
        inputs: values by key of the configuration.

    Raises:
        ConfigError: one line, if it cannot be meshed.
    """
    data: dict[str, Any] = base.model_dump(mode="json", exclude_none=True)
    for key, value in inputs.items():
        *tables, name = key.split(".")
        table = data
        for each in tables:
            table = table.setdefault(each, {})
        table[name] = value
    return unloaded_shape(configuration.from_dict(data))


def unloaded_shape(config: Config) -> Scene:
    """Return the scene of a design without load.

    Args:
        config: of the design.

    Raises:
        ConfigError: one line, if it cannot be meshed.
    """
    mesh = solid(config.changed(mesh={"order": 1}))
    corners = mesh.shape.corners
    fields = FieldMesh(mesh.points, mesh.cells[:, :corners], np.arange(len(mesh.points)))
    load = Load("", "", np.zeros(1), [""], np.zeros(1, dtype=np.int64))
    parts = unloaded(fields, "design")
    return Scene("design", "Shape of the design", "design", parts, load, towards(FINGER_VIEW))
