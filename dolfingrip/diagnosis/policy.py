"""The numbers that a diagnosis decides by, all in one place."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final


@dataclass(frozen=True, slots=True)
class DataPolicy:
    """How measured tables are read.

    Attributes:
        toe: nominal strain of a coupon below which grips and slack are measured, too (ASTM D638,
            annex on the toe).
        fewest_of_coupon: readings of a coupon that are left at least, or none is left out.
        most: readings in all; of more, every second, third, … row of each branch is taken.
        slip_within: a ratio counts as a known factor if it differs by no more than this factor. It
            allows for errors of a simple model and for a response that is not proportional.
        no_slip: a ratio within this factor of 1 is no slip.
        slip_leaves: largest part of the unexplained change that a scale may leave.
        fewest_of_loading: rows of a first loading that tell how evenly it went.
        fewest_of_sign: readings that tell whether a column falls as the control rises.
        falls: correlation of both below which it does.
        uneven: distance from a line in time, by its range, from which on a travel is not even.
        more_even: by how much more even another column has to be.
        readings_of_wait: readings of a planned wait, whose distances grow.
        dense: smallest number of rows of a branch whose differences are noise.
        differences: order of these differences.
        same_place: difference of the controls of repeated rows, by their range, up to which these
            tell the noise.
        fewest_differences: of which a standard deviation is estimated.
    """

    toe: float = 0.02
    fewest_of_coupon: int = 5
    most: int = 1200
    slip_within: float = 1.8
    no_slip: float = 2.5
    slip_leaves: float = 0.6
    fewest_of_loading: int = 6
    fewest_of_sign: int = 4
    falls: float = -0.95
    uneven: float = 0.04
    more_even: float = 4.0
    readings_of_wait: int = 5
    dense: int = 20
    differences: int = 3
    same_place: float = 0.05
    fewest_differences: int = 4


@dataclass(frozen=True, slots=True)
class RoutePolicy:
    """Where along a test it is simulated.

    Attributes:
        most, fewest: stops of a ramp; the fewer where rows are closer to one another than the
            gauge's noise allows to tell.
        most_of_wait: stops of a wait.
        closest: least distance of two stops of a ramp, by the range of the control.
        jump: smallest change of a control that is a motion of the finger, by its largest value.
        gauge: standard deviation of a gauge of pressures that nobody told, by the largest value:
            stops are round within it.
        noisiest: standard deviation of a gauge that nobody told, by the largest value of the
            control, at most.
        waits: a wait lasts longer than a ramp takes for so many of the smallest changes: one that
            turns takes two of them.
        rests: standard deviations of the gauge that a row of a wait may be off it.
        certain: standard deviations of the gauge that are a change for certain.
        alike: difference of the ends of two tests' ramps, by the largest value, up to which one
            simulation serves both.
        alike_in_time: the same of how long a ramp lasts, by its time.
        fineness: distance of stops by the unit that they are rounded to, at least: 25 kPa apart
            they are multiples of 5 kPa. Usual distances (5, 10, 12.5, 20, 25, 50) are far from
            where the unit changes.
        clear: part of a unit of a laboratory's stops that these may be off it.
        tells: standard deviations of the gauge that such a unit has at least.
        straight: part of a ramp's time by which its stops may be off one rate.
        turns: part of the force at a stop that a straight line from there is below zero at the stop
            before, from which on the force begins between the two.
        outside: how far beyond the stops that were reached rows are read, by their range.
    """

    most: int = 25
    fewest: int = 4
    most_of_wait: int = 8
    closest: float = 2e-3
    jump: float = 0.02
    gauge: float = 0.002
    noisiest: float = 0.005
    waits: float = 3.0
    rests: float = 3.5
    certain: float = 5.0
    alike: float = 0.03
    alike_in_time: float = 0.1
    fineness: float = 3.5
    clear: float = 0.4
    tells: float = 6.0
    straight: float = 0.1
    turns: float = 0.1
    outside: float = 0.05


@dataclass(frozen=True, slots=True)
class ModelPolicy:
    """How the model without causes is simulated.

    Attributes:
        mesh_share: part of the difference between graded and ungraded mesh that the mesh may be off
            by. Without it the mesh alone is taken for an effect: 5.6 standard deviations on the
            reference finger (angle 0.3°, force 0.02 N).
        edges: elements at edges of the meshes in between, by the graded mesh's.
    """

    mesh_share: float = 0.3
    edges: tuple[float, ...] = (4.0, 2.0)


@dataclass(frozen=True, slots=True)
class ArtefactPolicy:
    """Which artefacts of instruments are looked for.

    Attributes:
        most: in all.
        jump: standard deviation of a jump, by the root mean square of its channel; of a control by
            its largest value.
        play: the same of what lags behind either way.
        turns: parts of the range within which it turns.
        wave: standard deviation of a wave of the control, by its range.
        fewest_periods: of a wave in the range of the control: fewer are like a smooth effect.
        periods: of these, at most.
        period_step: between two waves that are tried: one between them is off by a twentieth of a
            period at the end of the range.
        a_period: readings of a period, at least.
    """

    most: int = 4
    jump: float = 0.1
    play: float = 0.02
    turns: tuple[float, ...] = (0.003, 0.02, 0.05, 0.1)
    wave: float = 0.01
    fewest_periods: float = 3.0
    periods: float = 20.0
    period_step: float = 0.1
    a_period: float = 4.0


@dataclass(frozen=True, slots=True)
class AdditionPolicy:
    """Which measurements are proposed or planned, and what they are worth.

    Attributes:
        stops: readings of a ramp.
        slower: by how much a slow ramp is slower.
        hold_s: how long a wait lasts.
        other_gap_mm: by how much the plate is moved away.
        farther: by how much farther a coupon is pulled than before, where laws that agree so far
            part.
        set_up_min: minutes that setting up takes, an engineering guess: what is mounted already, a
            new coupon, a camera, the plate or the clamp.
        tied: expected ln of the Bayes factor below which two causes are not told apart.
        refutes: ln of the odds from which on a cause is refuted.
        enough: ln of the Bayes factor beyond which more decides nothing more.
        other_rate: ratio of two rates from which on they are different ones.
        model_error: relative error of a finger's simulation at conditions that nothing was measured
            at: independent between readings, so that no tie is split by less than a model can be
            trusted.
        law_error: the same of a coupon, which has no mesh: of any law.
        strengths: of a cause that are hidden in a planned measurement: the middles of so many parts
            of its prior, which are equally probable.
        noises: draws of everything else at each strength.
        rivals: how often what rivals a hidden cause is simulated at its best numbers.
        faint: length of a change, standard deviations, below which a draw of noise hardly makes a
            cause of it: that takes more than three.
    """

    stops: int = 10
    slower: float = 10.0
    hold_s: float = 60.0
    other_gap_mm: float = 2.0
    farther: float = 3.0
    set_up_min: Mapping[str, float] = field(
        default_factory=lambda: {"ramp": 2.0, "coupon": 15.0, "camera": 10.0, "plate": 5.0}
    )
    tied: float = math.log(20.0)
    refutes: float = math.log(1000.0)
    enough: float = 20.0
    other_rate: float = 2.0
    model_error: float = 0.01
    law_error: float = 0.005
    strengths: int = 8
    noises: int = 2
    rivals: int = 3
    faint: float = 1.5


@dataclass(frozen=True, slots=True)
class PagePolicy:
    """How much the pages say.

    Attributes:
        band: of the largest load, of which the page says where something is left.
        fits: likeliest hypotheses that are told.
        designs: leading designs that are computed once more with the extended model.
    """

    band: float = 0.25
    fits: int = 8
    designs: int = 5


@dataclass(frozen=True, slots=True)
class InferencePolicy:
    """Priors, emulators, search and decision.

    Attributes:
        prior_by_size: probability of none, one and two effects of the catalogue; alike among those
            of a size.
        discrepancy_off: probability that nothing but noise is left beside the named causes.
        discrepancy_levels: sizes of what the catalogue does not have, by the root mean square of a
            channel; they share the rest of the probability evenly.
        load_length: length of the discrepancy's kernel, by the largest load.
        path_length: length of its kernel along the path of the load, by the largest load.
        rough_length: length of its rough parts along load and path, by the largest load.
        wait_weight, wait_s: a wait of t counts as a path of ``wait_weight`` ln(1 + t/``wait_s``).
        visible_sigma: an effect whose change is smaller, after nuisances, counts as absent.
        credible: part of the probability that a set of causes has to hold.
        claimed: probability from which on a cause is named: odds of three to one.
        both: probability of both from which on two sets of causes are named rather than one.
        likelier: probability from which on a second cause is named beside a first, or a number of
            the model itself that is far out.
        doubt: causes are no more probable than this power of the share that they explain. What the
            catalogue lacks is often followed by one of its causes: of 98 outsiders in coupons nine
            were claimed with the square, three with this power, one with the sixth, with which
            fewer pairs would be named.
        implausible_width: prior standard deviation of a number of rig or finger that is
            implausible, by that of its ordinary prior.
        rare: probability that the strength of a cause is of the wide part of its prior, which is
            ``implausible_width`` times as wide as the ordinary one.
        mesh_decides: part of what the model is off by from which on the mesh's own error leaves
            nothing to decide.
        implausible_odds: odds that such a number is implausible.
        implausible_sigma: standard deviations from which on such a number is among the first
            lines.
        reach: largest |ζ| of an emulator.
        training: simulations by the number of arguments, where they cost nothing.
        tries: simulations of a set of causes at its best numbers, at most.
        matters: probability from which on a set of causes is simulated there.
        exactly: ln of evidence that extrapolation may miss where it is not.
        most_missed: standard deviations that extrapolation may miss, at most.
        shortest_step: shortest step of a simulation, by the longest; how far a path goes on beyond
            its last stop is not read.
        first_error: part of what a cause explains that its derivatives, or its first simulation,
            may miss.
        farther: simulations of causes whose best numbers lie beyond that, at most.
        stiffest: largest factor of a finger's moduli, and 1 by the smallest.
        scaled_by: the same of coupons, which moduli scale exactly.
        least_std: of the moduli's logarithm, by which its range is counted.
        passes: simulations of the model at other moduli, at most, until these follow the readings.
        coarse: part of a channel that the mesh of the causes may be off by.
        component_error: error of a reading that columns may leave, by its noise.
        law_misses: part of the largest reading that any elastic law misses of a material, root mean
            square: laws that miss less are not told apart.
        pairs: pairs of effects that are fitted well, the likeliest of all.
        pairs_level: levels of the discrepancy up to this one choose the pairs.
        hopeless: ln of how much less than the best evidence the likelihood of a pair may be.
        starts: ζ of the amplitudes from which a fit starts.
        shape_starts: ζ of the other numbers from which a fit starts.
        settled: ln of probability that the last step of a fit gains at most.
        coarsely_settled: the same where readings are drawn many times.
        kept: probability of causes by all readings from which on they are tried again where some
            readings are left out.
        draws: samples of a hypothesis that is near the leading one, at a time.
        effective: so many of the draws have to count as if they were alike in weight.
        adaptations: how often more are drawn until these do.
        steady: change of ln of the integral by one more time of drawing, at most.
        sampled: posterior probability from which on a hypothesis is sampled.
        pairs_by: factor of the prior odds of two causes by which the answer is tried.
        widths: factors of the priors of causes' numbers by which the answer is tried.
        predicted_log_odds: ln of the odds by which a cause has to predict what was left out better
            than the model without it.
        specimen_shapes: sizes of the individual scatter of specimens that are compared, by the
            channel's root mean square.
        specimen_scales: scatter of specimens' stiffness, by the reported one.
        some: readings that tell which specimens stand apart, at most; of more, every second, third,
            … is taken.
        apart: specimens that may stand apart together, at most.
        far: how far the curve of one that does is from the others', by the signal.
        scatters: scatter of specimens' stiffness by the reported one, from which on it is
            mentioned.
        own_slack: part of the variance of a coupon's slack that is its own; the rig has the rest.
        smooth: degree of the smooth curve through the readings, at most.
        common: numbers of the curve that specimens share in a branch, at most.
        single_shape: the first of these where there is one specimen.
        correction_length: of what an exact simulation tells of an emulator's error, in ζ.
        walls_reach: standard deviations that walls may be off by.
        simulated_fits: how many fits are simulated, at most.
        quick_fits: the same of a quick diagnosis.
        interval: probability that intervals hold.
        verified: probability of causes from which on they are held against exact simulations.
        invisible: root mean square change, by the noise, below which no reading feels a cause.
        closed_form_places: places along each number of a closed form.
        read_beyond: |ζ| that an emulator of a finger is read beyond what it was simulated at.
        step: of ζ, by which simulations of coupons are differentiated.
        freedom: degrees of freedom of the multivariate t that is drawn from: its tails are wider
            than those of most densities.
        wider: factors of the covariance that draws share: the wider ones find the ends of a ridge.
        compared: hypotheses that a next experiment is to tell apart, at most.
        rival: probability by the leading hypothesis' from which on one is among them.
    """

    prior_by_size: tuple[float, float, float] = (0.25, 0.60, 0.15)
    discrepancy_off: float = 0.85
    discrepancy_levels: tuple[float, ...] = (0.003, 0.01, 0.03, 0.1)
    load_length: float = 0.35
    path_length: float = 1.0
    rough_length: float = 0.3
    wait_weight: float = 0.3
    wait_s: float = 5.0
    visible_sigma: float = 2.0
    credible: float = 0.99
    claimed: float = 0.75
    both: float = 0.9
    likelier: float = 0.5
    doubt: float = 4.0
    implausible_width: float = 4.0
    rare: float = 0.1
    mesh_decides: float = 0.5
    implausible_odds: float = 0.1
    implausible_sigma: float = 3.0
    reach: float = 3.3
    training: tuple[int, ...] = (16, 40, 40, 50, 60, 80)
    tries: int = 6
    matters: float = 0.03
    exactly: float = 0.1
    most_missed: float = 6.0
    shortest_step: float = 1 / 8
    first_error: float = 0.15
    farther: int = 6
    stiffest: float = 4.0
    scaled_by: float = 1000.0
    least_std: float = 0.01
    passes: int = 5
    coarse: float = 0.25
    component_error: float = 0.03
    law_misses: float = 0.01
    pairs: int = 24
    pairs_level: float = 0.01
    hopeless: float = 15.0
    starts: tuple[float, ...] = (0.0, -1.5, 1.5)
    shape_starts: tuple[float, ...] = (-1.2, 1.2)
    settled: float = 1e-4
    coarsely_settled: float = 0.02
    kept: float = 1e-6
    draws: int = 400
    effective: float = 100.0
    adaptations: int = 12
    steady: float = 0.05
    sampled: float = 0.01
    pairs_by: float = 3.0
    widths: tuple[float, ...] = (0.5, 2.0, 4.0)
    predicted_log_odds: float = math.log(20.0)
    specimen_shapes: tuple[float, ...] = (0.0, 0.001, 0.002, 0.004, 0.007, 0.012, 0.02, 0.04)
    specimen_scales: tuple[float, ...] = (1.0, 2.0, 4.0)
    some: int = 300
    apart: int = 2
    far: float = 0.1
    scatters: float = 1.5
    own_slack: float = 0.5
    smooth: int = 6
    common: int = 24
    single_shape: float = 0.003
    correction_length: float = 1.0
    walls_reach: float = 5.0
    simulated_fits: int = 24
    quick_fits: int = 2
    interval: float = 0.9
    verified: float = 0.03
    invisible: float = 0.05
    closed_form_places: int = 9
    read_beyond: float = 0.2
    step: float = 0.01
    freedom: int = 5
    wider: tuple[float, ...] = (1.0, 9.0)
    compared: int = 5
    rival: float = 0.03


DATA: Final = DataPolicy()
ROUTES: Final = RoutePolicy()
MODEL: Final = ModelPolicy()
ARTEFACTS: Final = ArtefactPolicy()
ADDITIONS: Final = AdditionPolicy()
PAGE: Final = PagePolicy()
POLICY: Final = InferencePolicy()
