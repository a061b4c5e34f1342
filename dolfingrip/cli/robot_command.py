"""``dolfingrip robot``: a finger for robot simulators, in real time and with its errors."""

from __future__ import annotations

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.console import console, one_process, resumable
from dolfingrip.cli.settings import RobotSettings
from dolfingrip.config import ConfigError
from dolfingrip.files.robot import Accuracy
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.report.table import of_rows
from dolfingrip.robot import build
from dolfingrip.robot.write import room, write


def robot(args: RobotSettings) -> None:
    """Fit a chain of links to finite elements and write it for robot simulators."""
    one_process("--workers, without mpirun")
    config = configuration.load(args.config, args.overrides)
    screen, folder = console(), args.out / build.FOLDER
    try:
        placed = room(config)
    except ConfigError as error:
        placed = None
        screen.say(f"no gripper.xml and no scene.xml: {error}")
    with (
        resumable(screen, folder),
        progress.jobs(screen, "runs", progress.FEW) as show,
        Pool(Where(workers=args.workers)) as pool,
    ):
        simulated = build.simulate(config, args.out, pool, show)
    accuracy = _accuracy(args)
    if accuracy is None:
        built = build.build(simulated)
    else:
        with progress.shown(screen, "joints", few=progress.FEW) as tried:
            built = build.build(simulated, accuracy, tried)
    file = built.robot.file
    headings = ("States that were not fitted", "rms", "Largest", "Unit", "Relative")
    rows = [
        (comparison.title, f"{comparison.rms:.3g}", f"{comparison.largest:.3g}", comparison.unit,
         f"{100 * comparison.relative:.2g} %")
        for comparison in file.comparisons
    ]  # fmt: skip
    screen.print(of_rows(headings, rows, left=headings[:1]))
    joints = f"{len(file.joints)} joint{'s' if len(file.joints) > 1 else ''}"
    if file.excess > 1:
        screen.say(
            f"no chain of up to {built.tried} joints is within the errors asked for; the nearest "
            f"one, of {joints}, has {file.excess:.2g} times them"
        )
    elif accuracy is not None:
        screen.say(f"{joints}: the fewest within the errors asked for")
    (low, high), gaps = file.valid.pressure_kPa, file.valid.gaps_mm
    screen.say(
        f"the chain has {joints} and follows the finger to {file.shape_error_mm:.2g} mm; it was "
        f"fitted from {low:g} to {high:g} kPa, to plates at {min(gaps):.3g} to {max(gaps):.3g} mm "
        f"and up to {file.valid.force_N:.3g} N, where these errors hold; "
        f"the runs of finite elements took {file.simulated_s:.0f} s"
    )
    if file.supply is not None:
        filled_s = build.CONSTANTS * file.line_s
        screen.say(
            f"its supply fills it to 95 % of {high:g} kPa in {filled_s:.2g} s, as a lag of "
            "the first order does in finger.xml"
        )
    for ending in file.valid.ended:
        screen.say(f"a run ended early: {ending}")
    for path in write(built, config, placed, args.out):
        screen.say(f"wrote {path}")


def _accuracy(args: RobotSettings) -> Accuracy | None:
    """Errors that are asked for; None where there are none."""
    of = {
        "angle_deg": args.angle_error_deg,
        "path_mm": args.path_error_mm,
        "force": args.force_error_percent and args.force_error_percent / 100,
        "stiffness": args.stiffness_error_percent and args.stiffness_error_percent / 100,
    }
    return Accuracy(**of) if any(of.values()) else None
