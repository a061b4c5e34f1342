"""A cast pneu-net that curls, cut open: the example's, with eleven chambers in place of five.

    scripts/run dolfingrip bend --config examples/pneunet_mould.toml --set pneunet.chambers=11 \
        --pressure 6 --set experiment.step_kPa=1 --set solver.max_step_kPa=0.5 \
        --set mesh.size_mm=8 -o out/pneunet_curl
    scripts/run python docs/pictures/pneunet_curl.py out/pneunet_curl

draws ``docs/pneunet_curl.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path

from PIL import Image

from dolfingrip.report.render import draw

PICTURE = Path(__file__).resolve().parents[1] / "pneunet_curl.png"
SHOWN_KPA = (0, 2, 4, 6)
WIDTH_PX = 1300

if __name__ == "__main__":
    fields = Path(sys.argv[1]) / "fields.pvd"
    drawn = draw(fields, SHOWN_KPA, colour_by="stretch", shown="half", height_in=3.4)
    drawn.save_strip(PICTURE)
    with Image.open(PICTURE) as strip:
        tall = round(strip.height * WIDTH_PX / strip.width)
        small = strip.convert("RGB").resize((WIDTH_PX, tall), Image.Resampling.LANCZOS)
    small.save(PICTURE, optimize=True)
    print(f"wrote {PICTURE}")
