"""Derivatives of a design's quantities by the parameters that are asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dolfingrip.config import Config
from dolfingrip.experiments.derivatives.choices import choices
from dolfingrip.experiments.derivatives.gradients import XI, by_adjoint, cog_offset_mm
from dolfingrip.experiments.derivatives.sensitivities import chosen
from dolfingrip.experiments.result import Result


class Derivatives:
    """What is derived of a design: ξ1 and ξ2 by the adjoint where it can, as that is cheaper.

    Args:
        config: of the design.
        keys: of parameters and choices of the model; () for all parameters.

    Attributes:
        forward: keys that an experiment's readings are derived by along its path; None for none.

    Raises:
        ConfigError: one line, where there is no such parameter.
    """

    def __init__(self, config: Config, keys: Sequence[str]) -> None:
        self._config = config
        self._parameters = chosen(config, keys)
        self._choices = choices(config, keys)
        # the adjoint is taken at the configuration's highest pressure: a protocol has its own
        adjoint = by_adjoint(config.adapted()) and not config.protocol.time_s
        self._adjoint = XI if adjoint else ()
        along = [each.key for each in self._parameters if each.key not in self._adjoint]
        self.forward = [*along, *(each.key for each in self._choices)] or None

    def of_cog_offset(self) -> tuple[float, dict[str, float]]:
        """The undeformed centroid's offset (mm) and its derivatives, by key.

        Raises:
            MeshError: one line, where there is no such finger.
        """
        offset, slopes = cog_offset_mm(self._config, self._parameters)
        for choice in self._choices:
            slopes[choice.label] = choice.difference(offset, cog_offset_mm(choice.other, ())[0])
        return offset, slopes

    def of_reading(
        self, result: Result, column: str, row: int, adjoint: Mapping[str, float]
    ) -> dict[str, float]:
        """Derivatives of a reading, by key.

        A choice of the model is left out where its second run ended before that row.

        Args:
            result: of an experiment with the derivatives of :attr:`forward`.
            column: of the reading.
            row: of the result, from 0 on.
            adjoint: what the adjoint gave.
        """
        along = {
            each["parameter"]: each["derivative"]
            for each in result.sensitivities
            if each["row"] == row and each["column"] == column
        }
        found = {**adjoint, **along}
        wanted = [each.key for each in self._parameters] + [each.label for each in self._choices]
        return {key: found[key] for key in wanted if key in found}
