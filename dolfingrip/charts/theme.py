"""The look of every picture: fonts, colours and line styles in one place."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, ListedColormap, to_rgb

from dolfingrip.files import whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pyvista.plotting.themes import Theme

BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#D55E00", "#009E73", "#CC79A7"
"""Okabe and Ito's colours: distinguishable with any colour vision and by lightness in print."""

INK, GREY, PALE = "#222222", "#7F7F7F", "#C8CACC"
"""Colours of text and outlines, of secondary lines, of fixtures (clamp, plate)."""

PLAIN = "#9CC3E0"
"""Colour of a finger that no field colours."""

COLOUR_MAPS = {
    "displacement": ("YlGnBu", 0.04, 0.88), "stretch": ("YlOrRd", 0.03, 0.86),
    "mises": ("PuRd", 0.03, 0.86), "stress": ("OrRd", 0.03, 0.86),
    "energy": ("YlGn", 0.03, 0.86), "contact": ("BuPu", 0.03, 0.86),
    "pressure": ("Blues", 0.03, 0.86),
}  # fmt: skip
"""By quantity: Matplotlib's name, and the part of the map that is taken."""

DPI = 300
"""Dots per inch of every file written."""

_RC: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # ships with matplotlib, so it is there on any machine
    "font.size": 9,
    "text.color": INK,
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "grid.color": "#E2E2E2",
    "grid.linewidth": 0.6,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.dpi": 100,
    "savefig.dpi": DPI,
    "savefig.facecolor": "white",
}


def tint(colour: str) -> tuple[float, float, float]:
    """An opaque colour that looks like one fifth of ``colour`` on white."""
    red, green, blue = (1 - 0.2 * (1 - part) for part in to_rgb(colour))
    return red, green, blue


def colour_map(quantity: str) -> Colormap:
    """Return the colour map of a field; each field has its own, so that nobody mixes them up.

    All run from light to dark (ColorBrewer: safe for any colour vision and in grey print). An
    unloaded finger is light, so its edges and the shading of its bellows can be seen; the ends
    are cut off, white being the paper and black the edges.

    Args:
        quantity: name of a field; ``none`` has one colour.
    """
    if quantity == "none":
        return ListedColormap([PLAIN], name="dolfingrip_none")
    name, low, high = COLOUR_MAPS[quantity]
    colours = mpl.colormaps[name](np.linspace(low, high, 256))
    return ListedColormap(colours, name=f"dolfingrip_{quantity}")


def figure_theme() -> AbstractContextManager[None]:
    """Matplotlib's settings in a ``with`` block; the caller's settings return after it."""
    return mpl.rc_context(_RC)


def save(figure: Figure, file: Path, dpi: float = DPI) -> None:
    """Write a figure in the format of the file's suffix.

    Args:
        figure: what is drawn.
        file: target; an existing file is replaced.
        dpi: dots per inch.

    Raises:
        WriteError: one line.
    """
    with whole.stream(file) as content:
        figure.savefig(content, format=file.suffix.removeprefix("."), dpi=dpi)


def scene_theme() -> Theme:
    """A pyvista theme for one plotter: white, parallel light kit, no window, no decorations."""
    from pyvista.plotting.themes import DocumentTheme

    theme = DocumentTheme()
    theme.background = "white"
    theme.color = PALE
    theme.font.family = "arial"  # VTK's built-in face; all text is set by matplotlib instead
    theme.show_scalar_bar = False
    theme.multi_samples = 8
    return theme
