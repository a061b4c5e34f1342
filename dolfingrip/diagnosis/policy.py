"""The numbers that a diagnosis decides by, all in one place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Policy:
    """Numbers by which readings are read, simulated, compared and told.

    A measurement and an inference carry one, and hand it on.

    Attributes:
        toe: nominal strain of a coupon below which grips and slack are measured, too (ASTM D638,
            annex on the toe).
        most_readings: in all; of more, every second, third, … row of each branch is taken.
        some_readings: that tell which specimens stand apart, at most.
        few: fewest places that tell anything: readings of a coupon, a wait, a column's sign or a
            noise, stops of a ramp; of a curve's degree, or of a period.
        dense: smallest number of rows of a branch whose differences are noise.
        differences: order of these differences.
        slip: a ratio counts as a known factor if it differs by no more than this factor. It allows
            for errors of a simple model and for a response that is not proportional.
        cycles: of a proposed protocol: in the last two a material has settled.
        no_slip: a ratio within this factor of 1 is no slip.
        more_even: by how much more even than a travel another column has to be.
        gauge: standard deviation of a gauge that nobody told, by the largest value: stops are round
            within it, and no closer. Ten of it are a motion.
        most_stops: of a ramp; fewer where rows are closer to one another than the gauge's noise
            allows to tell.
        rests: standard deviations of the gauge that a row of a wait may be off it.
        waits: a wait lasts longer than a ramp takes for so many of the smallest changes: one that
            turns takes two of them.
        certain: standard deviations of the gauge that are a change for certain.
        alike: difference by the largest value up to which two places or ways count as the same.
        steps: round numbers between 1 and 10.
        fineness: distance of stops by the unit that they are rounded to, at least: 25 kPa apart
            they are multiples of 5 kPa. Usual distances (5, 10, 12.5, 20, 25, 50) are far from
            where the unit changes.
        mesh_share: part of the difference between graded and ungraded mesh that the mesh may be off
            by. Without it the mesh alone is taken for an effect: 5.6 standard deviations on the
            reference finger (angle 0.3°, force 0.02 N).
        part: of what is missed or measured, from which on it is worth a word or a finer mesh.
        largest_cog_mm: offset of a design's centre of gravity, at most (the paper's limit).
        play: standard deviation of what lags behind either way, by its channel.
        turns: parts of the range within which a play turns.
        fewest_periods: of a wave in the range of the control: fewer are like a smooth effect.
        farther: by how much farther a coupon is pulled than before, where laws that agree so far
            part.
        set_up_min: minutes that setting up takes, an engineering guess: what is mounted already, a
            new coupon, a camera, the plate or the clamp.
        odds: by which what is asked for has to be more probable than what it is compared with.
        strengths: of a cause that are supposed in a planned measurement: the middles of so many
            parts of its prior, which are equally probable.
        leading: hypotheses, designs or artefacts at the top that are looked at, at most.
        prior_by_size: probability of none, one and two effects of the catalogue; alike among those
            of a size.
        discrepancy_off: probability that nothing but noise is left beside the named causes.
        discrepancy_levels: sizes of what the catalogue does not have, by the root mean square of a
            channel; they share the rest of the probability evenly. No law follows one specimen
            better than by the smallest.
        load_length: length of the discrepancy's kernel, by the largest load.
        wait_weight, wait_s: a wait of t counts as a path of ``wait_weight`` ln(1 + t/``wait_s``).
        visible: standard deviations of an effect's change, after nuisances, below which it counts
            as absent.
        unlikely: standard deviations that are implausible.
        credible: part of the probability that a set of causes has to hold.
        claimed: probability from which on a cause is named: odds of three to one.
        nearly: probability that is nearly one: of intervals, and of both of two sets that are named
            rather than one.
        doubt: causes are no more probable than this power of the share that they explain. What the
            catalogue lacks is often followed by one of its causes: of 98 outsiders in coupons nine
            were claimed with the square, three with this power, one with the sixth, with which
            fewer pairs would be named.
        rare: probability that a number is of the wide part of its prior.
        reach: largest |ζ| of a cause's numbers.
        shape_reach: largest |ζ| of numbers of a body's shape.
        stiffest: largest factor of a finger's moduli, and 1 by the smallest.
        training: simulations by the number of arguments, where they cost nothing.
        tries: how often a model or a set of causes is simulated until its numbers follow, at most.
        most_fits: fits of pairs, and fits that are simulated, at most.
        matters: probability from which on something is simulated, compared or told.
        exactly: ln of evidence that may be missed.
        hopeless: ln of evidence beyond which a lead or a lag decides nothing more.
        first_error: part of what a cause explains that its derivatives, or its first simulation,
            may miss.
        start: ζ from which fits start, to either side, and their longest step.
        draws: samples of a hypothesis that is near the leading one, at a time.
        freedom: degrees of freedom of the multivariate t that is drawn from: its tails are wider
            than those of most densities.
        widths: factors of the priors of causes' numbers by which the answer is tried; the larger
            ones are factors of the specimens' scatter, too.
        specimen_shapes: sizes of the individual scatter of specimens that are compared, by the
            channel's root mean square.
        smooth: degree of the smooth curve through the readings, at most.
        invisible: root mean square change, by the noise, below which no reading feels a cause.
    """

    toe: float = 0.02
    most_readings: int = 1200
    some_readings: int = 300
    few: int = 4
    dense: int = 20
    differences: int = 3
    slip: float = 1.8
    cycles: int = 3
    no_slip: float = 2.5
    more_even: float = 4.0
    gauge: float = 0.002
    most_stops: int = 25
    rests: float = 3.5
    waits: float = 3.0
    certain: float = 5.0
    alike: float = 0.03
    steps: tuple[float, ...] = (1.0, 2.0, 5.0)
    fineness: float = 3.5
    mesh_share: float = 0.3
    part: float = 0.25
    largest_cog_mm: float = 3.0
    play: float = 0.02
    turns: tuple[float, ...] = (0.003, 0.02, 0.05, 0.1)
    fewest_periods: float = 3.0
    farther: float = 3.0
    set_up_min: Mapping[str, float] = field(
        default_factory=lambda: {"ramp": 2.0, "coupon": 15.0, "camera": 10.0, "plate": 5.0}
    )
    odds: float = 20.0
    strengths: int = 10
    leading: int = 5
    prior_by_size: tuple[float, float, float] = (0.25, 0.60, 0.15)
    discrepancy_off: float = 0.85
    discrepancy_levels: tuple[float, ...] = (0.003, 0.01, 0.03, 0.1)
    load_length: float = 0.35
    wait_weight: float = 0.3
    wait_s: float = 5.0
    visible: float = 2.0
    unlikely: float = 3.0
    credible: float = 0.99
    claimed: float = 0.75
    nearly: float = 0.9
    doubt: float = 4.0
    rare: float = 0.1
    reach: float = 3.3
    shape_reach: float = 5.0
    stiffest: float = 4.0
    training: tuple[int, ...] = (16, 40, 40, 50, 60, 80)
    tries: int = 6
    most_fits: int = 24
    matters: float = 0.03
    exactly: float = 0.1
    hopeless: float = 15.0
    first_error: float = 0.15
    start: float = 1.5
    draws: int = 400
    freedom: int = 5
    widths: tuple[float, ...] = (0.5, 2.0, 4.0)
    specimen_shapes: tuple[float, ...] = (0.0, 0.001, 0.002, 0.004, 0.007, 0.012, 0.02, 0.04)
    smooth: int = 6
    invisible: float = 0.05

    @property
    def log_odds(self) -> float:
        """ln of the odds that what is asked for needs."""
        return math.log(self.odds)

    @property
    def levels(self) -> dict[float, float]:
        """Prior probability of each level of the discrepancy."""
        share = (1 - self.discrepancy_off) / len(self.discrepancy_levels)
        return {0.0: self.discrepancy_off, **dict.fromkeys(self.discrepancy_levels, share)}
