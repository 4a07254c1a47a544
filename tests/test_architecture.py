"""Imports point one way, files stay small, and the package is light to import."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import proxemetry

SOURCE = Path(proxemetry.__file__).parent

#: A module imports only from those above it. Names in one row stand side by side.
LAYERS = (
    ("errors", "version", "arrays", "intervals", "telemetry", "text_tables"),
    ("assignment", "overlap", "files"),
    ("photo",),
    ("people",),
    ("camera",),
    ("weights",),
    ("pose",),
    ("anthropometry",),
    ("bodies",),
    ("locate",),
    ("calibration",),
    ("draws", "settings"),
    ("formations",),
    ("distances",),
    ("proxemics", "scene_json"),
    ("scene",),
    ("tables",),
    ("display",),
    ("measure",),
    ("plots",),
    ("benchmark",),
    ("archive",),
    ("clip",),
    ("evaluate",),
    ("annotate",),
    ("report",),
    ("web",),
    ("cli",),
)
LEVEL = {name: level for level, names in enumerate(LAYERS) for name in names}

#: Methods for notebooks that only call what stands above them, loaded inside the method.
SHORTCUTS = {("scene", "display"), ("scene", "plots")}

#: What scores predictions may know of the rest: never a model, never a photo.
BENCHMARK_MAY_IMPORT = {
    "errors",
    "files",
    "arrays",
    "intervals",
    "text_tables",
    "assignment",
    "scene",
    "distances",
    "people",
    "bodies",
    "camera",
}

HEAVY = (
    "ai_edge_litert", "onnxruntime", "openvino", "cv2", "matplotlib", "duckdb", "starlette", "uvicorn", "ray", "fsspec",
    "tqdm", "lensfunpy", "pyreadstat",
)  # fmt: skip


def _modules():
    return sorted(p for p in SOURCE.rglob("*.py") if p.name != "__main__.py" and p != SOURCE / "__init__.py")


def _owner(path):
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def _name(path):
    """Return a module's dotted name below the package, "" for the package itself."""
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {_name(path) for path in SOURCE.rglob("*.py")}


def _imported(path):
    """Return the modules of the package that a file imports, wherever in the file, by their dotted names."""
    package = ("proxemetry", *path.relative_to(SOURCE).parts[:-1])
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            targets = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            stem = ".".join((*base, *filter(None, [node.module])))
            targets = [f"{stem}.{alias.name}" for alias in node.names]  # a module of that name, or a name in `stem`
        else:
            continue
        for target in targets:
            parts = target.split(".")
            if parts[0] == "proxemetry":
                longest = (".".join(parts[1:end]) for end in range(len(parts), 0, -1))
                found.add(next(name for name in longest if name in NAMES))
    return found - {_name(path)}


def _circles(graph):
    """Return the groups of modules each of which reaches all the others of its group."""

    def reached(start):
        seen, waiting = set(), [start]
        while waiting:
            new = graph[waiting.pop()] - seen
            seen |= new
            waiting += new
        return seen

    reach = {name: reached(name) for name in graph}
    return sorted({tuple(sorted(o for o in reach[n] if n in reach[o])) for n in graph if n in reach[n]})


def test_no_module_imports_itself_by_a_detour():
    assert _circles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [("a", "b", "c")]
    graph = {
        _name(path): {name for name in _imported(path) if (_owner(path), name.split(".")[0]) not in SHORTCUTS}
        for path in SOURCE.rglob("*.py")
    }
    assert _circles(graph) == []


@pytest.mark.parametrize("path", _modules(), ids=lambda p: str(p.relative_to(SOURCE)))
def test_imports_point_upwards(path):
    owner = _owner(path)
    assert owner in LEVEL, f"{owner} has no place in LAYERS"
    for imported in {name.split(".")[0] for name in _imported(path)} - {owner}:
        assert imported in LEVEL, f"{imported} has no place in LAYERS"
        upwards = LEVEL[imported] < LEVEL[owner]
        assert upwards or (owner, imported) in SHORTCUTS, f"{owner} must not import {imported}"
        if owner == "benchmark":
            assert imported in BENCHMARK_MAY_IMPORT, f"benchmark must not import {imported}"


@pytest.mark.parametrize("path", _modules(), ids=lambda p: str(p.relative_to(SOURCE)))
def test_names_say_what_is_inside(path):
    assert path.stem not in {"utils", "helpers", "core", "base", "common", "misc"}


def test_the_package_is_light_to_import():
    program = f"import sys, proxemetry; print([m for m in {HEAVY!r} if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_help_is_light():
    program = (
        "import sys, proxemetry.cli as c\n"
        "try: c.main(['--help'])\n"
        f"except SystemExit: pass\nprint([m for m in {HEAVY!r} if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert found.stdout.strip().splitlines()[-1] == "[]"
