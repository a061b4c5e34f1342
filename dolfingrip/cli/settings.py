"""The settings of each command, in the order in which a new user needs the commands."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import MISSING
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Final, Literal, get_args, get_origin

from dolfingrip.channels import Colour
from dolfingrip.cli.command import NOTHING, SHOWN, CommandSettings, argument, option
from dolfingrip.experiments.experiment import Experiment, Option
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.gripper import HIGHEST_KPA

Point = tuple[float, float, float]
Box = tuple[float, float, float, float, float, float]

_CAVITY_FILES: Final = (
    ".step", ".stp", ".brep", ".iges", ".igs", ".stl", ".obj", ".ply", ".3mf", ".vtk",
)  # fmt: skip


LARGEST_PRESSURE_KPA: Final = 1000.0
"""Pressure of a grasp that may be asked for, at most."""


def _assigned_pressures(texts: Sequence[str], flag: str) -> Mapping[str, Any]:
    """Read ``KEY=VALUE`` texts of the configuration, of which numbers are checked."""
    if not texts:
        return NOTHING
    from dolfingrip.parameter import check

    assignments = tables.assignments(texts, flag)
    check(assignments, flag)
    return assignments


def _uncertain(texts: Sequence[str], flag: str) -> Mapping[str, Any]:
    """Read ``KEY=STD`` texts, and what TOML files of measurements tell."""
    spreads: dict[str, Any] = {}
    for text in texts:
        if "=" in text:
            spreads |= tables.assignments([text], flag)
            continue
        from dolfingrip.diagnosis.data.lab_setup import SetupFile

        if Path(text).suffix not in (".toml", ".csv"):
            raise ConfigError(f"{flag} {text[:SHOWN]}: allowed: KEY=STD, or a measurement's TOML")
        stds = SetupFile(Path(text)).spreads()
        if not stds:
            allowed = "[nuisance] or [noise] in it, as modulus = 0.1 under [nuisance]"
            raise ConfigError(f"{flag} {text}: no standard deviation; allowed: {allowed}")
        spreads |= stds
    return spreads


def _names(texts: Sequence[str], flag: str) -> tuple[str, ...]:
    """Read names that are joined by commas."""
    return tuple(name.strip() for text in texts for name in text.split(","))


def _numbers(text: str, flag: str, allowed: str, count: int | None = None) -> tuple[Any, ...]:
    """Read numbers that are joined by commas, and as many of them as are asked for."""
    try:
        numbers = tuple(float(part) for part in text.split(",") if count or part.strip())
    except ValueError:
        numbers = None
    if numbers is None or count not in (None, len(numbers)):
        raise ConfigError(f"{flag} {text}: allowed: {allowed}")
    return numbers


def _pressures(texts: Sequence[str], flag: str) -> tuple[float, ...]:
    """Read pressures (kPa) that are joined by commas."""
    return _numbers(",".join(texts), flag, "pressures in kPa, as in 0,100,200")


def _points(texts: Sequence[str], flag: str) -> tuple[Point, ...]:
    """Read points, each three numbers that are joined by commas."""
    return tuple(_numbers(text, flag, "three numbers, as in 0,10,25.5", 3) for text in texts)


def _points_or_files(texts: Sequence[str], flag: str) -> tuple[Point | Path, ...]:
    """Read points, or files that exist."""
    return tuple(
        Path(text) if Path(text).suffix.lower() in _CAVITY_FILES else _points([text], flag)[0]
        for text in texts
    )


def _regions(texts: Sequence[str], flag: str) -> tuple[Box | str, ...]:
    """Read boxes, each of six numbers that are joined by commas, or names."""
    allowed = "six numbers, as in 0,0,0,20,20,10, or a name"
    return tuple(
        _numbers(text, flag, allowed, 6) if "," in text else text.lower() for text in texts
    )


_out = partial(option, help="Folder for results.", flags=("--out", "-o"), metavar="FOLDER")
_configfile = partial(
    option, help="Configuration: TOML, or a run.json; see `config`.", flags=("--config", "-c")
)
_changes = partial(
    option,
    help="Change a key of the configuration, e.g. finger.wall_mm=1.8; repeatable.",
    flags=("--set", "-s"),
    metavar="KEY=VALUE",
    read=_assigned_pressures,
)
_noise = partial(
    option,
    help="Standard deviation of a column's readings, in its unit, e.g. angle_deg=0.2; repeatable.",
    metavar="COLUMN=STD",
    read=tables.assignments,
)
_gradients = partial(option, help="Derive all readings by parameters: sensitivity.csv.")
_parameters = partial(option, help="Parameters of --gradients; default: all.", metavar="KEY,KEY,…")
_protocolfile = partial(option, help="Follow a TOML of ramps and waits, or a measurement's CSV.")
_specimen = partial(option, help="Follow this specimen of the CSV of --protocol.")
_pressure = partial(option, measured_in="kPa", above=0, most=LARGEST_PRESSURE_KPA)
_length = partial(option, measured_in="mm", above=0)
_rate = partial(option, measured_in="Hz", above=0)
_percent = partial(option, measured_in="%", above=0)
_workers = partial(option, help="Processes that simulate.", least=1)
_store = partial(option, help="Kept simulations; default: simulations/ in --out.", metavar="FOLDER")
_effects = partial(
    option, help="Effects to try; default: the whole catalogue.", metavar="NAME,NAME,…", read=_names
)
_surrogate = partial(argument, help="Folder of the surrogate.", metavar="SURROGATE")


class ConfiguredSettings(CommandSettings):
    """The settings of commands that begin with a configuration."""

    config: Path | None = _configfile(None)
    overrides: Mapping[str, Any] = _changes(NOTHING)


class DemoSettings(ConfiguredSettings):
    """Run both experiments on the reference finger and a small design loop, write a report.

    Example: dolfingrip demo --no-loop
    """

    out: Path = _out(Path("out/demo"))
    loop: bool = option(True, "Run the small design loop, too.")


class RunSettings(ConfiguredSettings):
    """Run one experiment; :func:`of_experiment` adds the experiment's own options."""

    experiment: ClassVar[Experiment]
    not_offered: ClassVar[Collection[str]] = ()

    out: Path = _out(Path("out"))
    render: tuple[float, ...] = option(
        (), "Draw the finger at these pressures.", metavar="kPa,kPa,…", read=_pressures
    )
    colour_by: Colour | None = option(
        None,
        "Field that colours pictures and video; default: displacement, and stretch in a grasp.",
    )
    cut: bool = option(False, "Cut open body and chambers in pictures and video, as for pressure.")
    video: bool | None = option(None, "Draw a video, .mp4 and .gif; default: of a grasp alone.")
    video_length: float | None = option(
        None,
        "Length of the video; default: 10 s, and its own time in a grasp or in motion.",
        measured_in="s",
        least=0.1,
        most=60,
    )
    video_turn: float | None = option(
        None, "Turn of the video's camera; default: 30°.", measured_in="°", least=-360, most=360
    )
    gradients: bool = _gradients(False)
    parameters: str | None = _parameters(None)
    mesh_check: bool = option(False, "Estimate the error that is due to the mesh.")
    bands: bool = option(False, "Compute intervals of the readings from what is not known exactly.")
    uncertain: Mapping[str, Any] = option(
        NOTHING,
        "Standard deviation for --bands in place of the usual one, e.g. modulus=0.1 or "
        "finger.wall_mm=0.05; or a measurement's TOML; repeatable.",
        metavar="KEY=STD|FILE",
        read=_uncertain,
    )
    protocol: Path | None = _protocolfile(None)
    specimen: str | None = _specimen(None)

    def own(self) -> dict[str, Any]:
        """Return the values of the experiment's own options, by name."""
        return {option.name: getattr(self, option.name) for option in self.experiment.options}


def of_experiment(experiment: Experiment) -> type[RunSettings]:
    """Return the settings of an experiment's command.

    Args:
        experiment: its options follow those that all experiments have.
    """
    absent = {
        "render": experiment.drawable,
        "cut": experiment.drawable or experiment.pictures != "finger",
        "gradients": experiment.gradients, "parameters": experiment.gradients,
        "mesh_check": experiment.mesh_check,
        "bands": experiment.gradients, "uncertain": experiment.gradients,
        "protocol": experiment.protocol, "specimen": experiment.protocol,
    }  # fmt: skip
    fields = [
        ("out", Path, _out(Path("out") / experiment.command)),
        *map(_field, experiment.options),
    ]
    namespace = {
        "__annotations__": {name: kind for name, kind, _ in fields},
        **{name: default for name, _, default in fields},
        "experiment": experiment,
        "not_offered": {name for name, offered in absent.items() if not offered},
    }
    return type(f"{type(experiment).__name__}Settings", (RunSettings,), namespace)


def _field(declared: Option) -> tuple[str, Any, Any]:
    """Name, type and default of an experiment's own option."""
    kind, default = declared.type, declared.default
    if get_origin(kind) is list:
        kind, default = tuple[get_args(kind)[0], ...], ()  # type: ignore[misc]
    elif default is None:
        kind |= None
    return declared.name, kind, option(default, declared.help, declared.flag, key=declared.key)


class GraspSearchSettings(ConfiguredSettings):
    """The settings of commands that search by grasps."""

    food: str | None = option(None, "Food that is grasped.", key="food.kind")
    pose: str | None = option(None, "How fingers are turned.", key="gripper.pose")
    resolution: float = option(
        5.0, "Distance between the pressures that are tried.", measured_in="kPa", above=0
    )
    preset: str | None = option(None, "Fineness of the fingers' mesh.", key="gripper.preset")


class PickupSettings(GraspSearchSettings):
    """Find the least pressure that picks food up, by grasps at multiples of --resolution.

    A call that was killed goes on where it was. pickup.csv has all grasps.

    Example: dolfingrip pickup --food cube --pose pinch --resolution 10
    """

    out: Path = _out(Path("out/pickup"))
    friction: float | None = option(None, "Friction of fingers on food.", key="food.friction")
    start: float = option(150.0, "Pressure of the first grasp.", measured_in="kPa", above=0)
    highest: float = _pressure(HIGHEST_KPA, "Highest pressure that is tried.")


class FrictionSettings(GraspSearchSettings):
    """Calibrate friction from the least pressure that picks food up: μ and its interval.

    A call that was killed goes on where it was. friction.csv has all grasps.

    Example: dolfingrip friction --pickup-pressure 80 --food cube
    """

    pickup_pressure: float = _pressure(MISSING, "Least pressure that picks up, as measured.")
    out: Path = _out(Path("out/friction"))
    tolerance: float = option(0.01, "Largest error of the friction.", least=1e-4, most=0.5)


class SupplySettings(ConfiguredSettings):
    """Find the commands of a supply of air with which a finger follows a curve.

    commands.csv has the set point of a regulator, or the parts of each step in which valve and
    exhaust are open, and the pressure that the cavity then has.

    Example: dolfingrip supply wished.csv --set supply.source=tank
    """

    curve: Path = argument(
        MISSING, "Curve: time_s with pressure_kPa or angle_deg, or a TOML of ramps.", "CURVE"
    )
    out: Path = _out(Path("out/supply"))
    every_s: float | None = option(
        None, "Length of a step; default: a 200th of the curve.", "--every", above=0
    )
    regulator: float | None = _pressure(
        None, "Highest set point of an ideal source; default: the highest pressure of the curve."
    )


class AdoptSettings(CommandSettings):
    """Turn your own geometry into a finger: mesh, configuration and a picture.

    It takes closed shells inside, or hollows with an opening, for cavities, a plane face at an
    end for the clamp, and the other end for the tip. The picture shows what it took for what;
    options correct it. All coordinates are those of the file, in mm.

    Example: dolfingrip adopt finger.step --size-mm 4
    """

    part: Path = argument(MISSING, "STEP, IGES or BREP; STL, 3MF, OBJ or PLY; or a mesh, as .msh.")
    out: Path = _out(Path("out/adopt"))
    cavity: tuple[Point | Path, ...] = option(
        (),
        "Point in or on a cavity (mm), or a file that it fills; repeatable.",
        metavar="X,Y,Z|FILE",
        read=_points_or_files,
    )
    clamp_region: tuple[Box | str, ...] = option(
        (),
        "Collar, plug or flange that is held: a box, by two corners (mm), or the name of a solid, "
        "of a region, or of a group of facets around it; repeatable.",
        metavar="X,Y,Z,X,Y,Z|NAME",
        read=_regions,
    )
    clamp: tuple[Point, ...] = option(
        (), "Point on the plane face that is clamped (mm).", metavar="X,Y,Z", read=_points
    )
    tip: tuple[Point, ...] = option(
        (), "Point on the face that is the tip (mm).", metavar="X,Y,Z", read=_points
    )
    back: tuple[Point, ...] = option(
        (), "Direction that the strain-limiting side faces.", metavar="X,Y,Z", read=_points
    )
    whole: bool = option(False, "Mesh both halves of a symmetric part; default: one of them.")
    repair: bool = option(False, "Close holes and crossings of triangles (needs pymeshfix).")
    size_mm: float | None = option(None, "Largest size of elements.", above=0, most=1000)
    order: int | None = option(None, "Order of elements.", metavar="1|2", least=1, most=2)
    cap_mm: float | None = option(
        None, "Thickness of a cap on an opening away from the clamp.", above=0, most=1000
    )
    limit_s: float = option(300.0, "Time after which meshing is given up.", above=0, most=1e6)
    unit: Literal["mm", "cm", "in", "m"] = option("mm", "Unit of length in the file.")


class MeshSettings(ConfiguredSettings):
    """Mesh the finger: .msh, VTK and Abaqus .inp.

    The files hold the solver's elements: hexahedra of 20 nodes (S2, the
    default), tetrahedra of 10 nodes (P2, P2-P1) or of 4 nodes (P1).
    --set mesh.order=1 asks for linear ones, mesh.order=2 for quadratic ones.

    Example: dolfingrip mesh --set mesh.size_mm=3 --out out/mesh
    """

    out: Path = _out(Path("out/mesh"))


class ExportSettings(ConfiguredSettings):
    """Write a design for a printer, for CAD or another simulator, as a configuration, or its mould.

    The name's end says who loads it: .stl, .3mf and .step are the whole finger without load, closed
    and in mm; .inp is a deck for CalculiX and Abaqus; .py a scene for SOFA's SoftRobots; .xml a
    flexible body for MuJoCo. --config takes a TOML file, or the run.json of an earlier run. A table
    \\[inlet] adds a connector for air to what is printed; \\[mould] is about the mould.

    Example: dolfingrip export finger.stl finger.step --config finger.toml
    """

    files: tuple[Path, ...] = argument(
        (), "Files to write, ending in .stl, .3mf, .step, .inp, .py, .xml or .toml.", "FILE"
    )
    mould: Path | None = option(
        None, "Write the mould of a cast kind: halves, core plate, tray.", metavar="FOLDER"
    )
    plate: bool = option(False, "Put the force sensor's plate before the tip in a deck (.inp).")


class RobotSettings(ConfiguredSettings):
    """Write the finger for robot simulators: a chain of links that runs in real time.

    It runs finite elements, fits the chain, and tells its errors at states that were not fitted.
    OUT then holds robot.json, finger.xml, gripper.xml and scene.xml for MuJoCo, finger.urdf and
    control.py. A call that was killed goes on from OUT/simulations. Where errors are asked for, the
    chain has the fewest joints within them, else as few as follow the free finger's shape.

    Example: dolfingrip robot --config finger.toml --angle-error-deg 1
    """

    out: Path = _out(Path("out/robot"))
    angle_error_deg: float | None = option(None, "Largest error of the tip's angle.", above=0)
    path_error_mm: float | None = option(None, "Largest error of the tip's path, rms.", above=0)
    force_error_percent: float | None = _percent(
        None, "Largest error of a plate's force, by the largest force."
    )
    stiffness_error_percent: float | None = _percent(None, "Largest error of the tip's stiffness.")
    workers: int = _workers(1)


class MorphSettings(ConfiguredSettings):
    """Move a mesh by ξ1 up to the plane x = morph.d_mm, and by ξ2 beyond it.

    Example: dolfingrip morph finger.msh --xi 0.3 -0.3 --out moved.msh
    """

    mesh: Path = argument(MISSING, "Mesh of the original: .msh, .inp, .vtk or .vtu.")
    out: Path = option(MISSING, "File of the moved mesh.", "--out", "-o")
    xi: tuple[float, float] = option(
        MISSING, "Relative change of both regions' thickness.", metavar="ξ1 ξ2"
    )
    inverse: bool = option(False, "Undo this morph instead.")


class ConfigSettings(ConfiguredSettings):
    """Print the resolved configuration, each key with its meaning.

    Example: dolfingrip config --set finger.kind=pneunet
    """


class DoctorSettings(CommandSettings):
    """Say what this machine has of what the commands need, and what is missing.

    Example: dolfingrip doctor
    """


class ColumnsSettings(CommandSettings):
    """Say what each column of an experiment's result.csv means.

    Example: dolfingrip columns grasp
    """

    experiment: str | None = argument(None, "Experiment, e.g. grasp; default: all.", "EXPERIMENT")
    markdown: bool = option(False, "Print a page of Markdown.")


class EffectSettings(CommandSettings):
    """List the effects that can be switched on, with their parameters and priors.

    Example: dolfingrip extensions mullins
    """

    name: str | None = argument(None, "Effect to read all about; default: a line on each.", "NAME")


class SyntheticSettings(ConfiguredSettings):
    """Write a synthetic measurement with hidden effects, nuisances and noise.

    Example: dolfingrip synthetic --hide extensions.wall_offset.offset_mm=0.1
    """

    out: Path = _out(Path("out/synthetic"))
    experiments: tuple[str, ...] = option(
        ("bending", "blocked_force"), "Experiments to simulate.", metavar="NAME,NAME,…", read=_names
    )
    hide: Mapping[str, Any] = option(
        NOTHING,
        "Change the true finger alone, which the files do not tell; repeatable.",
        metavar="KEY=VALUE",
        read=_assigned_pressures,
    )
    nuisance: tuple[str, ...] = option(
        (), "Draw this effect's numbers from their priors; repeatable.", metavar="EFFECT"
    )
    noise: Mapping[str, Any] = _noise(NOTHING)
    seed: int = option(0, "Seed of nuisances and noise.")
    protocol: Path | None = _protocolfile(None)
    specimen: str | None = _specimen(None)


class ImportSettings(CommandSettings):
    """Turn a table as laboratories have it into the two files of the format of measured data.

    It reads CSV, TSV, text, XLSX and MAT files of any separator, decimal sign and encoding, and
    knows columns by name and unit in English, German, French, Spanish, Italian, Portuguese, Dutch,
    Polish, Russian, Chinese, Japanese and Korean. It shows what it took for what. Where two
    readings are possible it asks, or without a terminal refuses with the line to add.

    Example: dolfingrip import pressure_and_angle.xlsx --out measured
    """

    table: Path = argument(MISSING, "CSV, TSV, text, .xlsx or .mat.", "TABLE")
    log: Path | None = argument(
        None, "A second table of the same test, with a clock of its own.", "LOG"
    )
    out: Path = _out(Path("out/import"))
    shift: float | None = option(
        None, "Time of the pressure's clock where the readings' shows 0.", measured_in="s"
    )
    column: tuple[str, ...] = option(
        (),
        "Meaning of a column, e.g. 'Druck \\[bar]=pressure_kPa', 'p=pressure_psi', "
        "'ADC*0.05-2=pressure_kPa', 'Remarks=ignore'; repeatable.",
        metavar="HEADER=COLUMN",
    )
    experiment: Literal["bending", "blocked_force", "coupon"] | None = option(
        None, "Experiment of the table, where its columns fit several."
    )
    zero_at_rest: bool | None = option(
        None, "Subtract the first readings, which are at rest.", "--zero-at-rest/--no-zero-at-rest"
    )
    withdraws: bool | None = option(
        None, "A pump withdraws where its counter is at 0 again.", "--withdraws/--no-withdraws"
    )
    gauge_length: float | None = _length(None, "Length of a coupon between the grips.")
    area: float | None = option(None, "Cross-section of a coupon.", measured_in="mm²", above=0)
    mode: Literal["uniaxial", "planar", "equibiaxial", "compression"] | None = option(
        None, "How a coupon is loaded; default: uniaxial."
    )
    frame_rate: float | None = _rate(None, "Pictures per second, where a column counts frames.")
    side_by_side: bool = option(False, "Columns of one quantity are those of several specimens.")
    rate: float | None = option(
        None, "Rate of ramps; of a coupon mm/s.", measured_in="kPa/s", above=0
    )
    encoding: str | None = option(None, "Encoding of the text, e.g. cp1252, gb18030, cp932.")
    decimal: Literal[".", ","] | None = option(None, "Decimal sign.")
    sheet: str | None = option(
        None, "Sheet of an .xlsx, arrays of a .mat, or the line above one of several tables."
    )


class TrackSettings(ConfiguredSettings):
    """Read angles and places from a video or pictures, with errors, for ``diagnose``.

    Dots of one colour, tags or the finger's outline are followed; a printed sheet behind it tells
    scale, lens and tilt of the camera. Without files, ``--sheet`` writes that sheet. Points that
    Kinovea, Tracker, DeepLabCut, Motive or a C3D file has become the same tables. The last line is
    the command that takes them.

    Example: dolfingrip track bend.mp4 --log pressure.csv --colour red
    """

    files: tuple[Path, ...] = argument(
        (), "A video, pictures, or points of another program.", "VIDEO|PICTURES|POINTS"
    )
    out: Path = _out(Path("out/track"))
    log: tuple[Path, ...] = option(
        (),
        "Table of pressures over time, as for `import`; repeatable, part by part.",
        metavar="LOG",
    )
    sheet: Literal["a4", "letter"] | None = option(None, "Write the sheet to print, to --out.")
    states: str | None = option(
        None,
        "Pressures or volumes: '{pressure_kPa}.jpg', or a CSV with a column file.",
        metavar="NAME|CSV",
    )
    scale: tuple[str, ...] = option(
        (), "'X,Y X,Y = LENGTH mm': two points (px) and their distance; repeatable."
    )
    in_front: float | None = option(
        None,
        "How far the points are before the sheet or scale; default: the finger's width, of which "
        "a silhouette's middle has half.",
        measured_in="mm",
    )
    colour: str | None = option(None, "Colour of the dots: red, green, …, #rrggbb; default: found.")
    dots: int | None = option(
        None, "Number of dots, or of points on a silhouette's back.", least=2, most=200
    )
    points: str | None = option(
        None, "Places of dots in the first frame: 'X,Y X,Y …' (px); or names of points in a file."
    )
    silhouette: bool = option(
        False, "Follow the outline of a finger without marks, which --config and --set describe."
    )
    pick: bool = option(False, "Click the dots on the first frame, in the browser.")
    unit: Literal["px", "mm", "cm", "m", "in"] | None = option(
        None, "Unit of another program's points, where its file tells none."
    )
    frame_rate: float | None = _rate(None, "Frames per second of such a file.")
    tags: Literal["4x4", "5x5", "6x6", "36h11", "25h9", "16h5"] | None = option(
        None, "Follow ArUco or AprilTag tags."
    )
    tag_side: float | None = _length(None, "Side of a tag.")
    fingers: int = option(1, "Number of fingers side by side.", least=1, most=20)
    clamp: str | None = option(
        None, "Where the clamp holds the back: 'X,Y' (px), or the name of a point in a file."
    )
    first: float | None = _length(None, "Distance from the clamp to the first point, as a scale.")
    side: Literal["left", "right"] | None = option(
        None, "Side to which it bends in the picture, clamp above; default: by its motion."
    )
    light: str | None = option(None, "Place of a light that goes on: 'X,Y' (px); see --event.")
    knock: bool = option(False, "Set the log's clock by a knock in the video and in --event.")
    event: str | None = option(None, "Column of the log that shows the light or knock.")
    shift: float | None = option(None, "Time of the log at the first frame.", measured_in="s")
    until: float | None = option(None, "Time to read the video up to.", measured_in="s", above=0)
    column: tuple[str, ...] = option(
        (), "Say what a column of the log is, as for `import`; repeatable.", metavar="HEADER=COLUMN"
    )
    overlay: bool = option(True, "Write overlay and doubtful frames.", "--overlay/--no-overlay")


class DiagnoseSettings(ConfiguredSettings):
    """Find out what the simulation gets wrong about measured data, and why.

    Example: dolfingrip diagnose measured.csv --config finger.toml --workers 4
    """

    data: tuple[Path, ...] = argument(MISSING, "Measured data; each CSV has a TOML.", "DATA.csv")
    out: Path = _out(Path("out/diagnosis"))
    workers: int = _workers(2)
    store: Path | None = _store(None)
    effects: tuple[str, ...] = _effects(())
    campaign: Path | None = option(
        None, "Campaign whose best designs are computed with it, too.", metavar="FOLDER"
    )
    quick: bool = option(False, "Try each effect alone, and leave out what takes longer.")


class PlanExperimentSettings(ConfiguredSettings):
    """Find which effects a rig could name, at which strength, and what to add to it.

    Example: dolfingrip plan-experiment rig.toml --with cycles=3
    """

    rig: Path | None = argument(None, "Rig and \\[protocol]; default: the paper's.", "RIG.toml")
    out: Path = _out(Path("out/plan"))
    changes: Mapping[str, Any] = option(
        NOTHING,
        "Key of \\[protocol]: cycles=3.",
        "--with",
        metavar="KEY=VALUE",
        read=tables.assignments,
    )
    noise: Mapping[str, Any] = _noise(NOTHING)
    workers: int = _workers(2)
    store: Path | None = _store(None)
    effects: tuple[str, ...] = _effects(())
    quick: bool = option(False, "Judge only additions that need no further simulations.")


class PredictSettings(CommandSettings):
    """Predict an actuator from fits to others: angle and ballooning pressure, 90 % intervals.

    Example: dolfingrip predict --from fitted.toml --pressures 20,40,60
    """

    source: Path = option(MISSING, "Configuration with a \\[posterior].", "--from")
    out: Path = _out(Path("out/prediction"))
    overrides: Mapping[str, Any] = _changes(NOTHING)
    pressures: tuple[float, ...] = option(
        (), "Pressures at which the angle is predicted.", metavar="kPa,kPa,…", read=_pressures
    )
    csv: Path | None = option(None, "Table to write; default: prediction.csv in --out.")


class DesignSettings(CommandSettings):
    """Find the best design by gradients: each step is accepted on finite elements.

    A run that was stopped goes on from OUT/simulations. OUT then holds design.json, design.toml
    (a configuration), finger.stl, steps.csv, and pictures of finger, section and convergence;
    OUT/steps a picture of each accepted design, drawn as it is found; OUT/start and OUT/design a
    run of each.

    Example: dolfingrip design problem.toml --workers 2
    """

    file: Path = argument(MISSING, "Problem: objective, constraints, parameters.", "FILE.toml")
    out: Path = _out(Path("out/design"))
    workers: int = _workers(1)
    overrides: Mapping[str, Any] = _changes(NOTHING)
    refine: bool = option(True, "Solve start and result again on a finer mesh.")
    fields: bool = option(True, "Run start and result once more, with fields, for a report.")


class DoeSettings(ConfiguredSettings):
    """Design of experiments: compute every design that is missing in a campaign.

    Example: dolfingrip doe --parameter finger.wall_mm=1.5:2.5:5 --workers 2
    """

    out: Path = _out(Path("out/doe"))
    points: Literal["grid", "sobol", "lhs"] = option("grid", "Designs: evenly spaced, or sampled.")
    number: int | None = option(None, "Number of samples of sobol or lhs.")
    parameter: tuple[str, ...] = option(
        (),
        "Key that varies; repeatable. Default: the paper's 16 x 13 values of ξ1 and ξ2.",
        metavar="KEY=LOW:HIGH[:COUNT]",
    )
    seed: int = option(0, "Seed of the samples.")
    quantity: tuple[str, ...] = option(
        (), "Output, e.g. 'force_N at 250 kPa'; repeatable. Default: cog_offset_mm and force_N."
    )
    workers: int = option(1, "Number of local processes, or of Slurm jobs.", least=1)
    scheduler: str | None = option(
        None, "Use a Dask cluster that is there, tls://HOST:PORT.", metavar="ADDRESS"
    )
    slurm: Path | None = option(None, "Start workers as Slurm jobs.", metavar="FILE.toml")
    ranks: int = option(1, "Number of MPI processes of each design.", least=1)
    retry_failed: bool = option(False, "Compute failed designs anew.")
    objective: str | None = option(None, "Another objective function.", metavar="MODULE:FUNCTION")
    fields: bool = option(
        False,
        "Keep deformed shapes of designs computed now (2 MB for each reading, default "
        "mesh), for explore.",
    )
    check: Path | None = option(
        None, "Only look through a campaign, and set aside what is damaged.", metavar="FOLDER"
    )
    gradients: bool = _gradients(False)
    parameters: str | None = _parameters(None)


class DoeExportSettings(CommandSettings):
    """Write a campaign's designs as CSV and Parquet, and derivatives as sensitivity.csv.

    Example: dolfingrip doe export --out out/doe
    """

    out: Path = _out(Path("out/doe"))
    csv: Path | None = option(None, "CSV file to write; default: designs.csv in --out.")
    parquet: Path | None = option(None, "Parquet file to write; default: designs.parquet in --out.")


class TrainSettings(CommandSettings):
    """Train a neural network on the designs of a campaign.

    Example: dolfingrip train out/doe --out out/surrogate
    """

    source: Path = argument(MISSING, "Campaign's folder, or designs as .csv or .parquet.", "FROM")
    out: Path = _out(Path("out/surrogate"))
    inputs: tuple[str, ...] = option(
        (), "Input; repeatable. Default: what a campaign varies.", "--input", metavar="COLUMN"
    )
    outputs: tuple[str, ...] = option(
        (), "Output; repeatable. Default: a campaign's quantities.", "--output", metavar="COLUMN"
    )
    epochs: int = option(5000, "Passes over the training designs.", least=1)
    seed: int = option(0, "Seed of the split and of the first weights.", least=0)


class TradeOffSettings(CommandSettings):
    """The two outputs of a surrogate that are traded off."""

    against: str | None = option(None, "Output that is limited; default: the first one.")
    at_most: tuple[float, ...] = option((), "Its largest value, to choose by; repeatable.")
    at_least: tuple[float, ...] = option((), "Its least value, to choose by; repeatable.")
    maximise: str | None = option(None, "Output that is improved; default: the other one.")
    minimise: str | None = option(None, "Output that is improved and of which less is better.")


class OptimiseSettings(ConfiguredSettings, TradeOffSettings):
    """Find the Pareto front of two outputs by NSGA-II, choose by a limit, compute the choice again.

    Finite elements take the configuration of the campaign that the surrogate learnt from, unless
    --config names another; --set changes it. What they computed is kept in OUT/fem.

    Example: dolfingrip optimise out/surrogate --at-most 3
    """

    surrogate: Path = _surrogate(MISSING)
    out: Path = _out(Path("out/optimum"))
    also: tuple[str, ...] = option((), "Further quantity by finite elements; repeatable.")
    population: int = option(1000, "Number of designs in a generation.", least=4)
    generations: int = option(200, "Number of generations, the random first one counted.", least=1)
    crossover: float = option(0.9, "Probability of a crossover, per mating.", least=0, most=1)
    mutation: float = option(0.5, "Probability of a mutation, per input.", least=0, most=1)
    seed: int = option(1, "Seed of NSGA-II.", least=0)
    resolve: bool = option(True, "Compute the choices and --along by finite elements.")
    along: int = option(10, "Number of points of the front to compute again.", least=0)
    workers: int = option(1, "Number of local processes of --resolve.", least=1)
    objective: str | None = option(
        None,
        "The campaign's objective function, which is run if it is not of this package.",
        metavar="MODULE:FUNCTION",
    )


class StudySettings(TradeOffSettings):
    """Try NSGA-II's hyperparameters: all combinations, each with several seeds.

    Example: dolfingrip study out/surrogate --seeds 5
    """

    surrogate: Path = _surrogate(MISSING)
    out: Path = _out(Path("out/study"))
    population: tuple[int, ...] = option((50, 100, 500, 1000), "Designs in a generation.", least=4)
    generations: tuple[int, ...] = option(
        (10, 50, 100, 200), "Numbers of generations, the random first one counted.", least=1
    )
    crossover: tuple[float, ...] = option(
        (0.9, 0.8, 0.6, 0.4), "Probabilities of a crossover, per mating.", least=0, most=1
    )
    mutation: tuple[float, ...] = option(
        (0.01, 0.1, 0.5, 0.8), "Probabilities of a mutation, per input.", least=0, most=1
    )
    seeds: int = option(10, "Number of runs of each combination.", least=2)
    processes: int | None = option(None, "Processes at a time; default: all cores.", least=1)


class ReproduceSettings(ConfiguredSettings):
    """Run doe, train, optimise and study as a file says, and compare with published designs.

    examples/paper_study.toml has the paper's. Each step writes into its own folder under OUT and
    resumes there.

    Example: dolfingrip reproduce examples/paper_study.toml --workers 2
    """

    file: Path = argument(MISSING, "TOML: designs, the two quantities, published designs.", "FILE")
    out: Path = _out(Path("out/reproduce"))
    workers: int = _workers(1)
    parameter: tuple[str, ...] = option(
        (), "Key that varies; default: those of the file.", metavar="KEY=LOW:HIGH:COUNT"
    )
    study: bool = option(True, "Try the hyperparameters of NSGA-II, too.")


class ReportSettings(CommandSettings):
    """Write results as one HTML page: 3D view, curves, front, checks, provenance.

    RUN is a folder that bend, force, cycle, coupon, push, grasp, doe, train, optimise, design,
    study, robot or diagnose wrote, or one with several of these in it, such as the demo's. The
    page needs no network; it opens in any browser.

    Example: dolfingrip report out/bend out/force --out report.html
    """

    results: tuple[Path, ...] = argument(MISSING, "Folders with results of any kind.", "RUN")
    out: Path = option(Path("report.html"), "HTML file to write.", "--out", "-o")
    measured: Path | None = option(None, "Measured data, drawn beside curves.", metavar="FILE.csv")
    title: str | None = option(None, "Title of the page.", metavar="TEXT")
    pdf: bool = option(False, "Write the page as PDF, too, by Chromium.")


class ExploreSettings(ConfiguredSettings):
    """Explore designs in the browser: sliders, shape, numbers, front, gripper, exports.

    Designs are solved on demand and kept, and shapes between them are interpolated. The page is
    served to this machine alone, to whoever has the address that is printed.

    Example: dolfingrip explore out/doe --browser
    """

    results: tuple[Path, ...] = argument(
        (), "Folders that doe, train, optimise, bend or force wrote.", "RESULTS"
    )
    out: Path | None = option(
        None,
        "Folder for solutions; default: explore/ in RESULTS or in out.",
        "--out",
        "-o",
        metavar="FOLDER",
    )
    parameter: tuple[str, ...] = option(
        (), "Key of a slider; repeatable. Default: the campaign's.", metavar="KEY=LOW:HIGH"
    )
    host: str = option(
        "127.0.0.1",
        "Address to listen at; any other than this machine's is public.",
        metavar="ADDRESS",
    )
    port: int | None = option(
        None, "Port to listen at; default: the first free one from 8760 on.", least=0, most=65535
    )
    browser: bool = option(False, "Open the page in the browser.")
    restart: bool = option(False, "Take the place of the last server: its pages connect again.")


GROUPS: Final[Mapping[str, tuple[type, ...]]] = {
    "Simulate: dolfingrip bend --pressure 200 --render 0,200":
        (DemoSettings, RunSettings, GraspSearchSettings, SupplySettings),
    "Mesh, print and export: dolfingrip export finger.stl":
        (AdoptSettings, MeshSettings, ExportSettings, RobotSettings, MorphSettings),
    "Look up: dolfingrip config --set finger.wall_mm=1.8":
        (ConfigSettings, ColumnsSettings, EffectSettings),
    "Compare with measurements: dolfingrip diagnose measured.csv":
        (SyntheticSettings, ImportSettings, TrackSettings, DiagnoseSettings, PlanExperimentSettings,
         PredictSettings),
    "Design: dolfingrip design problem.toml":
        (DesignSettings, DoeSettings, TrainSettings, TradeOffSettings, ReproduceSettings),
    "See results, check this machine: dolfingrip report out/bend":
        (ReportSettings, ExploreSettings, DoctorSettings),
}  # fmt: skip
"""Settings of the commands below each heading of the list, which has an example."""


def group(settings: type) -> str | None:
    """Return the heading that a command is listed under; None: there is none.

    Args:
        settings: of the command.
    """
    return next((name for name, kinds in GROUPS.items() if issubclass(settings, kinds)), None)
