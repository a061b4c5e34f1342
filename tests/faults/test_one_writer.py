"""No file is written but by the one writer: the calls that write are looked for in the code."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from support.checkout import needs_checkout, sources

WRITER = "dolfingrip/files/"

METHODS = {
    "write_text", "write_bytes", "touch", "to_csv", "to_parquet", "to_json", "savefig", "savetxt",
    "savez", "savez_compressed", "imsave", "save", "mkstemp", "NamedTemporaryFile",
    "copy2", "copyfile", "copytree", "VTKFile", "XDMFFile", "VTXWriter", "write_table",
    "write_csv", "write_image", "write_html", "mkfifo", "symlink_to", "hardlink_to",
}  # fmt: skip
"""Names of methods that write a file where it is what they are given."""

FUNCTIONS = {
    "gmsh.write", "meshio.write", "json.dump", "pickle.dump", "shutil.copy", "shutil.move",
    "os.rename", "os.replace", "av.open",
}  # fmt: skip
"""The same of functions whose names alone say too little."""

ALLOWED = {
    ("dolfingrip/mechanics/model/compilation.py", "open"): "a lock",
    ("dolfingrip/mechanics/model/compilation.py", "rename"): "the folder of a compiled form",
    ("dolfingrip/cli/surrogate_commands.py", "save"): "a surrogate, by the writer",
    ("dolfingrip/jobs/spool.py", "open"): "a lock",
    ("dolfingrip/jobs/store.py", "open"): "a lock",
    ("dolfingrip/jobs/store.py", "rename"): "a damaged store is set aside",
    ("dolfingrip/jobs/spool.py", "rename"): "a damaged answer is set aside",
    ("dolfingrip/cli/edge.py", "open"): "the null device",
    ("dolfingrip/charts/theme.py", "savefig"): "into a stream",
    ("dolfingrip/report/video.py", "save"): "into a stream",
    ("dolfingrip/report/page/results/run.py", "save"): "into a stream",
    ("dolfingrip/design/surrogate/surrogate.py", "save"): "into a stream",
    ("dolfingrip/diagnosis/results.py", "to_csv"): "a text",
    ("dolfingrip/importing/importing.py", "to_csv"): "a text",
    ("dolfingrip/tracking/table.py", "to_csv"): "a text",
    ("meshes/gmsh_model.py", "copyfile"): "a mesh that is read, alone in a folder",
    ("meshes/files.py", "write"): "a library's file, which is read back",
    ("dolfingrip/report/printable.py", "write"): "a library's file, whose end is checked",
}
"""What else writes, by file and call, and why that is no way around the writer."""


def writing(source: str) -> Iterator[tuple[str, int]]:
    """Calls that write a file: their names, and their lines."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Call) and _writes(node):
            yield getattr(node.func, "attr", getattr(node.func, "id", "")), node.lineno


def _writes(call: ast.Call) -> bool:
    if isinstance(call.func, ast.Name):
        return call.func.id == "open" and _mode(call)
    if not isinstance(call.func, ast.Attribute):
        return False
    name = call.func.attr
    if name == "open":
        return _mode(call) or "O_CREAT" in ast.unparse(call)
    if name in (
        "replace",
        "rename",
    ):  # of a path, which takes one argument; that of a text takes two
        return ast.unparse(call.func) in FUNCTIONS or (len(call.args) == 1 and not call.keywords)
    return name in METHODS or ast.unparse(call.func) in FUNCTIONS


def _mode(call: ast.Call) -> bool:
    """Whether the mode is given and allows to write."""
    given = [*call.args, *(each.value for each in call.keywords if each.arg == "mode")]
    texts = [str(each.value) for each in given if isinstance(each, ast.Constant)]
    return any(set("wax+") & set(text) and set(text) <= set("rwaxbt+") for text in texts)


def test_the_search_finds_what_it_looks_for() -> None:
    found = [
        "path.write_text('a')", "open(file, 'w')", "file.open('wb')", "path.open(mode='a')",
        "gmsh.write(name)", "figure.savefig(path)", "table.to_csv(path)", "os.rename(a, b)",
        "partial.replace(path)", "os.open(path, os.O_WRONLY | os.O_CREAT)", "json.dump(a, file)",
    ]  # fmt: skip
    for each in found:
        assert list(writing(each)), each
    for each in ("path.open()", "open(file, 'rb')", "open('wax.txt')", "sys.stdout.write('a')"):
        assert not list(writing(each)), each


@needs_checkout
def test_all_files_are_written_by_the_one_writer() -> None:
    used = set()
    around = []
    for name, text in sources():
        if name.startswith(WRITER):
            continue
        for call, line in writing(text):
            if (name, call) in ALLOWED:
                used.add((name, call))
            else:
                around.append(f"{name}:{line}: {call}")
    assert not around
    assert used == set(ALLOWED)  # none that is not needed any more
