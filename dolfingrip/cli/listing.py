"""The subcommands in the order in which a new user needs them, and what each does.

Summaries are read from the sources, so that ``--help`` imports no command. Imports of one take a
second or more.
"""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).parents[1]

_BEFORE = {"demo": ("experiment_commands", "demo")}
_AFTER = {
    "pickup": ("pickup_commands", "pickup"),
    "friction": ("pickup_commands", "friction"),
    "adopt": ("adopt_command", "adopt"),
    "mesh": ("mesh_command", "mesh"),
    "export": ("export_command", "export"),
    "morph": ("morph_command", "morph"),
    "config": ("config_command", "config"),
    "columns": ("columns_command", "columns"),
    "extensions": ("extensions_command", "extensions"),
    "synthetic": ("experiment_commands", "synthetic_measurement"),
    "diagnose": ("diagnose_command", "diagnose"),
    "plan-experiment": ("plan_command", "plan_experiment"),
    "predict": ("predict_command", "predict"),
    "design": ("design_command", "design"),
    "doe": ("doe_commands", "doe"),
    "train": ("train_command", "train"),
    "optimise": ("optimise_command", "optimise"),
    "study": ("study_command", "study"),
    "reproduce": ("reproduce_command", "reproduce"),
    "report": ("report_command", "report"),
    "explore": ("explore_command", "explore"),
    "doctor": ("doctor_command", "doctor"),
}
HOME = _BEFORE | _AFTER
"""Module in this package, and function there, of each subcommand that is no experiment's."""


def names() -> list[str]:
    """List all subcommands in the order of use."""
    return [*_BEFORE, *experiments(), *_AFTER]


def summary(name: str) -> str:
    """Read what a subcommand does from its source.

    Args:
        name: of the subcommand.

    Returns:
        The docstring of its function, or of its experiment.
    """
    if name not in HOME:
        return experiments()[name]
    module, function = HOME[name]
    body = _body(_PACKAGE / "cli" / f"{module}.py")
    found = (node for node in body if isinstance(node, ast.FunctionDef) and node.name == function)
    return ast.get_docstring(next(found)) or ""


@cache
def experiments() -> dict[str, str]:
    """Read what the experiments of the index do, by their subcommands' names."""
    folder = _PACKAGE / "experiments"
    files = _values(_body(folder / "index.py"))["NAMES"]
    found = {}
    for file in files:
        for node in _body(folder / f"{file}.py"):
            if isinstance(node, ast.ClassDef) and "command" in (had := _values(node.body)):
                command, name = had["command"], had.get("name", had["command"])
                line = (ast.get_docstring(node) or "").splitlines()[0]
                named = f" In files and Python: {name}."
                found[command] = line if name == command else line + named
    return found


def _body(file: Path) -> list[ast.stmt]:
    return ast.parse(file.read_text(encoding="utf-8")).body


def _values(body: list[ast.stmt]) -> dict[str, str]:
    """Names that are given constants."""
    found = {}
    for node in body:
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            target = node.targets[0] if isinstance(node, ast.Assign) else node.target
            try:
                found[ast.unparse(target)] = ast.literal_eval(node.value)
            except ValueError:
                continue
    return found
