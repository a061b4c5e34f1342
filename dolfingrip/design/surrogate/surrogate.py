"""A small neural network in place of the finite element model (the paper's section IV.B).

On disk a surrogate is two files, neither of which can run code when read: ``surrogate.pt`` with
the weights alone and ``surrogate.json`` with all the rest.
"""

from __future__ import annotations

import hashlib
import io
import itertools
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from dolfingrip.files import package, whole
from dolfingrip.files.result_file import ResultFileError
from dolfingrip.files.surrogate import SurrogateFile
from dolfingrip.sections.errors import ConfigError

if TYPE_CHECKING:
    import torch

Matrix = npt.NDArray[np.float64]
Vector = npt.NDArray[np.float64]

ACTIVATIONS = {"tanh": "Tanh", "silu": "SiLU"}
WEIGHTS = "surrogate.pt"
_BYTES = 8
"""Of a weight."""
_AS_THEY_ARE = package.PackagePolicy(ratio=1)
"""Weights are not compressed."""


class OutsideRange(UserWarning):
    """A surrogate was evaluated outside the range of its training inputs."""


@dataclass(frozen=True)
class Range:
    """Lowest and highest value of each column, shape (columns,) each."""

    low: Vector
    high: Vector

    @classmethod
    def of(cls, ends: Mapping[str, tuple[float, float]]) -> Range:
        """The ranges of columns that have names."""
        low, high = np.array(list(ends.values()), dtype=float).T
        return cls(low, high)

    def normalise(self, values: Matrix) -> Matrix:
        """0 at the lowest, 1 at the highest; shape as ``values``."""
        return (values - self.low) / self._width

    def restore(self, values: Matrix) -> Matrix:
        """The inverse of :meth:`normalise`."""
        return self.low + values * self._width

    @property
    def _width(self) -> Vector:
        width = self.high - self.low
        return np.where(width > 0, width, 1.0)  # a column that never changes


def network(layers: Sequence[int], activation: str) -> torch.nn.Sequential:
    """Fully connected layers of the given widths, in double precision.

    Double, because an optimiser compares designs that differ by less than single precision
    resolves.
    """
    from torch import nn

    parts: list[nn.Module] = []
    for wide, narrow in itertools.pairwise(layers):
        parts += [nn.Linear(wide, narrow), getattr(nn, ACTIVATIONS[activation])()]
    return nn.Sequential(*parts[:-1]).double()  # the last layer is linear


@dataclass(frozen=True)
class Surrogate:
    """Outputs of a design from its inputs, in the units that their names carry.

    Attributes:
        facts: ranges, layers, where it comes from and how well it fits: contents of
            ``surrogate.json``.
        net: network with its weights.
    """

    facts: SurrogateFile
    net: torch.nn.Sequential

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs in order."""
        return tuple(self.facts.inputs)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of the outputs in order."""
        return tuple(self.facts.outputs)

    @cached_property
    def inputs(self) -> Range:
        """Range of the designs it learnt from, those held out included."""
        return Range.of(self.facts.inputs)

    @cached_property
    def outputs(self) -> Range:
        """Range by which outputs are normalised, that of the training designs."""
        return Range.of(self.facts.outputs)

    def predict(self, inputs: Matrix, *, warn: bool = True) -> Matrix:
        """Outputs of many designs at once.

        Args:
            inputs: shape (designs, input names).
            warn: say where an input lies outside the range of the training table.

        Returns:
            Shape (designs, output names).

        Raises:
            ConfigError: where one of them is not finite.

        Warns:
            OutsideRange: naming the input, its value and the range.
        """
        import torch

        if warn:
            self._warn(inputs)
        with torch.no_grad():
            scaled = torch.from_numpy(2 * self.inputs.normalise(inputs) - 1)
            outputs = self.outputs.restore(self.net(scaled).numpy())
        if not np.isfinite(outputs).all():
            raise ConfigError("this surrogate gives no finite numbers; allowed: one that does")
        return outputs

    def output(self, name: str) -> int:
        """The column of an output.

        Raises:
            ConfigError: one line naming those there are.
        """
        if name not in self.output_names:
            raise ConfigError(f"no output {name}; allowed: {', '.join(self.output_names)}")
        return self.output_names.index(name)

    def sha256(self) -> str:
        """A fingerprint of weights and ranges: equal where all predictions are."""
        fields = {"inputs", "outputs", "layers", "activation"}
        digest = hashlib.sha256(self.facts.model_dump_json(include=fields).encode())
        for weights in self.net.parameters():
            digest.update(weights.detach().numpy().astype("<f8").tobytes())
        return digest.hexdigest()

    def save(self, folder: Path) -> None:
        """Write both files into ``folder``; the description last, so that it marks a whole one.

        Args:
            folder: made where missing.

        Raises:
            WriteError: one line; both files are then as before.
        """
        import torch

        stream = io.BytesIO()
        torch.save(self.net.state_dict(), stream)
        weights = stream.getvalue()
        facts = self.facts.model_copy(
            update={"weights_sha256": hashlib.sha256(weights).hexdigest()}
        )
        whole.write_together({folder / WEIGHTS: weights, folder / facts.FILE: facts.text()})

    def _warn(self, inputs: Matrix) -> None:
        for column, name in enumerate(self.input_names):
            low, high = self.inputs.low[column], self.inputs.high[column]
            values = inputs[:, column]
            beyond = np.maximum(low - values, values - high)
            if beyond.size and beyond.max() > 0:
                worst = values[int(beyond.argmax())]
                warnings.warn(
                    f"{name} = {worst:.4g}: the surrogate learnt from {low:.4g} to {high:.4g} "
                    f"({int((beyond > 0).sum())} of {len(values)} designs lie outside)",
                    OutsideRange,
                    stacklevel=3,
                )


def load(folder: Path) -> Surrogate:
    """Read a surrogate; nothing in its files is executed.

    Args:
        folder: with both files.

    Returns:
        The surrogate.

    Raises:
        ConfigError: one line, where a file is missing, not of this kind, or not of the other.
    """
    import torch

    try:
        facts = SurrogateFile.read(folder)
        weights = (folder / WEIGHTS).read_bytes()
    except ResultFileError as error:
        raise ConfigError(f"{error}; allowed: a surrogate") from None
    except OSError as error:
        raise ConfigError(f"{error.filename}: {error.strerror}; allowed: a surrogate") from None
    if (len(facts.inputs), len(facts.outputs)) != (*facts.layers[:1], *facts.layers[-1:]):
        raise ConfigError(f"{folder / facts.FILE}: layers = {facts.layers}: not of these inputs")
    if hashlib.sha256(weights).hexdigest() != facts.weights_sha256:
        raise ConfigError(f"{folder / WEIGHTS}: not the weights that {facts.FILE} was written for")
    others = ConfigError(f"{folder / WEIGHTS}: not the weights of this network alone")
    if _BYTES * sum(a * b + b for a, b in itertools.pairwise(facts.layers)) > len(weights):
        raise others  # before memory is taken for that many
    try:
        net = network(facts.layers, facts.activation)
        with package.opened(folder / WEIGHTS, _AS_THEY_ARE):
            # weights_only: an unpickler that knows tensors and nothing else
            state = torch.load(io.BytesIO(weights), weights_only=True, map_location="cpu")
        net.load_state_dict(state)
    except Exception:  # any error of the parser on a broken file
        raise others from None
    if not all(torch.isfinite(tensor).all() for tensor in net.parameters()):
        raise ConfigError(f"{folder / WEIGHTS}: weights that are no finite numbers")
    return Surrogate(facts, net)
