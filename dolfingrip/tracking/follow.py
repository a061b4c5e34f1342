"""Dots from frame to frame: each keeps its identity, and a lost one has no place."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.spatial.distance import cdist

from dolfingrip.tracking.dots import Box, Colour, Dot, find
from dolfingrip.tracking.frames import Image


@dataclass(frozen=True, slots=True)
class FollowPolicy:
    """When a dot is the one that was there before.

    Attributes:
        gate: largest distance from where it is expected, by the smallest distance of two dots.
        shape: least and largest distance of neighbours by that in the first frame.
        whole: share of the area before above which all of a dot is seen.
        grown: share above which it is lost.
        stretch: largest change of the logarithm of a distance between two states.
        turn: largest turn (rad) of the way from one dot to the next.
        bend: standard deviation (rad) of such a turn from one of the curvature before.
        lost: cost of a lost dot, as the square of standard deviations.
        chains: of dots along a finger that are followed at once.
        margin: of the part of a frame that is searched, by the largest distance of neighbours.
    """

    gate: float = 0.45
    shape: tuple[float, float] = (0.6, 1.5)
    whole: float = 0.92
    grown: float = 1.3
    stretch: float = 0.25
    turn: float = 1.2
    bend: float = 0.3
    lost: float = 9.0
    chains: int = 30
    margin: float = 1.2


POLICY: Final = FollowPolicy()


@dataclass(frozen=True, slots=True)
class _Chain:
    """Dots along a finger, as far as they are found.

    Attributes:
        cost: how far they are from a smooth line, as the square of standard deviations.
        numbers: of the dots; None where one is lost.
        here: (2,) place of the last one.
        heading: (2,) way to it.
        curvature: there (1/px).
    """

    cost: float
    numbers: tuple[int | None, ...]
    here: np.ndarray
    heading: np.ndarray
    curvature: float


class Follower:
    """Follows dots.

    Args:
        colour: of the dots.
        places: (n, 2) in the first frame, px.
        fingers: numbers of the dots along each finger.
    """

    def __init__(self, colour: Colour, places: np.ndarray, fingers: list[np.ndarray]) -> None:
        self._colour, self._last = colour, places.astype(float)
        self._start, self._fingers = self._last.copy(), fingers
        self._speed = np.zeros_like(self._last)
        self._areas = np.full(len(places), colour.area_px)  # of each when all of it is seen
        self._new = True
        self._lost: np.ndarray = np.zeros(len(places), dtype=int)
        self._others = np.repeat(self._last[None], len(places), axis=0)  # when each was seen last
        self._pairs = [(a, b) for finger in fingers for a, b in pairwise(finger)]
        steps = np.array([np.linalg.norm(places[a] - places[b]) for a, b in self._pairs])
        self._steps, self._margin = steps, POLICY.margin * float(steps.max())
        away = cdist(places, places)
        np.fill_diagonal(away, np.inf)
        self._gate = POLICY.gate * float(away.min())

    @property
    def radius_px(self) -> float:
        """Radius of a dot."""
        return float(np.sqrt(np.median(self._areas) / np.pi))

    def step(self, image: Image) -> tuple[np.ndarray, np.ndarray]:
        """Find the dots in the next frame.

        Args:
            image: in blue, green and red.

        Returns:
            Places (n, 2) in px, NaN where one is lost, and the share of each that is seen (n,).
        """
        expected = self._last + self._speed
        dots = find(image, self._colour, self._box(expected, image))
        px, seen = np.full_like(self._last, np.nan), np.zeros(len(self._last))
        kept = np.flatnonzero(self._lost == 0)
        dots = self._take(dots, kept, expected, px, seen)
        self._check(px, seen, expected)
        lost = np.flatnonzero(self._lost > 0)
        if len(lost):
            now = np.flatnonzero(np.isfinite(px[:, 0]))
            for i in lost:  # it has moved as its nearest neighbours have
                near = now[np.argsort(np.linalg.norm(self._last[now] - self._last[i], axis=1))[:2]]
                if len(near):
                    expected[i] = self._last[i] + (px[near] - self._others[i][near]).mean(axis=0)
            self._take(dots, lost, expected, px, seen)
            self._check(px, seen, expected)
        self._remember(px)
        self._new = False
        return px, seen

    def anew(self, image: Image) -> tuple[np.ndarray, np.ndarray]:
        """Find the dots in a picture of another state, along each finger from its clamped end.

        That end is where a dot is nearest to one of the picture before; from there each next dot
        is at the distance that it had, where the curvature changes least.

        Args:
            image: in blue, green and red.

        Returns:
            As of :meth:`step`.
        """
        most_px = POLICY.grown * self._colour.area_px  # a larger one is two
        dots = [
            dot
            for dot in find(image, self._colour)
            if dot.seen > POLICY.whole / 2 and dot.area_px < most_px
        ]
        px, seen = np.full_like(self._last, np.nan), np.zeros(len(self._last))
        if not dots:
            return px, seen
        places = np.array([dot.centre_px for dot in dots])
        ways = []
        for finger in self._fingers:
            away = [
                np.linalg.norm(places - self._start[end], axis=1).min() for end in finger[[0, -1]]
            ]
            ways.append(finger if away[0] <= away[1] else finger[::-1])
        free = np.ones(len(places), dtype=bool)
        while ways:  # the chain that is surest takes its dots first
            chains = [self._chain(way, places, free) for way in ways]
            surest = int(np.argmin([chain.cost for chain in chains]))
            for who, which in zip(ways.pop(surest), chains[surest].numbers, strict=True):
                if which is not None:
                    px[who], seen[who], free[which] = places[which], dots[which].seen, False
        return px, seen

    def _chain(self, way: np.ndarray, places: np.ndarray, free: np.ndarray) -> _Chain:
        """The likeliest dots along a finger, whose curvature changes little from dot to dot."""
        steps = np.diff(self._start[way], axis=0)
        chains = [_Chain(0.0, (), self._start[way[0]], steps[0], 0.0)]
        lengths = np.linalg.norm(steps, axis=1)
        for i in range(len(way)):
            grown = []
            length = lengths[i - 1] if i else 0.0
            span = (length + (lengths[i - 2] if i > 1 else 0.0)) / 2
            for chain in chains:
                arms = places - chain.here
                away = np.linalg.norm(arms, axis=1)
                if i:
                    turns = np.arctan2(
                        chain.heading[0] * arms[:, 1] - chain.heading[1] * arms[:, 0],
                        arms @ chain.heading,
                    )
                    stretch = np.log(np.maximum(away, 1e-9) / length)
                    fits = (np.abs(stretch) < POLICY.stretch) & (np.abs(turns) < POLICY.turn)
                    bent = (turns - chain.curvature * span) / POLICY.bend
                    cost = bent**2 + (3 * stretch / POLICY.stretch) ** 2
                else:
                    turns, fits, cost = np.zeros(len(places)), away < self._gate, 0 * away
                for number in np.flatnonzero(fits & free):
                    if number not in chain.numbers:
                        ahead = arms[number] if i else chain.heading
                        bend = turns[number] / span if i else 0.0
                        longer = (*chain.numbers, int(number))
                        total = chain.cost + cost[number]
                        grown.append(_Chain(total, longer, places[number], ahead, bend))
                turn = chain.curvature * span
                turned = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
                ahead = turned @ chain.heading
                here = chain.here + length * ahead / np.linalg.norm(ahead)
                lost = (*chain.numbers, None)
                grown.append(_Chain(chain.cost + POLICY.lost, lost, here, ahead, chain.curvature))
            chains = sorted(grown, key=lambda chain: chain.cost)[: POLICY.chains]
        return chains[0]

    def _box(self, expected: np.ndarray, image: Image) -> Box:
        margin = self._margin * (1 + 0.5 * self._lost.max())
        low = np.maximum(np.floor(expected.min(axis=0) - margin), 0).astype(int)
        high = np.minimum(np.ceil(expected.max(axis=0) + margin), np.array(image.shape[1::-1]))
        high = np.maximum(high.astype(int), low + 4)
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    def _take(
        self,
        dots: list[Dot],
        wanted: np.ndarray,
        expected: np.ndarray,
        px: np.ndarray,
        seen: np.ndarray,
    ) -> list[Dot]:
        """Give dots to those that are wanted; returns the rest."""
        if not dots or not len(wanted):
            return dots
        away = cdist(expected[wanted], [dot.centre_px for dot in dots])
        sizes = np.abs(np.log([dot.area_px / self._colour.area_px for dot in dots]))
        cost = np.where(away < self._gate, away / self._gate + 0.3 * sizes, 1e3)
        taken = set()
        for i, j in zip(*linear_sum_assignment(cost), strict=True):
            if cost[i, j] < 1e3:
                who, area = wanted[i], dots[j].area_px
                if self._new:
                    self._areas[who] = area
                share = area / self._areas[who]
                taken.add(j)
                if share > POLICY.grown:  # it is one with something of its colour
                    continue
                px[who] = dots[j].centre_px
                seen[who] = min(share, 1.0) if share < 1 / POLICY.whole else 1 / share
                if share > POLICY.whole:  # light and perspective change slowly
                    self._areas[who] *= 1 + 0.1 * (min(share, 1.05) - 1)
        return [dot for j, dot in enumerate(dots) if j not in taken]

    def _check(self, px: np.ndarray, seen: np.ndarray, expected: np.ndarray) -> None:
        """Lose the less expected one of neighbours whose distance no finger has."""
        for (a, b), step in zip(self._pairs, self._steps, strict=True):
            length = np.linalg.norm(px[a] - px[b]) / step
            if length < POLICY.shape[0] or length > POLICY.shape[1]:
                off = [np.linalg.norm(px[i] - expected[i]) for i in (a, b)]
                worse = (a, b)[int(np.argmax(off))]
                px[worse], seen[worse] = np.nan, 0.0

    def _remember(self, px: np.ndarray) -> None:
        there = np.isfinite(px[:, 0])
        again = there & (self._lost == 0)
        self._speed[again] = 0.6 * (px - self._last)[again] + 0.4 * self._speed[again]
        self._speed[~again] = 0.0
        self._lost = np.where(there, 0, self._lost + 1)
        self._last[there] = px[there]
        for i in np.flatnonzero(there):
            self._others[i] = np.where(there[:, None], px, self._last)
