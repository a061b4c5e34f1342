"""Files, lines and imports of each layer: ``python -m benchmarks.layers``; see docs/layout.md.

Imports are pairs of files, by grimp. Layers come from the lowest to the highest. ``forms`` and
``meshes`` lie beside the package in the repository, so a whole copy is looked at.
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Final

import grimp

ROOT: Final = Path(__file__).resolve().parents[1]

LAYERS: Final = (
    "sections", "forms", "meshes", "mechanics", "extensions", "config", "parameter", "experiments",
    "design", "diagnosis", "report", "cli",
)  # fmt: skip


def layer(module: str) -> str:
    """The layer of a module of the package; "" of the package itself."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in LAYERS else ""


def lines(module: str, package: Path) -> int:
    """Lines of a module's file."""
    place = package.joinpath(*module.split(".")[1:])
    file = place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
    return len(file.read_text(encoding="utf-8").splitlines())


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as folder:
        package = Path(folder) / "dolfingrip"
        shutil.copytree(ROOT / "dolfingrip", package)
        for beside in ("forms", "meshes"):
            shutil.copytree(ROOT / beside, package / beside)
        sys.path.insert(0, folder)
        table(package)


def table(package: Path) -> None:
    """Print the table of a package's folder, the first of its name on the path."""
    graph = grimp.build_graph("dolfingrip", cache_dir=None)
    print("| layer | files | lines | imports of other layers | imports of higher layers |")
    print("|---|--:|--:|--:|--:|")
    total = [0, 0, 0, 0]
    for place, name in enumerate(LAYERS):
        modules = [module for module in graph.modules if layer(module) == name]
        targets = [
            layer(imported)
            for module in modules
            for imported in graph.find_modules_directly_imported_by(module)
            if layer(imported) not in ("", name)
        ]
        higher = sum(LAYERS.index(target) > place for target in targets)
        counts = [
            len(modules),
            sum(lines(module, package) for module in modules),
            len(targets),
            higher,
        ]
        total = [a + b for a, b in zip(total, counts, strict=True)]
        print(f"| `{name}` | " + " | ".join(f"{count:,}" for count in counts) + " |")
    print("| all | " + " | ".join(f"{count:,}" for count in total) + " |")


if __name__ == "__main__":
    main()
