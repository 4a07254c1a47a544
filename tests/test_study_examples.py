"""The worked study's scripts, run by the programs they are for, where those are installed."""

import csv
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from proxemetry.cli import main
from synthetic.reviewing import make_results

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_results(tmp_path_factory.mktemp("made")).folder.location


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed")
def test_the_r_script_reads_the_tables(folder):
    done = subprocess.run(
        ["Rscript", str(ROOT / "examples" / "study" / "nearest.R"), folder], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert "market" in done.stdout and "park" in done.stdout
    photos = csv.DictReader((Path(folder) / "photos.csv").read_text().splitlines())
    known = [row["focal_assumed"] == "false" for row in photos if int(row["n_pairs"] or 0)]
    assert any(known) and not all(known)
    every, without = done.stdout.split("photos whose focal length was not assumed")
    assert _photos_counted(every) == len(known) and _photos_counted(without) == sum(known)


def _photos_counted(printed: str) -> float:
    """Sum the numbers of photos by group in R's print of both columns, n and median."""
    rows = re.findall(r"^\d+\s+\S+\s+(\d+\.?\d*)\s+\d", printed, re.MULTILINE)
    return sum(map(float, rows))


@pytest.mark.skipif(shutil.which("pspp") is None, reason="PSPP is not installed")
def test_the_spss_syntax_reads_the_tables(folder, tmp_path):
    pytest.importorskip("pyreadstat")
    assert main(["export", folder, "--format", "spss", "--out", str(tmp_path)]) == 0
    syntax = ROOT / "examples" / "study" / "nearest.sps"
    done = subprocess.run(["pspp", "--batch", str(syntax)], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "full shot" in done.stdout or "long shot" in done.stdout
