"""A small neural network in place of the finite element model (the paper's section IV.B).

On disk a surrogate is two files, neither of which can run code when read: ``surrogate.pt`` with
the weights alone and ``surrogate.json`` with all the rest.
"""

from __future__ import annotations

import hashlib
import io
import itertools
import json
import pickle
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from dolfingrip.files import whole
from dolfingrip.sections.errors import ConfigError

Matrix = npt.NDArray[np.float64]
Vector = npt.NDArray[np.float64]

ACTIVATIONS = {"tanh": torch.nn.Tanh, "silu": torch.nn.SiLU}
WEIGHTS, DESCRIPTION = "surrogate.pt", "surrogate.json"
FORMAT = 1
"""Version of the description; raised where its meaning changes."""


class OutsideRange(UserWarning):
    """A surrogate was evaluated outside the range of its training inputs."""


@dataclass(frozen=True)
class Range:
    """Lowest and highest value of each column, shape (columns,) each."""

    low: Vector
    high: Vector

    @classmethod
    def of(cls, values: Matrix) -> Range:
        """The range of each column of ``values``, shape (rows, columns)."""
        return cls(values.min(axis=0), values.max(axis=0))

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
    parts: list[torch.nn.Module] = []
    for wide, narrow in itertools.pairwise(layers):
        parts += [torch.nn.Linear(wide, narrow), ACTIVATIONS[activation]()]
    return torch.nn.Sequential(*parts[:-1]).double()  # the last layer is linear


@dataclass(frozen=True)
class Surrogate:
    """Outputs of a design from its inputs, in the units that their names carry.

    Attributes:
        inputs: range of the designs it learnt from, those held out included.
        outputs: range by which outputs are normalised, that of the training designs.
        facts: where it comes from and how well it fits; JSON-serialisable.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    inputs: Range
    outputs: Range
    layers: tuple[int, ...]
    activation: str
    net: torch.nn.Sequential
    facts: dict[str, Any] = field(default_factory=dict)

    def predict(self, inputs: Matrix, *, warn: bool = True) -> Matrix:
        """Outputs of many designs at once.

        Args:
            inputs: shape (designs, input names).
            warn: say where an input lies outside the range of the training table.

        Returns:
            Shape (designs, output names).

        Warns:
            OutsideRange: naming the input, its value and the range.
        """
        if warn:
            self._warn(inputs)
        with torch.no_grad():
            scaled = torch.from_numpy(2 * self.inputs.normalise(inputs) - 1)
            return self.outputs.restore(self.net(scaled).numpy())

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
        digest = hashlib.sha256(json.dumps(self._description(), sort_keys=True).encode())
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
        weights = _bytes(self.net)
        content = {
            **self._description(),
            "weights_sha256": hashlib.sha256(weights).hexdigest(),
            **self.facts,
        }
        text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
        whole.write_together({folder / WEIGHTS: weights, folder / DESCRIPTION: text})

    def _description(self) -> dict[str, Any]:
        def ranges(names: Sequence[str], found: Range) -> dict[str, list[float]]:
            return {
                name: [float(low), float(high)]
                for name, low, high in zip(names, found.low, found.high, strict=True)
            }

        return {
            "format": FORMAT,
            "inputs": ranges(self.input_names, self.inputs),
            "outputs": ranges(self.output_names, self.outputs),
            "normalisation": "inputs to [-1, 1], outputs to [0, 1] by these ranges",
            "layers": list(self.layers),
            "activation": self.activation,
        }

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
    try:
        description = json.loads((folder / DESCRIPTION).read_text(encoding="utf-8"))
        weights = (folder / WEIGHTS).read_bytes()
    except OSError as error:
        raise ConfigError(f"{error.filename}: {error.strerror}; allowed: a surrogate") from None
    except (ValueError, RecursionError):
        raise ConfigError(f"{folder / DESCRIPTION}: not JSON") from None
    try:
        found = _described(description)
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ConfigError(f"{folder / DESCRIPTION}: not the description of a surrogate") from None
    if hashlib.sha256(weights).hexdigest() != description.get("weights_sha256"):
        raise ConfigError(f"{folder / WEIGHTS}: not the weights that {DESCRIPTION} was written for")
    try:
        # weights_only: an unpickler that knows tensors and nothing else
        state = torch.load(io.BytesIO(weights), weights_only=True, map_location="cpu")
        found.net.load_state_dict(state)
    except (pickle.UnpicklingError, RuntimeError, TypeError, EOFError, AttributeError):
        raise ConfigError(f"{folder / WEIGHTS}: not the weights of this network alone") from None
    return found


def _described(description: dict[str, Any]) -> Surrogate:
    """The surrogate of a description, its weights still to come."""
    if description["format"] != FORMAT:
        raise ValueError
    inputs, outputs = description["inputs"], description["outputs"]
    known = {"format", "inputs", "outputs", "normalisation", "layers", "activation"}
    layers = tuple(int(width) for width in description["layers"])
    if layers[0] != len(inputs) or layers[-1] != len(outputs):
        raise ValueError
    return Surrogate(
        tuple(inputs),
        tuple(outputs),
        _range(inputs),
        _range(outputs),
        layers,
        description["activation"],
        network(layers, description["activation"]),
        {key: value for key, value in description.items() if key not in known | {"weights_sha256"}},
    )


def _range(bounds: dict[str, list[float]]) -> Range:
    both = np.array(list(bounds.values()), dtype=np.float64)
    return Range(both[:, 0], both[:, 1])


def _bytes(net: torch.nn.Module) -> bytes:
    stream = io.BytesIO()
    torch.save(net.state_dict(), stream)
    return stream.getvalue()
