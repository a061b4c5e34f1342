"""Files of others are read by few functions, as data: other ways are looked for in the code.

A call that is new here needs a reason why a stranger's file, or what lies beside it, runs nothing.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from support.checkout import needs_checkout, sources

CALLS = {
    "gmsh.initialize", "gmsh.merge", "gmsh.open", "gmsh.model.occ.importShapes",
    "pv.read", "pv.get_reader", "meshio.read", "openpyxl.load_workbook", "ZipFile",
    "ElementTree.parse", "ElementTree.fromstring", "ElementTree.iterparse", "minidom.parse",
    "fromstring", "iterparse", "torch.load", "np.load", "pickle.load", "pickle.loads", "eval",
    "exec", "importlib.import_module", "__import__", "runpy.run_path",
}  # fmt: skip
"""Calls by which a library reads a file of its format, or by which Python runs one."""

ALLOWED = {
    ("dolfingrip/cli/command.py", "importlib.import_module"): "a command of ours",
    ("dolfingrip/cli/doctor_command.py", "importlib.import_module"): "libraries, by names of ours",
    ("dolfingrip/design/surrogate/surrogate.py", "torch.load"): "tensors alone",
    ("dolfingrip/files/package.py", "ZipFile"): "what all others call",
    ("dolfingrip/files/xml.py", "fromstring"): "what all others call",
    ("dolfingrip/files/xml.py", "iterparse"): "what all others call",
    ("dolfingrip/importing/cells.py", "openpyxl.load_workbook"): "its parts are looked at before",
    ("dolfingrip/jobs/work.py", "importlib.import_module"): "a function that the caller names",
    ("dolfingrip/loading.py", "__import__"): "PyPI's DOLFINx",
    ("dolfingrip/plugins.py", "importlib.import_module"): "what the user names by --plugin",
    ("dolfingrip/report/drawers.py", "importlib.import_module"): "modules of ours",
    ("dolfingrip/report/printable.py", "ZipFile"): "which is written",
    ("dolfingrip/robot/runs.py", "pv.get_reader"): "fields that this process has written",
    ("dolfingrip/sections/lookup.py", "importlib.import_module"): "modules of ours",
    ("meshes/gmsh_model.py", "gmsh.initialize"): "without files of settings",
    ("meshes/gmsh_model.py", "gmsh.model.occ.importShapes"): "elsewhere",
    ("meshes/gmsh_model.py", "gmsh.open"): "alone in a folder",
    ("meshes/vtk_file.py", "pv.read"): "what all others call",
}
"""What reads so, by file and call, and why it is safe."""


def calls(source: str) -> Iterator[tuple[str, int]]:
    """Calls that read a library's file or run one, and Python's that look into a stranger's folder.

    Args:
        source: text of a file.

    Yields:
        Name and line of each; ``python`` where Python is called without ``-P``.
    """
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and ast.unparse(node.func) in CALLS:
            yield ast.unparse(node.func), node.lineno
        if isinstance(node, ast.List):
            words = [ast.unparse(each) for each in node.elts]
            if "sys.executable" in words:
                flag = words[words.index("sys.executable") + 1 :][:1]
                if flag != ["'-P'"]:
                    yield "python", node.lineno


def test_the_search_finds_what_it_looks_for() -> None:
    for each in ("gmsh.open(a)", "with ZipFile(a): pass", "f(torch.load(a))", "eval(a)",
                 "[sys.executable, '-c', a]", "run([*b, sys.executable, '-m', a])"):  # fmt: skip
        assert list(calls(each)), each
    for each in ("path.open()", "ast.literal_eval(a)", "[sys.executable, '-P', '-c', a]"):
        assert not list(calls(each)), each


@needs_checkout
def test_files_of_others_are_read_as_data() -> None:
    around, used = [], set()
    for name, text in sources():
        for call, line in calls(text):
            if (name, call) in ALLOWED:
                used.add((name, call))
            else:
                around.append(f"{name}:{line}: {call}")
    assert not around
    assert used == set(ALLOWED)  # none that is not needed any more
