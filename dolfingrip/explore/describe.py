"""What a tab shows of a design: its shape, curves, numbers, and where they come from."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.channels import ANGLE, CAVITY_VOLUME, CHANNELS, FORCE, MOVED, PRESSURE, Channel
from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.derivatives.gradients import COG, shape_number
from dolfingrip.experiments.feedforward import command_for
from dolfingrip.experiments.filling import RestingFinger, step_response
from dolfingrip.experiments.index import find
from dolfingrip.experiments.results.following import StepResponse
from dolfingrip.experiments.rigs.food import grasped
from dolfingrip.experiments.rigs.gripper import stands_of
from dolfingrip.experiments.rigs.pneumatics import line_of
from dolfingrip.explore import policy
from dolfingrip.explore.library import Blend, Library
from dolfingrip.explore.space import EXPERIMENTS, Space
from dolfingrip.explore.wanted import Wanted, pressurised
from dolfingrip.files.run import RunFile
from dolfingrip.meshes.gripper import Stand
from dolfingrip.meshes.solid import MeshError
from dolfingrip.report.design import label
from dolfingrip.report.page import html, run_scene, runs
from dolfingrip.report.page.finger import unloaded_shape
from dolfingrip.report.page.numbers import said, with_error
from dolfingrip.report.page.run_scene import scene_of
from dolfingrip.report.page.scene import GRIPPER_VIEW, UPRIGHT, Floats, Scene, ScenePart, towards

READINGS: Final = {"bending": ANGLE, "blocked_force": FORCE}
"""The reading that is shown of each experiment."""

NAMES: Final = {"bending": "Tip angle, free", "blocked_force": "Blocked force"}


def described(space: Space, library: Library, wanted: Wanted, solved: Path) -> dict[str, Any]:
    """Plain data that a tab shows of a design.

    Args:
        space: what varies.
        library: solved designs.
        wanted: the design.
        solved: folder where the design's own solution is, if it is solved.

    Raises:
        ConfigError: one line, if there is no such design.
    """
    if wanted.view == "grasp":
        return _grasp(library, wanted, solved, space.base.experiment.max_pressure_kPa)
    blend = library.blend(wanted)
    scene, where, badge = _shape(wanted, blend)
    failed = _failed(wanted, solved)
    if failed is not None:
        (scene, where), badge = failed, "did not reach the end"
    pairs = ((kind, library.blend(wanted, kind)) for kind in EXPERIMENTS)
    blends = {kind: b for kind, b in pairs if b is not None and b.checked}
    charts = [_chart(kind, b, kind == wanted.view) for kind, b in blends.items()]
    numbers = _numbers(space, wanted, blends)
    highest_kPa = wanted.config.experiment.max_pressure_kPa
    if space.supply is not None and (free := resting(library, wanted)):
        filled = step_response(free, line_of(space.supply), highest_kPa)
        numbers.append(
            {"name": "Filled", "value": said(filled.reached_s, "s"), "said": filled.sentence}
        )
        charts.append(_filling(filled))
    return {
        "scenes": [replace(scene, title=find(wanted.view).title, kind=wanted.view).packed()],
        "charts": html.charts_data(charts),
        "numbers": numbers,
        "said": where,
        "badge": badge,
        "solved": failed is not None or (blend is not None and blend.exact and not blend.coarse),
        "place": {name: value for name, (value, _) in _predicted(space, wanted).items()},
    }


def _shape(wanted: Wanted, blend: Blend | None) -> tuple[Scene, str, str]:
    """The shape of a design, loaded where that is known, what it is, and that in a word or two."""
    with suppress(MeshError):  # of solved points that do not fit the design's dimensions
        if blend is not None:
            off = blend.shape_error_mm()
            precision = "" if off is None else f": the shape is right to {_rough(off, 'mm')}"
            badge = "coarse mesh" if blend.coarse else ""
            if off is not None:
                channel = READINGS[blend.of[0].run.experiment.name]
                error = _rough(_error(blend, channel) or 0.0, channel.symbol)
                badge = f"estimate ± {error}, shape ± {_rough(off, 'mm')}"
            elif not blend.exact:
                badge = "interpolated" if blend.own else "estimate, error unknown"
            return blend.scene(), _where(blend) + precision, badge
    scene = unloaded_shape((wanted.coarse or wanted).config)
    return scene, "not solved: the shape without load", "not solved, without load"


def _rough(error: float, unit: str) -> str:
    return said(float(f"{error:.2g}"), unit)


def _where(blend: Blend) -> str:
    mesh = " on a coarse mesh" if blend.coarse else ""
    if blend.exact:
        return f"solved{mesh}" if mesh else "solved by finite elements"
    if blend.own:
        largest = said(blend.of[0].largest_kPa, "kPa")
        return f"solved{mesh} to {largest}, interpolated between its steps"
    unknown = "" if blend.checked else ", too few to tell the error"
    return f"estimate, interpolated between {len(blend.of)} designs solved{mesh}{unknown}"


def _failed(wanted: Wanted, solved: Path) -> tuple[Scene, str] | None:
    """The scene of a solution that ended early; None if there is none."""
    if not (solved / "fields.pvd").is_file() or not RunFile.is_in(solved):
        return None
    run = runs.read(solved)
    failure = run.result.failure
    return None if failure is None else (scene_of(run), f"{run.title} {failure.sentence()}")


def _chart(kind: str, blend: Blend, shown: bool) -> Chart:
    """A reading over the pressure, with the interpolation's error as a band."""
    channel, title = READINGS[kind], NAMES[kind]
    x, y = blend.reading(PRESSURE.name), blend.reading(channel.name)
    error = blend.error(channel.name)
    series = Series(
        _where(blend), x, y, "line", 0 if shown else None,
        None if error is None else y - error, None if error is None else y + error,
    )  # fmt: skip
    note = "" if error is None else "Band: ± the interpolation's error on designs left out."
    up = Axis(f"{title} ({channel.symbol})", channel.symbol)
    return Chart(title, Axis(PRESSURE.label, PRESSURE.symbol), up, [series], note=note)


def resting(library: Library, wanted: Wanted) -> RestingFinger | None:
    """The free finger at rest; None where it is not solved, has no pressure or several cavities.

    Args:
        library: solved designs.
        wanted: the design.
    """
    blend = library.blend(wanted, "bending")
    if blend is None or not blend.checked:
        return None
    columns = (PRESSURE.name, CAVITY_VOLUME.name, ANGLE.name)
    finger = RestingFinger(*(blend.reading(column) for column in columns))
    rising = bool((np.diff(finger.pressure_kPa) > 0).all())
    return finger if rising and np.isfinite(finger.volume_mm3).all() else None


def followed(
    space: Space, wanted: Wanted, finger: RestingFinger | None, curve: tuple[Sequence[float], ...]
) -> dict[str, Any]:
    """Plain data of the commands with which a supply makes a design follow a curve.

    Args:
        space: what varies.
        wanted: the design.
        finger: it at rest; None where that is not known.
        curve: times (s), and pressures (kPa) there.

    Raises:
        ConfigError: one line, where there are no commands.
    """
    if finger is None:
        raise ConfigError("free bending: not solved; allowed: solved, of one cavity, above 0 kPa")
    config = wanted.config.changed(supply=dict(space.supply or {}))
    time_s, pressure_kPa = curve
    control = command_for(
        config, time_s, pressure_kPa=pressure_kPa, every_s=time_s[-1] / policy.CURVE_STEPS,
        finger=finger,
    )  # fmt: skip
    return {"chart": html.charts_data([control.chart()])[0], "said": control.sentences()}


def _filling(filled: StepResponse) -> Chart:
    """The cavity's pressure as the supply fills it."""
    series = Series("cavity", filled.time_s, filled.cavity_kPa, "line", 0)
    time, up = Axis("Time (s)", "s", "Time"), Axis(PRESSURE.label, PRESSURE.symbol)
    return Chart("Pressure, asked for at once", time, up, [series])


def _numbers(space: Space, wanted: Wanted, blends: Mapping[str, Blend]) -> list[dict[str, str]]:
    """Readings at the highest pressure: by finite elements, the surrogate and interpolation.

    An estimate without a known error is none of them.
    """
    predicted = _predicted(space, wanted)
    largest = said(wanted.config.experiment.max_pressure_kPa, "kPa")
    rows = [
        {"name": label(COG).partition(" (")[0], "value": said(_offset(wanted), "mm"),
         "said": "of the unloaded shape's mesh"}
    ]  # fmt: skip
    for kind, channel in READINGS.items():
        name = f"{NAMES[kind]} at {largest}"
        if channel.name in predicted:
            value, error = predicted[channel.name]
            rows.append(
                {"name": name, "value": _told(value, error, channel.symbol), "said": "surrogate"}
            )
        blend = blends.get(kind)
        if blend is None:
            if channel.name not in predicted:
                rows.append({"name": name, "value": "–", "said": "not solved yet"})
            continue
        value = float(blend.reading(channel.name)[-1])
        text = _told(value, _error(blend, channel), channel.symbol)
        rows.append({"name": name, "value": text, "said": _where(blend)})
    return rows


def _error(blend: Blend, channel: Channel) -> float | None:
    """Error of a reading at the highest pressure; None where it is a solution's or not known."""
    errors = blend.error(channel.name)
    return None if errors is None else float(errors[-1])


def _told(value: float, error: float | None, unit: str) -> str:
    return said(value, unit) if error is None else with_error(value, error, unit)


def _offset(wanted: Wanted) -> float:
    return shape_number(COG, (wanted.coarse or wanted).config, ())[0]


def _predicted(space: Space, wanted: Wanted) -> dict[str, tuple[float, float | None]]:
    """The surrogate's outputs with their errors, by name; none outside of what it learnt."""
    surrogate = space.surrogate
    if surrogate is None or not set(surrogate.input_names) <= set(wanted.inputs):
        return {}
    learnt = {name: wanted.inputs[name] for name in surrogate.input_names}
    if space.put(space.base, learnt) != wanted.config:  # it differs in something else, too
        return {}
    inputs = np.array([list(learnt.values())])
    low, high = surrogate.inputs.low, surrogate.inputs.high
    slack = 1e-9 * (high - low)
    if ((inputs < low - slack) | (inputs > high + slack)).any():
        return {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        values = surrogate.predict(inputs)[0]
    names = surrogate.output_names
    return {n: (float(v), space.errors.get(n)) for n, v in zip(names, values, strict=True)}


def _grasp(library: Library, wanted: Wanted, solved: Path, largest_kPa: float) -> dict[str, Any]:
    """A grasp that was solved, or the gripper before it."""
    if RunFile.is_in(solved) and (solved / "fields.pvd").is_file():
        run = runs.read(solved)
        outcome = run.result.outcome
        kind, sentence = ("no outcome", "") if outcome is None else (outcome.kind, outcome.sentence)
        numbers = [{"name": "Grasp", "value": kind, "said": sentence}]
        for name in ("normal_A_N", "normal_B_N", "slip_mm", "object_height_mm"):
            column, channel = run.column(name), CHANNELS[name]
            if column is not None:
                value = said(float(column[-1]), channel.symbol)
                numbers.append({"name": channel.title, "value": value, "said": "at the end"})
        return {
            "scenes": [scene_of(run).packed()], "charts": [], "numbers": numbers,
            "said": "solved by finite elements", "badge": "", "solved": True, "place": {},
        }  # fmt: skip
    # fingers are solved to the configured pressure, which may be lower
    reached = min(wanted.config.experiment.max_pressure_kPa, largest_kPa)
    free = replace(wanted, config=pressurised(wanted.config, reached))
    finger, *_ = _shape(free, library.blend(free, "bending"))
    where = "not solved: the fingers without load"
    if len(finger.load.values) > 1:
        to = said(reached, "kPa")
        where = f"not solved: the fingers bend freely here, to {to}, and do not feel the food"
    return {
        "scenes": [_placed(wanted.config, finger).packed()], "charts": [], "numbers": [],
        "said": where, "badge": "not solved", "solved": False, "place": {},
    }  # fmt: skip


def _placed(config: Config, finger: Scene) -> Scene:
    """Three fingers around their food; they move as the one finger does, which feels no food.

    Args:
        config: with gripper and food.
        finger: scene of one finger, unloaded or in free bending.

    Raises:
        ConfigError: one line, if there is no room for the fingers.
    """
    body = grasped(config.food)
    parts: list[ScenePart] = []
    for stand, name in zip(stands_of(config, body), run_scene.NAMES, strict=True):
        for part in finger.parts:
            if part.name != "clamp" and not part.section:
                parts += _copies(part, stand, name)
    food = body.surface.points + np.array(body.body.centre_mm)
    around = np.concatenate([food, *(part.frames[0] for part in parts)])
    parts.append(run_scene.food_part(body.surface, food[None], config.food.shape.colour))
    parts.append(run_scene.table_part(around))
    alt = "Three fingers around the food on its table, before the grasp is solved"
    return replace(
        finger, title="Gripper", alt=alt, kind="grasp", parts=parts,
        towards=towards(GRIPPER_VIEW), solved=False, axes=np.ones(3),
    )  # fmt: skip


def _copies(part: ScenePart, stand: Stand, name: str) -> list[ScenePart]:
    """A part of the finger where the finger stands, with its mirror image as a part of its own."""
    copies = []
    for side in (1.0, -1.0) if part.mirrored else (1.0,):
        frames = part.frames * UPRIGHT * np.array([1.0, side, 1.0])
        frames = frames @ stand.rotation.T + stand.origin_mm
        skin = part.skin
        if side < 0:
            skin = replace(skin, triangles=skin.triangles[:, ::-1])
        skin = replace(skin, points=frames[0])
        moved: Floats = np.linalg.norm(part.frames[1:] - part.frames[0], axis=2)
        copies.append(
            replace(
                part, name=name, skin=skin, frames=frames, mirrored=False, cut=False,
                fields={**part.fields, MOVED.name: moved},
            )
        )  # fmt: skip
    return copies
