"""Speed, accuracy and memory of dolfingrip, and of its peers on the same meshes.

``scripts/benchmark`` runs this. Each run is a separate process (:mod:`benchmarks.job`). Its outcome
is kept in ``out/benchmark``; ``benchmarks/results.md`` is written when all parts have been run.
"""

import sys
from pathlib import Path

# what tests and benchmarks share stands in tests/support
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
