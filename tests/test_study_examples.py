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


def _blocks(page: str) -> list[str]:
    """Return the R code of a page of the documentation."""
    return re.findall(r"```r\n(.*?)```", (ROOT / "docs" / page).read_text(), re.DOTALL)


def _in_r(code: str, where: Path) -> str:
    """Run R code in a folder and return what it prints."""
    (where / "code.R").write_text(code)
    done = subprocess.run(["Rscript", "code.R"], cwd=where, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed")
def test_the_study_of_the_documentation_runs(folder, tmp_path):
    lines = ["file,group"]
    for k in range(400):  # photos of two cameras of the same names
        path = tmp_path / f"camera {k % 2}" / f"{k // 2}.jpg"
        path.parent.mkdir(exist_ok=True)
        path.write_text(str(k))
        lines.append(f"{path},{'families' if k < 200 else 'meetings'}")
    (tmp_path / "archive.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "results").symlink_to(folder)
    printed = _in_r("\n".join(_blocks("study.md")) + "\nprint(table(without$group))\n", tmp_path)
    for group in ("families", "meetings"):
        copied = {path.read_text() for path in (tmp_path / "study" / group).iterdir()}
        assert len(copied) == 200
    assert "Wilcoxon" in printed and re.search(r"market\s*\n\s*2", printed)  # of park the focal length was assumed


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed")
def test_the_comparison_with_a_tape_runs(folder, tmp_path):
    (tmp_path / "results").symlink_to(folder)
    pairs = list(csv.DictReader((Path(folder) / "pairs.csv").read_text().splitlines()))
    rows = [
        (p["photo"], p["person_b"], p["person_a"], float(p["distance_m"] or 1) / 1.1)  # the higher number first
        for p in pairs
    ]
    (tmp_path / "tape.csv").write_text(
        "photo,person_a,person_b,tape_m\n" + "".join(f"{a},{b},{c},{d!r}\n" for a, b, c, d in rows)
    )
    printed = _in_r(_blocks("checking.md")[0], tmp_path)
    errors = [float(v) for v in re.findall(r"\[1\] (\S+)", printed)]
    assert errors[:2] == pytest.approx([0.1, 0.1], abs=1e-6) and 0 <= errors[2] <= 1


@pytest.mark.skipif(shutil.which("Rscript") is None, reason="R is not installed")
def test_r_reads_spss_files_as_it_reads_the_tables(folder, tmp_path):
    pytest.importorskip("pyreadstat")
    assert main(["export", folder, "--format", "spss,csv", "--out", str(tmp_path)]) == 0
    code = """
        if (!requireNamespace("haven", quietly = TRUE)) quit(status = 0)
        for (table in c("photos", "people", "pairs")) {
          csv <- read.csv(paste0(table, ".csv"), na.strings = "")
          sav <- haven::read_sav(paste0(table, ".sav"))
          stopifnot(names(csv) == names(sav), nrow(csv) == nrow(sav))
          for (name in names(csv)) {
            there <- is.na(csv[[name]]) | csv[[name]] == "uncertain"
            stopifnot(is.na(sav[[name]]) == there)
            if (is.numeric(csv[[name]])) stopifnot(all.equal(csv[[name]], as.numeric(sav[[name]])))
            if (is.character(csv[[name]]) && haven::is.labelled(sav[[name]])) {
              labels <- as.character(haven::as_factor(sav[[name]]))
              told <- c(true = "yes", false = "no")[csv[[name]]]
              stopifnot((ifelse(is.na(told), csv[[name]], told) == labels)[!there])
            }
          }
        }
        cat("compared\n")
    """
    if "compared" not in _in_r(code, tmp_path):
        pytest.skip("R has no package haven")


@pytest.mark.skipif(shutil.which("pspp") is None, reason="PSPP is not installed")
def test_the_spss_syntax_reads_the_tables(folder, tmp_path):
    pytest.importorskip("pyreadstat")
    assert main(["export", folder, "--format", "spss", "--out", str(tmp_path)]) == 0
    syntax = ROOT / "examples" / "study" / "nearest.sps"
    done = subprocess.run(["pspp", "--batch", str(syntax)], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "full shot" in done.stdout or "long shot" in done.stdout
    (tmp_path / "count.sps").write_text("GET FILE='photos.sav'.\nFREQUENCIES reason city.\n")
    done = subprocess.run(["pspp", "--batch", "count.sps"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert re.search(r"Missing +\| +6\|", done.stdout), done.stdout  # no photo has a city: blanks are no texts
