"""Draws mutants of the code with the operators of Cosmic Ray, as faults that can be planted.

    python -m venv VENV && VENV/bin/pip install cosmic-ray==8.7.0
    VENV/bin/python tests/tools/mutants.py [--number 40] [--seed 53]

The list is ``mutants.toml``; ``scripts/plant-faults --list mutants`` runs the tests that concern
each, and keeps the outcomes in ``mutants.csv``. A place of the code is drawn first, each as likely
as another, then one of the operators that change it. Annotations are no code, nor is what leaves
the syntax tree as it is.

An entry with a key ``equivalent`` is a mutant that no test can tell from the code; the key says
why. It is written by hand, and drawn anew the entry keeps it.
"""

from __future__ import annotations

import argparse
import ast
import random
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LIST = Path(__file__).with_name("mutants.toml")

FILES = ["faults/test_whole.py", "faults/test_full_disk.py"]
RESULTS = ["files", "test_columns.py", "report/test_page.py"]
REQUESTS = ["jobs/test_machine.py", "diagnosis/simulation/test_requests.py", "faults/test_ranks.py"]
CODE: dict[str, list[str]] = {
    "dolfingrip/files/whole.py": FILES,
    "dolfingrip/files/table.py": RESULTS,
    "dolfingrip/files/design.py": RESULTS,
    "dolfingrip/files/diagnosis.py": [*RESULTS, "diagnosis/test_page.py"],
    "dolfingrip/files/diagnosis_words.py": [*RESULTS, "diagnosis/test_page.py"],
    "dolfingrip/files/front.py": RESULTS,
    "dolfingrip/files/objective.py": ["files", "design/test_store.py", "design/test_objective.py"],
    "dolfingrip/files/optimum.py": ["files", "design/test_optimum.py"],
    "dolfingrip/files/plan.py": [*RESULTS, "diagnosis/plan"],
    "dolfingrip/files/result_file.py": RESULTS,
    "dolfingrip/files/run.py": [*RESULTS, "experiments/test_run.py"],
    "dolfingrip/files/surrogate.py": ["files", "design/test_surrogate.py"],
    "dolfingrip/jobs/connections.py": ["jobs/test_keys.py"],
    "dolfingrip/jobs/spool.py": ["faults/test_damage.py", "design/test_store.py"],
    "dolfingrip/jobs/store.py": ["faults/test_damage.py", "design/test_store.py"],
    "dolfingrip/mechanics/newton/callbacks.py": ["test_memory.py", "mechanics/test_cholesky.py"],
    "dolfingrip/mechanics/model/compilation.py": ["mechanics/test_compilation.py"],
    "dolfingrip/mechanics/model/compatibility.py": ["mechanics/test_finger.py"],
    "dolfingrip/experiments/request.py": REQUESTS,
    "dolfingrip/experiments/simulate.py": REQUESTS,
    "dolfingrip/config.py": ["test_changes.py", "test_config.py"],
    "dolfingrip/cli/edge.py": ["faults/test_command_line.py", "test_pipes.py", "test_cli.py"],
    "dolfingrip/design/quantities/grasp.py": ["design/test_gripper_design.py"],
    "dolfingrip/design/quantities/quantity.py": ["design/test_objective.py"],
    "dolfingrip/design/quantities/readings.py": ["design/test_objective.py"],
    "dolfingrip/design/quantities/shape.py": ["design/test_objective.py"],
    "dolfingrip/charts/chart.py": ["charts", "report/test_page.py"],
    "dolfingrip/charts/picture.py": ["charts"],
    "dolfingrip/diagnosis/data/motion.py": ["diagnosis/data/test_motion.py"],
}  # fmt: skip
"""What is mutated, and the tests that concern it, below ``tests/``."""


def positions(source: str) -> dict[tuple[int, int], list[tuple[str, int]]]:
    """Mutations of a source by the place that they change: operator, and its occurrence."""
    import cosmic_ray.plugins as plugins
    from cosmic_ray.ast import Visitor, get_ast

    found: dict[tuple[int, int], list[tuple[str, int]]] = defaultdict(list)
    tree = get_ast(source)
    for name in sorted(plugins.operator_names()):
        kind = plugins.get_operator(name)
        if kind.arguments():  # of variables' names
            continue
        operator, places = kind(), []

        class Places(Visitor):
            def visit(self, node: object) -> object:
                places.extend(start for start, _ in operator.mutation_positions(node))  # noqa: B023
                return node

        Places().walk(tree)
        for occurrence, place in enumerate(places):
            found[place].append((name, occurrence))
    return found


def bare(source: str) -> str:
    """The syntax tree without annotations."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign):
            node.annotation = ast.Constant(None)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            node.returns = None
    return ast.dump(tree)


def region(before: str, after: str, source: str) -> tuple[str, str]:
    """The lines that differ, with as many around them as make them unique in the source."""
    old, new = before.splitlines(keepends=True), after.splitlines(keepends=True)
    first = next(i for i, (a, b) in enumerate(zip(old, new, strict=False)) if a != b)
    last = next(
        i for i, (a, b) in enumerate(zip(reversed(old), reversed(new), strict=False)) if a != b
    )
    for around in range(len(old)):
        low, high = max(first - around, 0), max(last - around, 0)
        text = "".join(old[low : len(old) - high])
        if source.count(text) == 1:
            return text, "".join(new[low : len(new) - high])
    raise AssertionError


def drawn(number: int, seed: int) -> Iterator[tuple[str, str, str, str]]:
    """File, operator, text and fault of so many mutants."""
    import cosmic_ray.plugins as plugins
    from cosmic_ray.mutating import mutate_code

    rng = random.Random(seed)
    sources = {file: (ROOT / file).read_text(encoding="utf-8") for file in CODE}
    known = {file: positions(source) for file, source in sources.items()}
    places = [(file, place) for file, found in known.items() for place in sorted(found)]
    rng.shuffle(places)
    for file, place in places:
        if not number:
            return
        name, occurrence = rng.choice(known[file][place])
        mutant = mutate_code(sources[file], plugins.get_operator(name)(), occurrence)
        if mutant is None:
            continue
        try:
            if bare(mutant) == bare(sources[file]):
                continue
        except SyntaxError:
            continue
        number -= 1
        yield file, name.removeprefix("core/"), *region(sources[file], mutant, sources[file])


def main() -> None:
    """Draw the mutants, and write the list."""
    parser = argparse.ArgumentParser(prog="tests/tools/mutants.py")
    parser.add_argument("--number", type=int, default=40)
    parser.add_argument("--seed", type=int, default=53)
    asked = parser.parse_args()
    before = tomllib.loads(LIST.read_text(encoding="utf-8")) if LIST.exists() else {}
    lines = [
        f"# Mutants of seed {asked.seed}: see mutants.py. `text` stands in `file` once.\n",
    ]
    for number, (file, what, text, fault) in enumerate(drawn(asked.number, asked.seed), 1):
        name = f"{Path(file).stem}-{number}"
        table = {"file": file, "what": what, "text": text, "fault": fault, "tests": CODE[file]}
        same = before.get(name, {})
        if same.get("fault") == fault and "equivalent" in same:
            table["equivalent"] = same["equivalent"]
        lines.append(f"\n[{name}]\n")
        lines += [f"{key} = {_toml(value)}\n" for key, value in table.items()]
    LIST.write_text("".join(lines), encoding="utf-8")
    sys.stdout.write(f"seed {asked.seed}: {asked.number} mutants in {LIST}\n")


def _toml(value: str | list[str]) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if "\n" in value and "'''" not in value:
        return f"'''\n{value}'''"
    return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


if __name__ == "__main__":
    main()
