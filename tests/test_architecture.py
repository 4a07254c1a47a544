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
    ("errors", "version", "arrays", "intervals", "telemetry"),
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
    ("distances", "settings"),
    ("proxemics",),
    ("scene",),
    ("tables",),
    ("display",),
    ("measure",),
    ("plots",),
    ("benchmark",),
    ("archive",),
    ("clip",),
    ("evaluate",),
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


def _imported(path):
    """Yield the top-level modules of the package that a file imports, wherever in the file."""
    package = ("proxemetry", *path.relative_to(SOURCE).parts[:-1])
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else ()
            stem = ".".join((*base, *filter(None, [node.module])))
            names = [f"{stem}.{alias.name}" for alias in node.names] if stem == "proxemetry" else [stem]
        else:
            continue
        for name in names:
            parts = name.split(".")
            if parts[0] == "proxemetry" and len(parts) > 1 and not parts[1].startswith("__"):
                yield parts[1]


@pytest.mark.parametrize("path", _modules(), ids=lambda p: str(p.relative_to(SOURCE)))
def test_imports_point_upwards(path):
    owner = _owner(path)
    assert owner in LEVEL, f"{owner} has no place in LAYERS"
    for imported in set(_imported(path)) - {owner}:
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
