"""Simulation-based calibration: ranks of true numbers, and how often what is probable is true.

Where cases are drawn from the analyser's priors, ranks of the truth among draws of the posterior
are uniform, and causes of inclusion probability p are there in the share p of cases (Talts et al.,
arXiv:1804.06788, 2018).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.stats import binom, kstest

from benchmarks.blind.score import interval

BINS = 10
EDGES = (0.002, 0.02, 0.1, 0.3, 0.7, 0.9, 1.0)


def draw(rows: Sequence[dict[str, str]], file: Path) -> None:
    """Three panels, and the figures as text."""
    picture, axes = plt.subplots(1, 3, figsize=(11, 3.4), layout="constrained")
    for axis, key, title in (
        (axes[0], "rank_modulus", "modulus"),
        (axes[1], "rank_cause", "first number of the cause"),
    ):
        ranks = np.array([float(row[key]) for row in rows if row[key]])
        low, high = binom.ppf([0.05, 0.95], len(ranks), 1 / BINS)
        axis.axhspan(low, high, color="0.88")
        axis.hist(ranks, bins=BINS, range=(0, 1), color="tab:blue", edgecolor="white")
        axis.set(xlabel="rank of the truth (–)", ylabel="cases (–)", xlim=(0, 1))
        axis.set_title(f"{title} (grey: 90 % of uniform ranks)", fontsize=9)
        p = kstest(ranks, "uniform").pvalue
        inside = np.mean((ranks >= 0.05) & (ranks <= 0.95))
        print(f"{title}: {len(ranks)} ranks, uniform with p = {p:.2f}, inside 90 %: {inside:.2f}")
    told, true = [], []
    for row in rows:
        hidden = set(row["hidden"].split())
        for each in row["inclusion"].split():
            name, _, p = each.partition(":")
            told.append(float(p))
            true.append(name in hidden)
    p, there = np.array(told), np.array(true)
    for low, high in pairwise(EDGES):
        own = (p >= low) & (p <= high) if high == 1.0 else (p >= low) & (p < high)
        if not own.any():
            continue
        hits = int(there[own].sum())
        a, b = interval(hits, int(own.sum()))
        axes[2].errorbar(p[own].mean(), hits / own.sum(),
                         yerr=[[hits / own.sum() - a], [b - hits / own.sum()]], fmt="o",
                         color="tab:blue", capsize=3)  # fmt: skip
        print(f"inclusion {low:g} to {high:g}: told {p[own].mean():.3f}, true {hits} of {own.sum()}"
              f" = {hits / own.sum():.3f} ({a:.3f}–{b:.3f})")  # fmt: skip
    axes[2].plot([0, 1], [0, 1], color="0.6", lw=1)
    axes[2].set(xlabel="inclusion probability told (–)", ylabel="share that is there (–)",
                title="causes", xlim=(-0.02, 1.02), ylim=(-0.02, 1.02))  # fmt: skip
    picture.savefig(file, dpi=110)
