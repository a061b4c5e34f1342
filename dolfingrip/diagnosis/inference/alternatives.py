"""How a verdict depends on the noise: the same residual under several models of it.

The models are hypotheses like the causes: each has a probability before measuring, and the
density of the residual under each, averaged over causes, gives that after measuring.
Probabilities of causes are averaged over the models, so a doubtful noise makes a cautious verdict.
"""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip.diagnosis.inference.noise import Along, ChannelNoise

BELIEVED, LARGER, CORRELATED, BOTH = (
    "as believed",
    "1.5 times as large",
    "correlated along runs",
    "1.5 times as large, correlated along runs",
)
PRIOR = {BELIEVED: 0.55, LARGER: 0.15, CORRELATED: 0.15, BOTH: 0.15}
"""Of the models of noise, where none was estimated from repeats."""
SHARE = 0.8
"""Part of the variance that is correlated in the alternatives."""

PARTLY, LASTING = "in part correlated along runs", "in part the same all along a run"
LITTLE = 0.25
"""Part of the variance that is correlated in :func:`in_part`."""
LONGER = 9.0
"""How much longer what lasts does so than what is correlated along a run."""
PRIOR_IN_PART = {PARTLY: 0.1, LASTING: 0.1}
"""Beside :data:`PRIOR`."""
EVERY_PRIOR = PRIOR | PRIOR_IN_PART
"""Of all models, by name; not normalised."""


def alternatives(
    noise: Mapping[str, ChannelNoise], length: float, along: Along = "time_s"
) -> dict[str, dict[str, ChannelNoise]]:
    """Models of the noise to try, by name; the first is as believed.

    Args:
        noise: as believed, by channel.
        length: over which correlated noise forgets, in the unit of ``along``.
        along: whether that is time (s) or readings.
    """

    def correlated(believed: ChannelNoise) -> ChannelNoise:
        share = max(SHARE, (believed.correlated_std / believed.total_std()) ** 2)
        return believed.with_correlated_part(share, length, along)

    return {
        BELIEVED: dict(noise),
        LARGER: {name: each.scaled(1.5) for name, each in noise.items()},
        CORRELATED: {name: correlated(each) for name, each in noise.items()},
        BOTH: {name: correlated(each).scaled(1.5) for name, each in noise.items()},
    }


def in_part(
    noise: Mapping[str, ChannelNoise], length: float, along: Along = "time_s"
) -> dict[str, dict[str, ChannelNoise]]:
    """Models to try beside :func:`alternatives` where noise is believed independent, by name.

    Of noise that drifts a little, each reading is scattered mostly by itself, which
    :data:`SHARE` contradicts more than independence does. Where a run is over before the noise
    forgets, what drifts is an offset of the run.

    Args:
        noise, length, along: as for :func:`alternatives`.
    """
    return {
        name: {key: each.with_correlated_part(LITTLE, lasts, along) for key, each in noise.items()}
        for name, lasts in ((PARTLY, length), (LASTING, LONGER * length))
    }
