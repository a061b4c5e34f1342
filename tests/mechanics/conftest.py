"""Bodies shared by the tests of the mechanics."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from support import bodies, spheres


@pytest.fixture(scope="session", params=[1, 2], ids=["P1", "P2"])
def degree(request: pytest.FixtureRequest) -> int:
    """Order of the displacement."""
    return int(request.param)


@pytest.fixture(scope="session")
def hollow(degree: int) -> bodies.Body:
    """The hollow cube, whose loads each test sets for itself."""
    return bodies.body(bodies.hollow_cube(), degree)


@pytest.fixture(scope="session")
def sphere() -> bodies.Body:
    """Octant of a balloon of radii 1 and 1.3 mm, free to widen."""
    solid = bodies.body(spheres.octant(1.0, spheres.RATIO, 0.25), 2)
    spheres.hold_octant(solid)
    return solid


@pytest.fixture
def balloon(sphere: bodies.Body) -> Iterator[bodies.Body]:
    """The balloon without pressure; its state is restored after each test."""
    yield sphere
    sphere.displace(np.zeros_like(sphere.nodes))
    sphere.model.prescribe({"pressure_kPa": 0.0, "time_s": 0.0})
