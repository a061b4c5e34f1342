"""A measurement: readings of specimens in experiments, with the set-up of each.

measurement = read([Path("finger.csv"), Path("coupons.csv")])
measurement.readings          # pandas: a row for each row of the files
measurement.tests             # a SpecimenTest for each specimen in each experiment of each file
measurement.listed          # pandas: a row for each single reading; all arrays of a
                              # diagnosis are aligned with it

Of coupons readings between toe and the largest strain are compared, of a finger those up to the
pressure that the laboratory tells, if any; and of either not too many.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from dolfingrip.channels import (
    CHANNELS,
    CHORD_ANGLE,
    PRESSURE,
    VOLUME,
    cavity_of_supply,
    of_line,
    supply_of,
)
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data import clock, table
from dolfingrip.diagnosis.data.clock import moves
from dolfingrip.diagnosis.data.lab_setup import CENTRES, LabSetup, SetupFile
from dolfingrip.diagnosis.data.motion import motion, smallest_change, travel
from dolfingrip.diagnosis.data.table import CONTROL, READING_COLUMNS, of_markers, read_by
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.sections.section import Role


@dataclass(frozen=True, slots=True)
class SpecimenTest:
    """One specimen in one experiment of one file.

    Attributes:
        number: its place in ``Measurement.tests`` and its number in the column ``test``.
        file: the CSV file.
        experiment: ``bending``, ``blocked_force``, ``coupon`` or ``vibration``.
        specimen: name of the finger or coupon.
        setup: set-up of the laboratory.
        supplies: columns of all pressures where cavities have supplies of their own, the one that
            moves farthest first.
        by_volume: whether a pump's volume is prescribed in place of a pressure.
    """

    number: int
    file: Path
    experiment: str
    specimen: str
    setup: LabSetup
    supplies: tuple[str, ...] = ()
    by_volume: bool = False

    @property
    def of_finger(self) -> bool:
        """Return whether pressures or volumes are prescribed."""
        return CONTROL[self.experiment] == PRESSURE.name

    @property
    def small_vibrations(self) -> bool:
        """Return whether frequencies and damping ratios are read."""
        return "modes" in EXPERIMENTS[self.experiment].parts

    @property
    def prescribed(self) -> str:
        """Column of what all cavities have in common, or of a coupon's travel."""
        return VOLUME.name if self.by_volume else CONTROL[self.experiment]

    @property
    def controls(self) -> tuple[str, ...]:
        """Columns of all that is prescribed."""
        return self.supplies or (self.prescribed,)

    @property
    def control(self) -> str:
        """Column of the control: ``displacement_mm``, or the pressure that moves farthest."""
        return self.controls[0]

    @property
    def sigma(self) -> float:
        """Standard deviation of the gauge of what is prescribed, in its unit; 0 where not told."""
        return self.setup.noise.get(self.prescribed, 0.0)

    def applied(self, config: Config) -> Config:
        """``config`` with the set-up of the laboratory.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        sections = dict(self.setup.sections)
        if self.small_vibrations:  # what is felt in motion is felt
            sections["experiment"] = {"dynamic": True}
        if self.by_volume:
            sections["experiment"] = {**sections.get("experiment", {}), "control": "volume"}
        return config.changed(**sections) if sections else config

    def configured_rate(self, config: Config) -> float:
        """Rate of its ramps where nobody told one, in the unit of the control per second."""
        applied = self.applied(config)
        return (applied.experiment.rate_kPa_per_s if self.of_finger
                else applied.coupon.rate_mm_per_s)  # fmt: skip

    def __str__(self) -> str:
        return f"{self.experiment} of {self.specimen} ({self.file.name})"


@dataclass
class Measurement:
    """The readings of a measurement.

    Attributes:
        readings: a row for each row of the files: ``test``, ``line`` in the file, ``experiment``,
            ``specimen``, ``cycle``, ``branch``, ``leg``, ``time_s``, ``pressure_kPa``,
            ``volume_ml``, ``displacement_mm``, the columns of readings and those of supplies of
            single cavities, NaN where absent. Rows of a test stand in the order in which they were
            read; ``time_s`` is never absent. Branch, leg and cycle follow from control and time
            (:mod:`dolfingrip.diagnosis.data.motion`); cycles are as told where several are told.
        tests: by their numbers.
        warnings: sentences on suspicions about the data, for the verdict.
        policy: numbers that it is read, simulated and compared by.
    """

    readings: pd.DataFrame
    tests: Sequence[SpecimenTest]
    warnings: list[str] = field(default_factory=list)
    policy: Policy = Policy()

    def __post_init__(self) -> None:
        """Find how the control moved in each test."""
        self.readings = self.readings.assign(leg=0)
        for test in self.tests:
            legs, cycles = 0, self.rows(test.number).groupby("cycle", sort=False)
            for _, rows in cycles:
                values = [rows[name].to_numpy() for name in test.controls]
                moves = motion(values, rows["time_s"].to_numpy(), test.sigma, self.policy)
                moves["leg"] += legs
                legs = int(moves["leg"].max()) + 1
                for name in ("branch", "leg", *(["cycle"] if len(cycles) == 1 else [])):
                    self.readings.loc[rows.index, name] = moves[name].to_numpy()

    def applied(self, config: Config) -> list[Config]:
        """``config`` with the set-up of each test."""
        return [test.applied(config) for test in self.tests]

    def lab(self, config: Config) -> Config:
        """``config`` with the set-up of a test, of one with weight where there is one.

        Args:
            config: that set-ups are differences from.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        return max(self.applied(config), key=lambda config: config.gravity.acceleration_m_s2)

    def read_by(self, experiment: str) -> tuple[str, ...]:
        """Columns that an experiment reads, with those of markers that were seen.

        Args:
            experiment: its name.
        """
        return read_by(experiment, self.columns)

    def rows(self, test: int) -> pd.DataFrame:
        """The rows of a test."""
        return self.readings[self.readings["test"] == test]

    def of(self, tests: Iterable[int], first: int = 0) -> Measurement:
        """Only these tests, numbered in their order.

        Args:
            tests: their numbers.
            first: number of the first of them.
        """
        number = {old: first + place for place, old in enumerate(sorted(tests))}
        rows = self.readings[self.readings["test"].isin(number)].reset_index(drop=True)
        kept = [replace(t, number=number[t.number]) for t in self.tests if t.number in number]
        renumbered = rows.assign(test=rows["test"].map(number))
        return Measurement(renumbered, kept, self.warnings, self.policy)

    def reading(self, values: np.ndarray) -> Measurement:
        """Replace single readings, (n,); those that are NaN are left out."""
        rows = self.readings.copy()
        places = self.listed[["row", "column"]].itertuples(index=False)
        for (row, column), value in zip(places, values, strict=True):
            rows.loc[rows.index[row], column] = value
        return Measurement(rows, self.tests, self.warnings, self.policy)

    @property
    def columns(self) -> list[str]:
        """Columns of readings: those of the format, and those of markers that were seen."""
        return [*READING_COLUMNS, *of_markers(self.readings)]

    def repeated(self) -> dict[int, int]:
        """Tests with the very readings of an earlier one, by number, and that one's number."""
        repeats: dict[int, int] = {}
        seen: dict[tuple[str, bytes], int] = {}
        for test in self.tests:
            rows = self.rows(test.number)[[*test.controls, *self.columns]].to_numpy()
            key = test.experiment, np.nan_to_num(rows, nan=np.inf).tobytes()
            if seen.setdefault(key, test.number) != test.number and np.nan_to_num(rows).any():
                repeats[test.number] = seen[key]
        return repeats

    def ramp_rate(self, test: SpecimenTest) -> float | None:
        """Median rate of a test's ramps, in the unit of the control per second, to two digits.

        It is None if the test has no ramp.
        """
        rows = self.rows(test.number)
        ramp = rows[rows["branch"] != "hold"]
        steps, times = np.abs(np.diff(ramp[test.control])), np.diff(ramp["time_s"])
        moving = (steps > 0) & (times > 0)
        if not moving.any():
            return None
        return float(f"{np.median(steps[moving] / times[moving]):.2g}")

    @cached_property  # a fit asks for it at each place that it tries
    def listed(self) -> pd.DataFrame:
        """A row for each single reading, in the order of the rows and, within one, of columns.

        ``row`` is the place in ``readings``, ``column`` which reading it is, ``value`` its value in
        the column's unit, ``control`` the pressure (kPa) or displacement (mm) that it was read at.
        The table is made once; a caller that changes it takes a copy.
        """
        wide = self.readings[self.columns].to_numpy()
        row, column = np.nonzero(~np.isnan(wide))
        rows = self.readings.iloc[row].reset_index(drop=True)
        control = np.full(len(rows), np.nan)
        for test in self.tests:
            mine = (rows["test"] == test.number).to_numpy()
            control[mine] = rows.loc[mine, test.control]
        return pd.DataFrame({
            "row": row,
            "column": np.array(self.columns, dtype=object)[column],
            "value": wide[row, column],
            **{name: rows[name] for name in
               ("test", "experiment", "specimen", "cycle", "branch", "leg", "time_s")},
            "control": control,
        })  # fmt: skip

    def collected(self, rows: Rows, missing: float = np.nan) -> np.ndarray:
        """Single readings (n,) by those at the rows.

        Args:
            rows: of some tests.
            missing: value of single readings that are not among them.

        Returns:
            (…, n) where those at the rows are (…, rows).
        """
        row = self.listed["row"].to_numpy()
        shapes = [array.shape[:-1] for columns in rows.values() for array in columns.values()]
        readings = np.full((*np.broadcast_shapes(*shapes), len(row)), missing)
        for tests, columns in rows.items():
            for key in self._places.keys() & product(tests, columns):
                at = self._places[key]
                readings[..., at] = columns[key[1]][..., row[at]]
        return readings

    def channels(self) -> dict[str, np.ndarray]:
        """Tell which single readings are of each column, (n,) of bool."""
        column = self.listed["column"].to_numpy()
        return {str(name): column == name for name in dict.fromkeys(column)}

    def rms(self, values: np.ndarray) -> dict[str, float]:
        """Root mean square of single readings, (n,), by channel; NaN does not count."""
        finite = np.isfinite(values)
        return {
            name: float(np.sqrt(np.mean(values[at & finite] ** 2))) if (at & finite).any() else 0.0
            for name, at in self.channels().items()
        }

    @cached_property
    def _places(self) -> dict[tuple[int, str], np.ndarray]:
        """Where readings stand in the list, by test and column."""
        return dict(self.listed.groupby(["test", "column"]).indices)


Rows = Mapping[tuple[int, ...], Mapping[str, np.ndarray]]
"""Readings at all rows of a measurement, (…, rows), by the tests that they are of and by column."""


def largest(values: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return the largest absolute value of each one's channel, (n,); infinite where it is 0.

    Args:
        values: readings, (n,).
        columns: channel of each, (n,).
    """
    by_channel = pd.Series(np.abs(values)).groupby(columns).transform("max").to_numpy()
    return np.where(by_channel > 0, by_channel, np.inf)


def in_proportion(measurement: Measurement) -> np.ndarray:
    """Single readings (n,) that are proportional to the modulus: coupons' forces.

    How far a coupon narrows depends neither on its modulus nor on its cross-section.
    """
    listed = measurement.listed
    scaled = [name for name in measurement.columns if CHANNELS[name].in_proportion]
    return ((listed["experiment"] == "coupon") & listed["column"].isin(scaled)).to_numpy()


def shows_memory(*measurements: Measurement) -> bool:
    """Tell whether readings of the same experiments show what a material remembers.

    They do where something is unloaded or waits, or is loaded at two rates, one of twice the other,
    and where it vibrates.
    """
    rates: dict[str, list[float]] = defaultdict(list)
    for measurement in measurements:
        for test in measurement.tests:
            rows = measurement.rows(test.number)
            if (rows["branch"] != "loading").any() or test.small_vibrations:
                return True
            rate = measurement.ramp_rate(test)
            if rate is not None:
                rates[test.experiment].append(rate)
    return any(max(ramps) > 2 * min(ramps) for ramps in rates.values())


def read(
    files: Sequence[Path], config: Config | None = None, policy: Policy = Policy()
) -> Measurement:
    """Read measured CSV files, each with the TOML of the same stem.

    Args:
        files: of the CSVs.
        config: configuration that set-ups are differences from; default: the reference finger.
        policy: numbers that they are read, simulated and compared by.

    Raises:
        ConfigError: one line naming the file, the line or key, the value and what is allowed.
    """
    if not files:
        raise ConfigError("no data; allowed: at least one CSV file")
    base = config or Config()
    tests: list[SpecimenTest] = []
    tables: list[pd.DataFrame] = []
    warnings: list[str] = []
    seen: set[Path] = set()
    for file in files:
        if file.resolve() in seen:
            raise ConfigError(f"{file}: given twice; allowed: each file once")
        seen.add(file.resolve())
        setup_file = SetupFile(file)
        rows = table.read(file, setup_file.experiments)
        setup_file.check_specimens(set(rows["specimen"]))
        warnings += setup_file.warnings
        for (experiment, specimen), group in rows.groupby(["experiment", "specimen"], sort=False):
            setup = setup_file.of(str(experiment), str(specimen))
            test = SpecimenTest(
                len(tests), file, str(experiment), str(specimen), setup, _supplies(group),
                by_volume=bool(group[VOLUME.name].notna().all()),
            )  # fmt: skip
            try:
                test.applied(base)
            except ConfigError as error:
                raise ConfigError(f"{setup_file.file}: {error}") from None
            _check_markers(test, group, base)
            if config is not None:
                _check_supplies(test, config)
            timed, doubts = _timed(test, group, base, policy)
            warnings += doubts + _doubts(test, group)
            if moves(test.applied(base)) and not test.small_vibrations:
                warnings += clock.gap(timed, test.control, f"{file}: {experiment} of {specimen}")
            tests.append(test)
            tables.append(timed.assign(test=test.number))
    tests = _of_one_body(tests)
    readings = pd.concat(tables, ignore_index=True)
    measurement = Measurement(readings, tests, warnings, policy)
    warnings += [line for test in tests for line in _contradictions(measurement, test, readings)]
    return measurement


def _of_one_body(tests: Sequence[SpecimenTest]) -> list[SpecimenTest]:
    """Tests of fingers with what any file tells of their body: all tests are of the same one."""
    bodies = [n for n, cls in Config.classes().items() if cls.role is Role.BODY]
    of_body = {
        key: test.setup.nuisances[key]
        for test in reversed(tests)
        for key in test.setup.told
        if test.of_finger and key.split(".")[0] in bodies and "." in key
    }
    return [
        replace(test, setup=replace(test.setup, nuisances=of_body | dict(test.setup.nuisances)))
        if test.of_finger
        else test
        for test in tests
    ]


def _check_markers(test: SpecimenTest, rows: pd.DataFrame, base: Config) -> None:
    """Check that the set-up has the markers that were seen.

    Raises:
        ConfigError: one line that names the column and what is allowed.
    """
    there = test.applied(base).camera.markers
    columns = {channel.name for channel in of_line(there, curve=False)}
    for name in of_markers(rows):
        if rows[name].notna().any() and name not in columns:
            words = (
                f"those of {there} markers, which camera.markers = {there} of the set-up has"
                if there
                else "with camera.markers in the set-up, the number of markers from clamp to tip"
            )
            raise ConfigError(f"{test.file}: column {name}: allowed: {words}")


def _check_supplies(test: SpecimenTest, config: Config) -> None:
    """Check that the configured finger has the cavities whose supplies were read.

    Raises:
        ConfigError: one line that names the column and what is allowed.
    """
    applied = test.applied(config)
    supplies = [supply_of(name).name for name in applied.geometry.cavities()]
    for name in filter(cavity_of_supply, test.supplies):
        if not applied.mesh.file and name not in supplies:
            raise ConfigError(
                f"{test.file}: column {name}: the configured finger has no such cavity; allowed: "
                f"{', '.join(supplies)}, or --config with a finger that has it"
            )


def _supplies(rows: pd.DataFrame) -> tuple[str, ...]:
    """Columns of the pressures of a test where cavities have supplies of their own."""
    supplies = [name for name in rows if cavity_of_supply(name) and rows[name].notna().all()]
    ranges = {name: float(np.ptp(rows[name])) for name in (PRESSURE.name, *supplies)}
    return tuple(sorted(ranges, key=lambda name: -ranges[name])) if supplies else ()


def _contradictions(measurement: Measurement, test: SpecimenTest, raw: pd.DataFrame) -> list[str]:
    """Doubt rows whose control moves against the branch that they are named after.

    Rows of suction may be named after the pressure, which falls as the suction grows.
    """
    if test.supplies:  # a branch is that of one of them
        return []
    rows = measurement.rows(test.number)
    named, moves = raw.loc[rows.index, "branch"], rows["branch"]
    against = named.map({"loading": "unloading", "unloading": "loading"}) == moves
    against &= rows[test.control] >= 0
    does = {"loading": "falls", "unloading": "rises"}
    return [
        f"{test}: {len(part)} rows are named {branch}, the first in line {part['line'].iloc[0]:.0f}"
        f", but {test.control} {does[branch]} there; they are taken as it moves"
        for branch, part in rows[against & (named != moves)].groupby(named)
    ]


def _timed(
    test: SpecimenTest, rows: pd.DataFrame, base: Config, policy: Policy
) -> tuple[pd.DataFrame, list[str]]:
    """Rows with times, which follow from the rate if there are no time stamps."""
    if rows["time_s"].notna().all():
        return rows, []
    controls = rows[list(test.controls)].to_numpy()
    held = (rows["branch"] == "hold").to_numpy()
    change = max(smallest_change(control, test.sigma, policy) for control in controls.T)
    if (held[1:] & held[:-1] & (np.abs(np.diff(controls, axis=0)).max(axis=1) <= change)).any():
        raise ConfigError(f"{test.file}: time_s: missing; allowed: in each row, as there are waits")
    rate, doubts = None if test.by_volume else test.setup.rate, []
    if rate is None:
        rate, unit = test.configured_rate(base), CHANNELS[test.control].unit
        if test.by_volume:  # the pump takes as long as a ramp to the highest pressure
            most_kPa = test.applied(base).experiment.max_pressure_kPa
            rate *= float(np.abs(controls).max() or 1.0) / (most_kPa or 1.0)
        doubts = [f"{test}: neither time_s nor a rate is told; {rate:g} {unit}/s is assumed"]
    steps = np.max([travel(control, test.sigma, policy) for control in controls.T], axis=0)
    return rows.assign(time_s=np.cumsum(steps) / rate), doubts


def _doubts(test: SpecimenTest, rows: pd.DataFrame) -> list[str]:
    """Sentences on parts of the set-up that the simulation does not have."""
    setup = test.setup
    other = setup.chord != CENTRES and "camera" not in setup.sections
    if rows[CHORD_ANGLE.name].notna().any() and other:
        start, end = setup.chord
        return [
            f"{test}: chord_angle_deg is from {start} to {end}; simulated is the line from the "
            "clamp's centre to the tip's, which turns by another factor"
        ]
    return []


def selected(measurement: Measurement, config: Config) -> tuple[Measurement, list[str]]:
    """The measurement without the rows that are not compared, and why, a sentence each.

    Raises:
        ConfigError: one line, where nothing of a finger's readings would be left.
    """
    repeated, policy = measurement.repeated(), measurement.policy
    notes = [
        f"{measurement.tests[again]} has the very readings of {measurement.tests[first]}: they are "
        "compared once"
        for again, first in repeated.items()
    ]
    if repeated:
        measurement = measurement.of({test.number for test in measurement.tests} - {*repeated})
    keep = np.ones(len(measurement.readings), dtype=bool)
    readings = measurement.readings.copy()
    for test in measurement.tests:
        rows = measurement.rows(test.number)
        finger = test.of_finger
        of_coupon = partial(_of_coupon, test, rows, config, policy.toe)
        for inside, why in _of_finger(test, rows) if finger else of_coupon():
            if inside.all() or (not finger and inside.sum() < policy.few):
                continue
            notes.append(why)
            readings.loc[rows.index[~inside], measurement.columns] = np.nan
            # a row stays where what comes later depends on the way
            if finger and not inside[(~inside).argmax() :].any():
                keep[rows.index[~inside]] = False
    every = math.ceil(len(readings) / policy.most_readings)
    if every > 1:
        number = measurement.readings.groupby(["test", "cycle", "branch"]).cumcount().to_numpy()
        keep &= number % every == 0
        notes.append(f"of dense readings one in {every} is compared")
    if not notes:
        return measurement, []
    readings = readings[keep].reset_index(drop=True)
    kept = Measurement(readings, measurement.tests, measurement.warnings, policy)
    return kept, list(dict.fromkeys(notes))


def _of_coupon(
    test: SpecimenTest, rows: pd.DataFrame, config: Config, least: float
) -> Iterator[tuple[np.ndarray, str]]:
    """Iterate over a coupon's rows that are compared, and why the others are left out."""
    coupon = test.applied(config).coupon
    strain = rows["displacement_mm"].to_numpy() / coupon.gauge_length_mm
    most = f"above a strain of {coupon.max_strain:g} (coupon.max_strain: fingers stretch less)"
    yield strain <= coupon.max_strain, f"coupons: readings {most} are left out"
    toe = f"below a strain of {least:g} (grips settle there)"
    yield strain >= least, f"coupons: readings {toe} are left out"


def _of_finger(test: SpecimenTest, rows: pd.DataFrame) -> Iterator[tuple[np.ndarray, str]]:
    """Iterate over a finger's rows that are compared, and why the others are left out.

    Raises:
        ConfigError: no row is left.
    """
    highest = math.inf if test.by_volume else test.setup.max_pressure_kPa
    pressure_kPa = rows[list(test.controls)].max(axis=1).to_numpy()
    least = float(pressure_kPa.min())
    if highest < least:
        raise ConfigError(
            f"max_pressure_kPa = {highest:g} of {test.file.name}: below all readings of "
            f"{test.specimen}; allowed: from {least:g} kPa on"
        )
    limit = f"{highest:g} kPa (max_pressure_kPa of {test.file.name})"
    yield pressure_kPa <= highest, f"readings above {limit} are left out"


def joined(*measurements: Measurement) -> Measurement:
    """Put measurements one after the other, without tests that nothing is read of.

    Args:
        measurements: one or more; the warnings and numbers of the first hold.
    """
    numbered: list[Measurement] = []
    for measurement in measurements:
        first = sum(len(part.tests) for part in numbered)
        numbered.append(measurement.of(set(measurement.listed["test"]), first))
    rows = pd.concat([part.readings for part in numbered], ignore_index=True)
    tests = [test for part in numbered for test in part.tests]
    return Measurement(rows, tests, measurements[0].warnings, measurements[0].policy)
