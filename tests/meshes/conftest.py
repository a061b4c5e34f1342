"""Meshes that several tests share; they are frozen, so one of each is enough."""

from __future__ import annotations

import pytest
from support import hollow_box

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.solid import SolidMesh


@pytest.fixture(scope="session")
def half() -> SolidMesh:
    return finger_mesh(Finger(), Mesh(size_mm=10))


@pytest.fixture(scope="session")
def half_second_order() -> SolidMesh:
    return finger_mesh(Finger(), Mesh(size_mm=10, order=2))


@pytest.fixture(scope="session")
def whole() -> SolidMesh:
    return finger_mesh(Finger(), Mesh(size_mm=10, half=False))


@pytest.fixture(scope="session")
def bricks() -> SolidMesh:
    return hollow_box.mesh()


@pytest.fixture(scope="session")
def bricks_second_order() -> SolidMesh:
    return hollow_box.mesh(order=2)
