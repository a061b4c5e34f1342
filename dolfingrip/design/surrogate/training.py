"""Training of the surrogate: split, epochs, learning curve (the paper's section IV.B)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Final, Literal

import numpy as np
import numpy.typing as npt

from dolfingrip.design.surrogate.surrogate import Matrix, Surrogate, network
from dolfingrip.design.surrogate.table import Table
from dolfingrip.files.surrogate import OutputError, SurrogateFile
from dolfingrip.sections.errors import ConfigError
from dolfingrip.version import versions_of

if TYPE_CHECKING:
    import torch

Progress = Callable[[int], None]
type Pair = tuple[torch.Tensor, torch.Tensor]


@dataclass(frozen=True)
class TrainingSettings:
    """How a surrogate is trained; layers, epochs and split are the paper's.

    The paper names neither activation nor optimiser nor rate. Adam on the full batch (166 designs
    need no smaller ones) with a rate that falls by cosine from ``rate`` to a thousandth of it.
    """

    hidden: tuple[int, ...] = (20, 50)
    activation: Literal["tanh", "silu"] = "tanh"
    epochs: int = 5000
    test_share: float = 0.2
    rate: float = 0.01
    seed: int = 0


FEWEST_DESIGNS: Final = 10
"""Number of designs below which a held-out fifth says nothing."""

GOAL_MSE: Final = 1e-3
"""The paper's error of normalised outputs, for training and for test designs."""

SAMPLED_EPOCHS: Final = 10
"""Epochs between two entries of the learning curve."""


@dataclass(frozen=True)
class Training:
    """A trained surrogate and what happened.

    Attributes:
        curve: ``epoch``, from 0 (untrained) on, ``training_mse`` and ``test_mse`` of normalised
            outputs after that many epochs.
        test: shape (designs,), whether a design of the table was held out.
    """

    surrogate: Surrogate
    curve: list[dict[str, float]]
    test: npt.NDArray[np.bool_]


def split(rows: int, share: float, seed: int) -> npt.NDArray[np.bool_]:
    """Choose the rows that are held out for testing, at random.

    Args:
        rows: number of them.
        share: part of them that is held out.
        seed: of the random numbers.

    Returns:
        Shape (rows,), true for those.
    """
    held_out = np.zeros(rows, dtype=bool)
    order = np.random.default_rng(seed).permutation(rows)
    held_out[order[: round(share * rows)]] = True
    return held_out


def train(
    table: Table,
    settings: TrainingSettings = TrainingSettings(),
    progress: Progress | None = None,
    campaign: dict[str, Any] | None = None,
) -> Training:
    """Fit the network to a table.

    Args:
        table: designs that were computed.
        settings: the paper's by default.
        progress: called with the number of epochs done.
        campaign: what all designs share; None: not known.

    Returns:
        The surrogate and its learning curve.

    Raises:
        ConfigError: too few designs.
    """
    import torch

    if len(table) < FEWEST_DESIGNS:
        raise ConfigError(f"{len(table)} computed designs; allowed: at least {FEWEST_DESIGNS}")
    test = split(len(table), settings.test_share, settings.seed)
    facts = SurrogateFile(
        inputs=_ends(table.input_names, table.inputs),
        outputs=_ends(table.output_names, table.outputs[~test]),
        layers=(table.inputs.shape[1], *settings.hidden, table.outputs.shape[1]),
        activation=settings.activation,
        settings=asdict(settings),
        campaign=campaign,
    )
    with torch.random.fork_rng(devices=[]):  # the caller's random numbers stay as they are
        torch.manual_seed(settings.seed)
        net = network(facts.layers, facts.activation)
    surrogate = Surrogate(facts, net)
    x = torch.from_numpy(2 * surrogate.inputs.normalise(table.inputs) - 1)
    y = torch.from_numpy(surrogate.outputs.normalise(table.outputs))
    held_out = torch.from_numpy(test)
    parts = {"training": (x[~held_out], y[~held_out]), "test": (x[held_out], y[held_out])}
    curve = _fit(net, parts, settings, progress)
    surrogate = replace(surrogate, facts=_judged(surrogate, table, test, curve[-1]))
    return Training(surrogate, curve, test)


def _fit(
    net: torch.nn.Module,
    parts: dict[str, Pair],
    settings: TrainingSettings,
    progress: Progress | None,
) -> list[dict[str, float]]:
    """Train in place; the learning curve of each part of the designs."""
    import torch

    adam = torch.optim.Adam(net.parameters(), lr=settings.rate)
    decay = torch.optim.lr_scheduler.CosineAnnealingLR(
        adam, settings.epochs, eta_min=settings.rate / 1000
    )
    mse = torch.nn.functional.mse_loss

    def errors(epoch: int) -> dict[str, float]:
        with torch.no_grad():
            mses = {f"{part}_mse": float(mse(net(x), y)) for part, (x, y) in parts.items()}
        return {"epoch": epoch, **mses}

    curve, (x, y) = [errors(0)], parts["training"]
    for epoch in range(1, settings.epochs + 1):
        adam.zero_grad()
        mse(net(x), y).backward()
        adam.step()
        decay.step()
        if epoch % SAMPLED_EPOCHS == 0 or epoch == settings.epochs:
            curve.append(errors(epoch))
            if progress is not None:
                progress(epoch)
    return curve


def _ends(names: Sequence[str], values: Matrix) -> dict[str, tuple[float, float]]:
    """Lowest and highest value of each column."""
    low, high = values.min(axis=0).tolist(), values.max(axis=0).tolist()
    return dict(zip(names, zip(low, high, strict=True), strict=True))


def _judged(
    surrogate: Surrogate,
    table: Table,
    test: npt.NDArray[np.bool_],
    last: dict[str, float],
) -> SurrogateFile:
    """Contents of ``surrogate.json`` with what came of the training."""
    miss = surrogate.predict(table.inputs) - table.outputs
    rms = {
        name: OutputError(
            training=float(np.sqrt(np.mean(miss[~test, column] ** 2))),
            test=float(np.sqrt(np.mean(miss[test, column] ** 2))),
        )
        for column, name in enumerate(table.output_names)
    }
    return surrogate.facts.model_copy(
        update={
            "training_mse": last["training_mse"],
            "test_mse": last["test_mse"],
            "rms_error": rms,
            "training_designs": int((~test).sum()),
            "test_designs": int(test.sum()),
            "failed_designs": table.failed,
            "incomplete_designs": table.incomplete,
            "table_sha256": table.sha256(),
            "versions": versions_of("torch", "numpy"),
        }
    )
