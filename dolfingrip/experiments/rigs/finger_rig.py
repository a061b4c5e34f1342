"""The rig of a pressurised finger, free or against the plate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import ClassVar

import numpy as np
from mpi4py import MPI

from dolfingrip.channels import AMBIENT_KPA, LARGEST_STRETCH, supply_of
from dolfingrip.config import Config
from dolfingrip.experiments import ballooning, protocol
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.results.doubts import of_law
from dolfingrip.experiments.rigs.finger import Adds, FingerModel, build, nothing
from dolfingrip.experiments.rigs.let_go import LetGo
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.perturbation import ParameterPerturbation, perturbations
from dolfingrip.experiments.rigs.pneumatics import MM3, longest_step_s
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.experiments.rigs.tip_load import compliance_mm_per_N
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.files.run import PlatePose
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import CONTROL
from dolfingrip.mechanics.path.failure import Failure, FailureKind
from dolfingrip.mechanics.path.greatest import greatest
from dolfingrip.mechanics.path.path import LoadPath, Observer
from dolfingrip.mechanics.readings.integrals import Integral
from dolfingrip.mechanics.readings.tip import TipDisplacement
from dolfingrip.parameter import Parameter
from dolfingrip.sections.geometry.geometry import Geometry


class FingerRig(Rig):
    """Controls a finger's pressure or volume, and reads it.

    Args:
        config: configuration that was asked for.
        finger: model of the finger.
        observation: readings of the finger.
        profile: takes the time of each phase.

    Attributes:
        hold: what holds the tip before it is let go; None if nothing does.
    """

    specimen_name: ClassVar = "finger"

    def __init__(
        self, config: Config, finger: FingerModel, observation: Observation, profile: Profile
    ) -> None:
        super().__init__(Newton(finger.model, config.solver, profile), finger)
        self._config = config
        self._finger, self.pressures, self.air = finger, finger.pressures, finger.air
        self._observation = observation
        self.readings = observation.readings
        self.from_rest = observation.from_rest
        self._tared = False
        self._driven = Integral(finger.model, CONTROL, finger.driven)
        self._rest_mm3 = self._volume_mm3()  # of the cavity at rest
        balloon = ballooning.forecast(config)
        self._forecast_kPa = np.inf if balloon is None else balloon.pressure_kPa
        self._borne_kPa = 0.0  # pressure up to which the forecast is not believed again
        self._greatest_stretch = np.inf if balloon is None else balloon.stretch
        self._balloons = "the walls balloon"  # in more words once the maximum is found
        self.hold: LetGo | None = None

    @classmethod
    def built(
        cls,
        config: Config,
        comm: MPI.Comm,
        profile: Profile,
        *,
        plate: bool,
        adds: Adds = nothing,
        made_for: Geometry | None = None,
    ) -> FingerRig:
        """Build the rig of the configuration's finger.

        For ``adds`` see :func:`finger.build`, for ``made_for`` :func:`undeformed.straight`.

        Raises:
            ConfigError: on every rank, one line about a bad mesh or geometry.
        """
        with profile.phase("mesh"):
            domain = load_domain(config, comm, made_for)
        hold = LetGo(config.release)
        with profile.phase("forms"):
            adds = hold.added if config.release.acts else adds
            finger = build(config, domain, plate=plate, adds=adds)
            observation = Observation(finger)
        made = cls(config, finger, observation, profile)
        made.hold = hold if config.release.acts else None
        made.place_load = None if config.release.held_x_mm is None else hold
        return made

    @property
    def _by_pressure(self) -> bool:
        """True if the pressure is prescribed, and not the cavity's volume."""
        return self._finger.model is self._finger.by_pressure

    @property
    def quantity(self) -> str:
        return "volume" if CONTROL in self._finger.model.controls else "pressure"

    @property
    def jumps(self) -> bool:
        config = self._config.experiment
        return config.snaps and (config.control != "auto" or not self._by_pressure)

    def longest(self) -> dict[str, float]:
        longest = {}
        if self._config.experiment.dynamic or self._config.solver.max_step_s is not None:
            longest["time_s"] = self._config.solver.max_step_s or LONGEST_S
        elif self._finger.air is not None:
            longest["time_s"] = longest_step_s(self._finger.air)
        if self._by_pressure or (self._finger.air and not self._finger.air.air.syringe):
            supplies = ("pressure_kPa", *(supply_of(name).name for name in self._config.cavity.own))
            return {**dict.fromkeys(supplies, self._config.solver.max_step_kPa), **longest}
        ratio = self._config.experiment.step_volume_ratio
        return {CONTROL: ratio * self._rest_mm3, **longest}

    def controls(self, stop: Stop) -> Mapping[str, float]:
        if CONTROL not in self._finger.model.controls:
            return {"pressure_kPa": stop.value, **stop.others, "time_s": stop.time_s}
        unit_mm3 = MM3 if self._config.protocol.volume_ml else self._rest_mm3
        return {CONTROL: self._rest_mm3 + unit_mm3 * stop.value, "time_s": stop.time_s}

    @property
    def from_rest_shape(self) -> bool:
        return put_at_rest(self._finger)

    def start(self, path: LoadPath, first: Stop) -> Failure | None:
        """Bring the finger to rest: unpressurised, hanging, with the plate at its gap from there.

        A weightless finger is at rest as it is built; its first stop is solved for from there.
        """
        failure = None
        if self.from_rest_shape:
            failure = go_to_rest(self._finger, self.newton, path.observers)
            if self._finger.air is not None:
                self._finger.air.begin()
            elif not self._by_pressure:
                self._finger.model.controls[CONTROL].set(self._volume_mm3())
        elif self._by_pressure and (first.value != 0 or any(first.others.values())):
            failure = path.advance(UNPRESSURISED).failure
        elif self.hold is None:
            return None
        self._tare()
        if self.hold is not None and failure is None:
            failure = self._held(self.hold, path.observers)
        return failure

    def _held(self, hold: LetGo, observers: Sequence[Observer]) -> Failure | None:
        """Hold the tip as the configuration asks for, for a long time; it tells why it is not held.

        The load that holds a place is found by a secant.
        """
        release, model = self._config.release, self._finger.model
        hold.load_N, hold.holds = release.load_x_N, True
        failure = settle(self.newton, observers)
        if failure is not None or release.held_x_mm is None:
            return failure
        tip = TipDisplacement(model, "x")
        compliance = compliance_mm_per_N(self.newton.linear(), tip)
        near_mm = NEAR_TIP * self._config.geometry.length_mm
        for _ in range(SECANTS):
            before_mm = tip.value()
            off_mm = release.held_x_mm - before_mm
            if failure is not None:
                return failure
            if abs(off_mm) < near_mm:
                self.held(tip.value)
                return None
            more_N = off_mm / compliance
            hold.load_N += more_N
            failure = settle(self.newton, observers)
            compliance = (tip.value() - before_mm) / more_N
        return Failure(FailureKind.ITERATION_LIMIT, model.state().controls)

    def _volume_mm3(self) -> float:
        """Present volume of all cavities with the experiment's pressure, each by its ratio."""
        return self._driven.value()

    def continuation(self, failure: Failure) -> Sequence[Stop]:
        """Stops under volume control from the present state on, if that was asked for."""
        ended = failure.kind in (FailureKind.TIME_LIMIT, FailureKind.CONTACT)
        if self._config.experiment.control != "auto" or not self._by_pressure or ended:
            return ()
        finger = self._finger
        growth = self._volume_mm3() / self._rest_mm3 - 1
        stops = protocol.stops_by_volume(self._config, growth, finger.model.time_s)
        if stops:
            finger.control_volume()
            self.newton = self.newton.of(finger.model)
        return stops

    @property
    def softening(self) -> str:
        return f"{self._balloons}, and the finger goes soft here"

    def advice(self, failure: Failure) -> str:
        """Settings that inflate the finger by its cavity's volume beyond a limit point.

        With ``control = "auto"`` a failure does not tell whether it is a limit point.
        """
        if not self._by_pressure or failure.kind in (FailureKind.TIME_LIMIT, FailureKind.CONTACT):
            return ""
        automatic = self._config.experiment.control == "auto"
        said = protocol.advice(self._config, self._volume_mm3() / self._rest_mm3)
        if automatic or failure.kind is FailureKind.LIMIT_POINT:
            return said
        if failure.last_good["pressure_kPa"] < SOONEST * self._forecast_kPa:
            return ""
        return f"the walls may balloon, near {self._forecast_kPa:.2g} kPa by estimate; {said}"

    def over(self) -> bool:
        """Return whether volume control has reached the largest pressure, which ends the path."""
        config = self._config.experiment
        goes_on = config.control == "auto" and not self._by_pressure
        return goes_on and self._finger.cavity.value >= config.max_pressure_kPa

    def _tare(self) -> None:
        """Count readings from the present state."""
        model, plate = self._finger.model, self._finger.plate
        self._observation.tare()
        x, y, z = (TipDisplacement(model, axis).value() for axis in "xyz")
        self.sag_mm = (x, 0.0 if model.domain.half else y, z)
        self._finger.rest = model.state()
        self._rest_mm3 = self._volume_mm3()
        if plate is not None:
            place = float(plate.unloaded.value)
            self.plate = PlatePose(tuple(place * plate.normal), tuple(plate.normal))
        self._tared = True
        self.tared()

    def read(self) -> dict[str, float]:
        if not self._tared:
            self._tare()
        readings = self._observation.read()
        self.gaps_mm.append(self._observation.gaps_mm)
        return {**self.shown(self._config, readings), **self.further()}

    def perturbations(
        self, config: Config, parameters: Sequence[Parameter]
    ) -> Sequence[ParameterPerturbation]:
        return perturbations(parameters, config, self._finger)

    def foreseen(self, attempted: Mapping[str, float]) -> bool:
        """Return whether walls may balloon below a pressure, by the forecast.

        Folds that touch may hold a finger in another stable state, which is looked for unless the
        pressure is far beyond the forecast.
        """
        config = self._config.experiment
        if not self._by_pressure or not (config.snaps or config.control == "auto"):
            return False
        folds = self._config.geometry.gaps().intervals
        near = (PAST if folds else SOONEST) * self._forecast_kPa
        return attempted["pressure_kPa"] > max(near, self._borne_kPa)

    def passable(self, attempted: Mapping[str, float]) -> bool:
        """Return whether equilibrium goes on at a falling pressure beyond this state.

        Where walls may balloon it looks as far as the run is asked to go, so that one search tells
        it for all readings. A finger that may jump is left at the greatest pressure, where no stage
        of a supply is in between.
        """
        finger, ratio = self._finger, self._config.cavity.ratio
        driven = [name for name in finger.site.domain.cavities if ratio(name)]
        if not self._by_pressure or not driven:
            return False
        if self._config.experiment.control == "auto":
            return self.foreseen(attempted)  # the volume is controlled soon, or now
        model, good, fall = finger.model, finger.model.state(), BALLOONS if self.jumps else FALL
        model.prescribe(attempted)
        wanted_kPa, foreseen = finger.cavity.value, self.foreseen(attempted)
        model.restore(good)
        if wanted_kPa <= finger.cavity.value:
            return False
        sought_kPa = max(wanted_kPa, self._config.of_experiment_kPa[1]) if foreseen else wanted_kPa
        settings = self._config.solver, sought_kPa, fall
        peak = greatest(model, finger.cavity, finger.driven, *settings, self._stretched)
        if peak is not None and peak[0] > wanted_kPa:
            self._borne_kPa = peak[0]
            return False
        if peak is not None and self.jumps:
            pressure_kPa, top = peak
            model.restore(top)
            stretch = self._largest_stretch()
            walls = f"the walls of {' and '.join(driven)} balloon"
            said = f"{walls} at {pressure_kPa:.3g} kPa, stretch {stretch:.2g}"
            self._balloons = "; ".join([said, *of_law(self._config, stretch)])
            if top.controls["pressure_kPa"] != pressure_kPa:
                model.restore(good)
        elif foreseen:
            self._borne_kPa = 2 * wanted_kPa
        return peak is not None

    def _largest_stretch(self) -> float:
        return self._observation.elongation.values()[LARGEST_STRETCH.name]

    def _stretched(self) -> bool:
        """Return whether walls have the stretch of a balloon's maximum, where no folds may snap."""
        folds = self._config.geometry.gaps().intervals
        return not folds and self._largest_stretch() >= self._greatest_stretch


BALLOONS, FALL = 0.01, 1e-4
"""Part of the greatest pressure by which it falls beyond a limit point: of a finger that may jump,
as a fold that snaps makes it fall less, and of one that does not."""

SOONEST = 0.5
"""Pressure by that at which walls are forecast to balloon, from which on they may: the forecast is
good to a factor of two."""

PAST = 1.25
"""Pressure by that at which walls are forecast to balloon, from which on folds do not help."""

LONGEST_S = 0.02
"""Longest step in time of a finger with inertia, if no other is asked for."""

LONG_S = 1e9
"""Time after which a material that relaxes has relaxed."""

SECANTS = 30
"""Steps in which the load that holds a tip is found."""

NEAR_TIP = 1e-7
"""Distance by the finger's length from a place at which the tip is held there."""

UNPRESSURISED = {"pressure_kPa": 0.0, "time_s": 0.0}


def has_weight(finger: FingerModel) -> bool:
    """Return whether gravity deforms the finger at rest."""
    return bool(finger.config.gravity.acceleration_m_s2)


def put_at_rest(finger: FingerModel) -> bool:
    """Return whether the plate's gap counts from the shape at rest, else from the undeformed one.

    A finger without weight, and without trapped air of another pressure than the air around, stays
    as it is built until a load comes. What a regulator lets in at zero is a load.

    Args:
        finger: model of the finger.
    """
    if has_weight(finger):
        return True
    cavities = finger.config.cavity.all.values()
    return any(cavity.closed and cavity.closed_at_kPa != AMBIENT_KPA for cavity in cavities)


def settle(newton: Newton, observers: Sequence[Observer] = ()) -> Failure | None:
    """Come to rest without pressure after a long time, which ends as the clock shows 0 s.

    Args:
        newton: solver of a finger's model.
        observers: called after each converged step.

    Returns:
        Why it did not come to rest; None if it did.
    """
    before = newton.model.state()
    before.controls["time_s"] = -LONG_S
    newton.model.restore(before)
    longest = {"pressure_kPa": newton.settings.max_step_kPa}
    return LoadPath(newton, longest, observers=observers).advance(UNPRESSURISED).failure


def go_to_rest(
    finger: FingerModel, newton: Newton, observers: Sequence[Observer] = ()
) -> Failure | None:
    """Let the finger hang without the plate, then put the plate at its gap from the skin.

    Args:
        finger: model of the finger, which is undeformed.
        newton: solver of its model; under volume control it comes to rest under pressure control.
        observers: called after each converged step.

    Returns:
        Why it did not come to rest; None if it did.
    """
    model, plate = finger.model, finger.plate
    if model is not finger.by_pressure:
        newton = Newton(finger.by_pressure, newton.settings, newton.profile)
    if plate is not None:
        plate.retract()
    failure = settle(newton, observers)
    if plate is not None:
        plate.put()
        model.accept_step()  # effects remember where the plate stands
    return failure


@contextmanager
def at_rest(finger: FingerModel) -> Iterator[None]:
    """Put the finger into its state ``rest``, without the plate, for the time of a context.

    Args:
        finger: model of a finger, in any state; it returns to this state at the end.
    """
    model, plate = finger.model, finger.plate
    now = model.state()
    places = None if plate is None else (float(plate.offset.value), float(plate.unloaded.value))
    model.restore(finger.rest)
    if plate is not None:
        plate.retract()
    try:
        yield
    finally:
        if plate is not None and places is not None:
            offset, unloaded = places
            plate.put(unloaded)
            plate.offset.value = offset
        model.restore(now)
