"""The cast beam of silicone that a laboratory let go, as a mesh of its own and a configuration."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from support.checkout import ROOT

from dolfingrip import config
from dolfingrip.config import Config
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest

BEAM = {
    "finger.kind": "adopted", "adopted.length_mm": 100, "adopted.width_mm": 30,
    "adopted.depth_mm": 30, "adopted.solid_body": True, "morph.d_mm": 15,
    "material.mu_MPa": 0.09, "material.density_kg_m3": 1070, "contact.self_contact": False,
}  # fmt: skip


def beam(folder: Path, size_mm: float, **further: Any) -> Config:
    """The beam at rest, meshed once for each size; keys have __ for a point."""
    mesh = folder / f"beam-{size_mm:g}.msh"
    if not mesh.exists():
        part = ROOT / "examples" / "released_beam" / "beam.stl"
        back = Asked(back=(-1.0, 0.0, 0.0))
        files.write(mesh, adopt(part, back, MeshRequest(size_mm=size_mm)).mesh)
    keys = {key.replace("__", "."): value for key, value in further.items()}
    return config.load(None, {**BEAM, "mesh.file": str(mesh), **keys})
