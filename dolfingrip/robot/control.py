"""Torques of a finger's joints from its pressure, for simulators that read finger.urdf.

It needs NumPy and the robot.json beside it. At every step a simulator's loop calls
:meth:`JointLaws.efforts` with the joints' places in the order of ``JointLaws.names``, in m and rad,
and applies what it returns::

    finger = JointLaws("robot.json")
    efforts = finger.efforts(pressure_kPa=100.0, position=q)

These are springs and pressure. The joints' damping stands in finger.urdf: it is large beside the
inertia of a light link, and stays stable only where the simulator itself integrates it implicitly.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

PALE, RED, BLUE = np.array([[0.95, 0.90, 0.78], [0.80, 0.16, 0.08], [0.10, 0.30, 0.75]])
"""Colours at no pressure, at the highest one, and at as much suction."""


class JointLaws:
    """The laws a p + b p w + c w + d p² of all joints.

    Args:
        file: robot.json.
    """

    def __init__(self, file: Path | str) -> None:
        data = json.loads(Path(file).read_text(encoding="utf-8"))
        self.highest_kPa = data["valid"]["pressure_kPa"][1]
        every = [coordinate for joint in data["joints"] for coordinate in joint["coordinates"]]
        self.names = [coordinate["name"] for coordinate in every]
        laws = np.array([coordinate["law"] for coordinate in every])
        hinge = np.array([coordinate["kind"] == "hinge" for coordinate in every])
        # from N·mm to N·m of hinges, and from 1/mm to 1/m of slides
        self.laws = laws * np.where(hinge[:, None], 1e-3, [1.0, 1e3, 1e3, 1.0])

    def colour(self, pressure_kPa: float) -> np.ndarray:
        """Return red, green and blue, 0 to 1, for the finger at a pressure.

        Pale at 0, red at the highest pressure of the fit, blue at so much suction::

            model.skin_rgba[:, :3] = finger.colour(data.sensor("pressure_kPa").data[0])  # MuJoCo

        Args:
            pressure_kPa: in the finger.
        """
        share = np.clip(pressure_kPa / self.highest_kPa, -1.0, 1.0)
        return PALE + abs(share) * ((RED if share > 0 else BLUE) - PALE)

    def efforts(self, pressure_kPa: float, position: np.ndarray) -> np.ndarray:
        """Return forces (N) of slides and torques (N·m) of hinges.

        Args:
            pressure_kPa: in the finger.
            position: (joints,) m and rad, in the order of ``names``.
        """
        a, b, c, d = self.laws.T
        p = pressure_kPa
        return a * p + b * p * position + c * position + d * p * p
