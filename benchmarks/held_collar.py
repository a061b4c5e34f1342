"""How much a collar gives way that is held by its outside, on finer and finer meshes.

    scripts/run python -m benchmarks.held_collar

bends a bar of 18 × 16 × 40 mm on a collar of 28 × 12 mm by 100 kPa: with the collar's outer faces
held (``group``), with the collar held as a whole (``box``), and without it, with the plane held
where it ends (``plane``). Writes ``benchmarks/held_collar.csv``.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import gmsh
import numpy as np

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.files import table
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import AdoptedPart, adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.gmsh_model import session

RESULT = Path(__file__).with_suffix(".csv")
SIZES_MM = (5.0, 3.0, 2.2)
HELD = (-20.0, -20.0, -20.0, 20.0, 20.0, 0.0)
READ = ("tip_x_mm", "tip_z_mm", "angle_deg")


def drawn(file: Path, *, collar: bool) -> Path:
    """The bar with its cavity and a bore for air, as STEP; with its collar or without it."""
    occ = gmsh.model.occ
    with session("part"):
        solid = [(3, occ.addBox(-9, -8, 0, 18, 16, 40))]
        if collar:
            solid = occ.fuse(solid, [(3, occ.addCylinder(0, 0, -12, 0, 0, 12, 14))])[0]
        hollows = [occ.addBox(-3.5, -5, 3, 10, 10, 34), occ.addCylinder(1.5, 0, -12, 0, 0, 16, 1.5)]
        occ.cut(solid, [(3, each) for each in hollows])
        occ.synchronize()
        gmsh.write(str(file))
    return file


def parts(folder: Path, size_mm: float) -> dict[str, AdoptedPart]:
    """The three bodies with elements of one size."""
    wanted = MeshRequest(size_mm=size_mm, order=1)
    whole = adopt(drawn(folder / "whole.step", collar=True), Asked(whole=True), wanted)
    points = whole.mesh.points @ whole.roles.rotation + whole.roles.origin_mm
    outer = np.concatenate([whole.mesh.facets[name] for name in ("skin", "clamp", "tip")])
    low = points[outer, 2].max(axis=1) < 1e-6
    mesh = replace(whole.mesh, points=points, facets={"clamp": outer[low]})
    files.write(folder / "group.msh", mesh)
    files.write(folder / "box.msh", replace(mesh, facets={}))
    plane = drawn(folder / "plane.step", collar=False)
    return {
        "group": adopt(folder / "group.msh", Asked(), MeshRequest()),
        "box": adopt(folder / "box.msh", Asked(held=[HELD]), MeshRequest()),
        "plane": adopt(plane, Asked(whole=True), wanted),
    }


def main() -> None:
    """Bend them all and write the table."""
    rows = []
    for size_mm in SIZES_MM:
        with TemporaryDirectory() as folder:
            for name, part in parts(Path(folder), size_mm).items():
                file = Path(folder) / "finger.msh"
                files.write(file, part.mesh)
                depth, width, length = part.size_mm
                finger = config.from_dict(
                    {
                        "finger": {"kind": "adopted"},
                        "adopted": {"length_mm": length, "width_mm": width, "depth_mm": depth},
                        "mesh": {"file": str(file)},
                        "material": {"mu_MPa": 0.5},
                        "solver": {"element": "P2"},
                        "contact": {"self_contact": False},
                        "experiment": {"max_pressure_kPa": 100.0, "step_kPa": 100.0},
                    }
                )
                found = run("bending", finger)
                read = {key: f"{float(found.column(key)[-1]):.5f}" for key in READ}
                rows.append(
                    {"held": name, "size_mm": size_mm, "cells": len(part.mesh.cells)} | read
                )
                print(rows[-1], flush=True)
    table.write(RESULT, rows)


if __name__ == "__main__":
    main()
