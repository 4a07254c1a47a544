"""`proxemetry models` as scripts use it: exit codes, one line for what went wrong, paths on standard output."""

from __future__ import annotations

import hashlib

import pytest

from proxemetry import weights
from proxemetry.cli import main
from proxemetry.weights import Model, table

CONTENT = b"a small network"


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path / "cache"))
    model = Model("tiny.onnx", hashlib.sha256(CONTENT).hexdigest(), 15, (), "a test", "MIT", "none")
    monkeypatch.setitem(table.MODELS, model.name, model)
    return tmp_path / "cache"


def test_list_has_a_row_for_every_network(cache, capsys):
    assert main(["models", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = [line.split()[0] for line in lines if not line.startswith(("    ", "name", "commercial:"))]
    assert rows == list(weights.MODELS) and max(map(len, lines)) <= 100
    assert (
        "Apache-2.0" in lines[1 + next(k for k, line in enumerate(lines) if line.startswith("pose_detection.tflite"))]
    )


def test_add_then_path_then_verify(cache, tmp_path, capsys):
    own = tmp_path / "own.bin"
    own.write_bytes(CONTENT)
    assert main(["models", "add", str(own)]) == 0
    assert main(["models", "path", "tiny"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(cache / "tiny.onnx")
    assert main(["models", "verify"]) == 0
    (cache / "tiny.onnx").write_bytes(b"damaged")
    assert main(["models", "verify"]) == 1
    assert "damaged" in capsys.readouterr().out


def test_verify_without_any_says_how_to_get_them(cache, capsys):
    assert main(["models", "verify"]) == 0
    assert "models fetch" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["fetch", "nonsense"], "is not in the table"),
        (["fetch", "--offline"], "offline"),
        (["fetch", "tiny"], "its licence does not allow passing it on"),
        (["path", "tiny"], "models add FILE"),
        (["add", "/no/such/file"], "no such file"),
    ],
)
def test_what_cannot_be_done_is_one_line_and_exit_code_2(cache, capsys, arguments, expected):
    assert main(["models", *arguments]) == 2
    error = capsys.readouterr().err
    assert expected in error
    assert error.count("\n") == 1
