"""The numbers that a diagnosis decides by, all in one place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Policy:
    """Numbers of priors, emulators, search and decision.

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
            catalogue lacks is often followed by one of its causes: of coupons' causes beside which
            a tenth stays, half are the hidden ones.
        far: width of the prior of a number of rig or finger that is far from what was told, by
            what was told.
        far_odds: odds that such a number is far.
        far_sigma: standard deviations from which on such a number is told among the first lines.
        telling: part of what the model misses from which on a number that changes so much is, too.
        reach: largest |ζ| of an emulator.
        degrees: degree of its polynomials by the number of its arguments.
        training: simulations by the number of arguments, where they cost nothing.
        components: most columns of an emulator.
        curved_degree: degree of a finger's polynomials, at most.
        curved_share: most monomials by the number of values and derivatives.
        slope_weight: weight of a derivative by ζ beside a value.
        shortest_step: shortest step of a simulation, by the longest; how far a path goes on beyond
            its last stop is not read.
        first_error: part of what a cause explains that its first simulation alone may miss.
        finger_places: simulations of a finger by the number of a cause's arguments.
        far_places: simulations of a nuisance that is far from what was told.
        finger_reach: largest |ζ| that a finger is simulated at; of n numbers together it is so
            many times √(2/n).
        stiffest: largest factor of a finger's moduli, and 1 by the smallest.
        nodes: moduli at which a simulation that scales is read.
        recentred: steps of the moduli that all is simulated at, as a factor; the first coarse
            simulations serve so far to either side.
        near_enough: ratio of the fitted moduli and those that all is simulated at, at most.
        passes: simulations of the model at other moduli, at most, until these follow the readings.
        coarse: part of a channel that the mesh of the causes may be off by.
        component_error: error of a reading that columns may leave, by its noise.
        error_columns: columns of an emulator's error.
        pairs: pairs of effects that are fitted; the others are bounded from above.
        hopeless: ln of how much less than the best evidence the likelihood of a pair may be.
        starts: ζ of the amplitudes from which a fit starts.
        settled: ln of probability that the last step of a fit gains at most.
        nearly_settled: the same where readings are drawn many times.
        kept: probability of causes by all readings from which on they are tried again where some
            readings are left out.
        draws: samples of a hypothesis that is near the leading one, at a time.
        effective: so many of the draws have to count as if they were alike in weight.
        adaptations: how often more are drawn until these do.
        steady: change of ln of the integral by one more time of drawing, at most.
        sampled: posterior probability from which on a hypothesis is sampled.
        specimen_shapes: sizes of the individual scatter of specimens that are compared, by the
            channel's root mean square.
        specimen_scales: scatter of specimens' stiffness, by what was told.
        own_slack: part of the variance of a coupon's slack that is its own; the rig has the rest.
        smooth: degree of the smooth curve through the readings, at most.
        common: numbers of the curve that specimens share in a branch, at most.
        single_shape: the first of these where there is one specimen.
        surer: error of an emulator by that before, where a simulation has corrected it.
        mended_length: of what an exact simulation tells of an emulator's error, in ζ.
        walls_reach: standard deviations that walls may be off by.
        rounds: leading fits of a finger that are simulated, at most.
        interval: probability that intervals hold.
        exact: largest difference between an emulator and an exact simulation at a likely fit, by
            the noise; beyond it the emulator is trained anew about the fit.
        verified: probability of causes from which on they are held against exact simulations.
        near: standard deviations about a fit that it is trained in then.
        fewer: part of the simulations that do there.
        joint: probability from which on a pair of causes is simulated together.
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
    doubt: float = 2.0
    far: float = 4.0
    far_odds: float = 0.1
    far_sigma: float = 3.0
    telling: float = 0.25
    reach: float = 3.3
    degrees: tuple[int, ...] = (11, 12, 7, 5, 4, 4)
    training: tuple[int, ...] = (64, 400, 512, 512, 600, 900)
    components: int = 10
    curved_degree: int = 4
    curved_share: float = 0.7
    slope_weight: float = 0.5
    shortest_step: float = 1 / 8
    first_error: float = 0.15
    finger_places: tuple[int, ...] = (3, 5, 7, 8, 8, 9, 10)
    far_places: int = 6
    finger_reach: float = 2.5
    stiffest: float = 4.0
    nodes: int = 33
    recentred: float = 1.6
    near_enough: float = 1.3
    passes: int = 5
    coarse: float = 0.25
    component_error: float = 0.03
    error_columns: int = 3
    pairs: int = 40
    hopeless: float = 15.0
    starts: tuple[float, ...] = (0.0, -1.5, 1.5)
    settled: float = 1e-4
    nearly_settled: float = 0.02
    kept: float = 1e-6
    draws: int = 400
    effective: float = 100.0
    adaptations: int = 12
    steady: float = 0.05
    sampled: float = 0.01
    specimen_shapes: tuple[float, ...] = (0.0, 0.001, 0.002, 0.004, 0.007, 0.012, 0.02, 0.04)
    specimen_scales: tuple[float, ...] = (1.0, 2.0, 4.0)
    own_slack: float = 0.5
    smooth: int = 6
    common: int = 24
    single_shape: float = 0.003
    surer: float = 0.2
    mended_length: float = 1.0
    walls_reach: float = 5.0
    rounds: int = 6
    interval: float = 0.9
    exact: float = 0.5
    verified: float = 0.03
    near: float = 4.5
    fewer: float = 0.35
    joint: float = 0.01
    compared: int = 5
    rival: float = 0.03


POLICY: Final = Policy()
