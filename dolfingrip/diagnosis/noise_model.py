"""The noise of a measurement: as told, else from repeats or dense readings, else a guess."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.noise import InstrumentNoise
from dolfingrip.diagnosis.data.noise import noise as instrument_noise
from dolfingrip.diagnosis.inference import alternatives
from dolfingrip.diagnosis.inference.arrays import Vector
from dolfingrip.diagnosis.inference.noise import ChannelNoise
from dolfingrip.diagnosis.inference.noise_estimate import from_repeats
from dolfingrip.diagnosis.inference.repeats import places
from dolfingrip.diagnosis.problem import noise_keys

LONG: Final = 1e6
"""Correlation over the whole run, in seconds."""

PART_OF_RUN: Final = 1 / 3
"""Over which correlated noise is supposed to forget, where nothing tells."""


@dataclass(frozen=True)
class NoiseModel:
    """The noise that was taken, and the others that it might be.

    Attributes:
        noise: by column of a test.
        others: models of the noise by name, that which was taken first; alone where it is known.
        prior: probability of each.
        sentences: where it comes from.
    """

    noise: Mapping[str, ChannelNoise]
    others: Mapping[str, Mapping[str, ChannelNoise]]
    prior: Mapping[str, float]
    sentences: tuple[str, ...]


def noise_model(
    measurement: Measurement,
    index: pd.DataFrame,
    value: Vector,
    simulated: Vector,
    kept: np.ndarray,
) -> NoiseModel:
    """The noise of the readings that are kept.

    Args:
        measurement: with what the laboratory tells.
        index: table of the n readings.
        value, simulated: shape (n,).
        kept: their places in ``measurement.listed()``, shape (n,).
    """
    told = instrument_noise(measurement)
    keys = noise_keys(index)
    noise: dict[str, ChannelNoise] = {}
    sentences = list(told.sentences)
    sizes, correlations = True, True
    place = places(index)
    levelled = _levelled(index, value, simulated, place)
    for (experiment, column), part in index.reset_index(drop=True).groupby(
        ["experiment", "channel"], sort=False
    ):
        at = part.index.to_numpy()
        found = from_repeats(index.iloc[at], levelled[at], place[at])
        guessed = any(
            "guess" in sentence and f"noise of {column} in {experiment}" in sentence
            for sentence in told.sentences
        )
        lab_tells = bool((told.correlated[kept[at]] > 0).any())
        for key in dict.fromkeys(keys[at]):
            one = at[keys[at] == key][0]
            noise[key] = _of_channel(told, kept[one], found.noise if found and guessed else None)
            if found and not lab_tells and found.noise.correlated_std:
                noise[key] = ChannelNoise(
                    noise[key].std, found.noise.correlated_std, found.noise.length
                )
        if found and not lab_tells:
            sentences.append(_repeats_say(str(column), str(experiment), found.noise, found.freedom))
        sizes &= bool(found) or not guessed
        correlations &= bool(found) or lab_tells
    if sizes and correlations:
        return NoiseModel(noise, {alternatives.BELIEVED: noise}, {alternatives.BELIEVED: 1.0},
                          tuple(sentences))  # fmt: skip
    models = alternatives.alternatives(noise, part_of_run_s(index))
    if sizes:
        models = {k: models[k] for k in (alternatives.BELIEVED, alternatives.CORRELATED)}
        models |= alternatives.in_part(noise, part_of_run_s(index))
    sentences.append(
        "neither the laboratory nor repeats tell "
        + ("" if sizes else "how large the noise is and ")
        + "whether it drifts along a run: the verdict is an average over "
        + ", ".join(f'"{name}"' for name in models)
    )
    prior = {name: alternatives.EVERY_PRIOR[name] for name in models}
    return NoiseModel(noise, models, prior, tuple(sentences))


def part_of_run_s(index: pd.DataFrame) -> float:
    """Over which correlated noise is supposed to forget."""
    lasting = float(index.groupby("run")["time_s"].agg(np.ptp).median())
    return max(PART_OF_RUN * lasting, 1e-3)


def _levelled(index: pd.DataFrame, value: Vector, simulated: Vector, place: np.ndarray) -> Vector:
    """Readings as they would be where repeats are brought to exactly the same value."""
    frame = pd.DataFrame({"place": place, "simulated": simulated})
    mean = frame.groupby("place")["simulated"].transform("mean").to_numpy()
    scale = float(value @ simulated) / max(float(simulated @ simulated), 1e-300)
    return np.asarray(value - scale * (simulated - mean))


def _of_channel(told: InstrumentNoise, at: int, repeats: ChannelNoise | None) -> ChannelNoise:
    if repeats is not None:
        return repeats
    lasting = float(told.correlation_time_s[at])
    return ChannelNoise(
        max(float(told.independent[at]), 1e-9),
        float(told.correlated[at]),
        lasting if np.isfinite(lasting) else LONG,
    )


def _repeats_say(column: str, experiment: str, noise: ChannelNoise, freedom: int) -> str:
    error = 100 / np.sqrt(2 * freedom)
    text = f"repeats of {experiment} show noise of {column} of {noise.std:.2g} (±{error:.0f} %)"
    if not noise.correlated_std:
        return f"{text}, independent from reading to reading"
    return (
        f"{text} and {noise.correlated_std:.2g} that drifts over {noise.length:.2g} s along a run"
    )
