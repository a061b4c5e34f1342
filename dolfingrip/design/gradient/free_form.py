"""The numbers of a free form: where they begin, and how far they may go."""

from __future__ import annotations

import math

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.gradient.file import FreeFormTable
from dolfingrip.design.gradient.problem import Variable
from dolfingrip.parameter import find
from dolfingrip.sections.form import Form, Offset
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, BoxSolid


def begun(base: Config, asked: FreeFormTable) -> Config:
    """A configuration with a free form: its own, or planes with a ripple.

    A straight tube is as stiff with a ripple of either sign, so no gradient makes bellows of it;
    MorphOpt's tubes begin with a ripple, too.

    Raises:
        ConfigError: one line, where the finger cannot have one.
    """
    if base.form is not None:
        if asked.ripple_mm:
            raise ConfigError(
                f"free_form.ripple_mm = {asked.ripple_mm:g}: allowed: without a [form] to begin at"
            )
        return base
    if base.mesh.file is not None:
        raise ConfigError("free_form: allowed: with a finger that is made from dimensions")
    boxes = base.geometry.boxes()
    if boxes is None:
        raise ConfigError("free_form: allowed: with a finger that is made of boxes")
    form = Form(along=asked.along, offsets_mm=())
    offsets = tuple(_ripple(each, boxes, asked) for each in form.each(boxes))
    return base.changed(form={"along": asked.along, "offsets_mm": offsets})


def variables(base: Config, asked: FreeFormTable) -> list[Variable]:
    """The offsets of a configuration's free form, with their ranges.

    Raises:
        ConfigError: one line, where they begin outside them.
    """
    boxes = base.geometry.boxes()
    assert base.form is not None
    assert boxes is not None
    found = []
    parameters = find(base, ["form.offsets_mm"])
    for parameter, each in zip(parameters, base.form.each(boxes), strict=True):
        if not asked.ends and _at_end(each):
            continue
        high = asked.most_mm
        if asked.outwards_mm is not None and _is_outer(each, boxes):
            high = min(asked.outwards_mm, asked.most_mm)
        start = float(parameter.value(base))
        if not -asked.most_mm <= start <= high:
            raise ConfigError(
                f"free_form: start = {start:g} of {parameter.key}: allowed: {-asked.most_mm:g} to "
                f"{high:g} mm"
            )
        found.append(Variable(parameter, -asked.most_mm, high, start))
    return found


def _is_outer(each: Offset, boxes: BoxSolid) -> bool:
    return abs(each.plane_mm - boxes.body[each.axis][1]) < TOLERANCE_MM


def _at_end(each: Offset) -> bool:
    return each.axis == 2 or each.along in (0.0, 1.0)


def _ripple(each: Offset, boxes: BoxSolid, asked: FreeFormTable) -> float:
    """Amplitude of the ripple: 0 at the contact face and along z, all of it at the roof."""
    (low, high), _, (start, end) = boxes.body
    if each.axis == 2 or not asked.ripple_mm or (not asked.ends and _at_end(each)):
        return 0.0
    share = float(each.function) if each.axis == 1 else 1.0
    if each.axis == 0 and each.plane_mm < (low + high) / 2:
        share = 0.0
    waves = each.along * (end - start) / asked.ripple_length_mm
    return round(share * asked.ripple_mm * math.cos(2 * math.pi * waves), 9)
