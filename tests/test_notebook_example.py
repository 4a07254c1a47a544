"""The example notebook runs from its first cell to its last, and is kept without outputs."""

import re
import shutil
from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

EXAMPLES = Path(__file__).parent.parent / "examples"
NOTEBOOK = "plaza.ipynb"


def test_it_is_kept_without_outputs():
    cells = nbformat.read(EXAMPLES / NOTEBOOK, as_version=4).cells
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in cells)


def test_every_cell_runs_and_what_it_shows_is_true(tmp_path, monkeypatch):
    for name in (NOTEBOOK, "plaza.jpg", "plaza.json", "plaza_truth.csv"):
        shutil.copy(EXAMPLES / name, tmp_path)
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(tmp_path / NOTEBOOK, as_version=4)
    nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(tmp_path)}}).execute()

    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert not [o for o in outputs if o["output_type"] == "error" or o.get("name") == "stderr"]
    texts = "".join(o["text"] for o in outputs if o["output_type"] == "stream")
    error, inside, count = re.search(r"mean error ([\d.]+) %, (\d+) of (\d+) inside", texts).groups()
    assert float(error) < 6 and int(count) == 15 and int(inside) >= 13
    metres = [float(m) for m in re.findall(r"stand ([\d.]+) m apart", texts)]
    assert metres == sorted(metres) and len(metres) == 3  # a longer lens, the same picture: farther apart in depth
    shown = [o["data"] for o in outputs if "data" in o]
    assert sum("image/png" in data for data in shown) == 1
    assert "90 %" in shown[0]["text/html"] and (tmp_path / "results" / "pairs.csv").is_file()
