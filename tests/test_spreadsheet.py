"""Excel workbooks, CSV of other locales, and SPSS's levels of measurement: the same numbers as the plain tables."""

import csv
import io
import re
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest

from proxemetry.archive.figures.spreadsheet import Locale
from proxemetry.cli import main
from proxemetry.errors import SettingsError
from proxemetry.tables import all_columns
from synthetic.reviewing import make_results

SHEET = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_results(tmp_path_factory.mktemp("made")).folder.location


def plain(folder, table):
    with (Path(folder) / f"{table}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def sheets(path):
    """Return every sheet's rows as texts, formulas as they are."""
    with zipfile.ZipFile(path) as packed:
        names = re.findall(r'<sheet name="([^"]+)"', packed.read("xl/workbook.xml").decode())
        found = {}
        for number, name in enumerate(names, start=1):
            root = ElementTree.fromstring(packed.read(f"xl/worksheets/sheet{number}.xml"))
            found[name] = [
                {re.sub(r"\d", "", c.get("r")): "".join(c.itertext()) for c in row} for row in root.iter(f"{SHEET}row")
            ]
            assert not list(root.iter(f"{SHEET}f")), "a formula"
        return found


def test_a_workbook_has_every_table_and_the_codebook(folder, tmp_path):
    pytest.importorskip("xlsxwriter")
    assert main(["export", folder, "--format", "xlsx", "--out", str(tmp_path)]) == 0
    found = sheets(tmp_path / "results.xlsx")
    assert list(found) == ["photos", "people", "pairs", "codebook"]
    for table, columns in all_columns().items():
        header = list(found[table][0].values())
        assert header == [c.name for c in columns]
        rows = [dict(zip(found[table][0], header, strict=True)) for _ in (0,)]
        letters = {name: letter for letter, name in rows[0].items()}
        expected = plain(folder, table)
        assert len(found[table]) == 1 + len(expected)
        for got, want in zip(found[table][1:], expected, strict=True):
            for name in ("photo", "distance_m", "nearest_m", "focal_px"):
                if name in letters:
                    cell = got.get(letters[name], "")
                    assert cell == want[name] or float(cell) == pytest.approx(float(want[name]))
    assert len(found["codebook"]) > 80


def test_a_text_that_looks_like_a_formula_stays_a_text(tmp_path):
    pytest.importorskip("xlsxwriter")
    results = make_results(tmp_path / "made")
    from proxemetry.archive.review.corrections import FILE, Log

    scene = next(s for s in results.scenes() if s.photo == "market/two.jpg")
    log = Log(Path(results.folder.location) / FILE)
    log.append(scene, "note", {"text": "=HYPERLINK(1)"}, "ann")
    log.close()
    assert main(["export", results.folder.location, "--format", "xlsx", "--out", str(tmp_path)]) == 0
    texts = [text for row in sheets(tmp_path / "results.xlsx")["photos"] for text in row.values()]
    assert any("=HYPERLINK(1)" in text for text in texts)
    options = ["--format", "csv", "--locale", "fi", "--out", str(tmp_path / "fi")]
    assert main(["export", results.folder.location, *options]) == 0
    with (tmp_path / "fi" / "photos.csv").open(encoding="utf-8-sig", newline="") as file:
        notes = {row["note"] for row in csv.DictReader(file, delimiter=";")}
    assert notes == {"'=HYPERLINK(1)", ""}  # as in the plain tables
    assert {row["note"] for row in plain(results.folder.location, "photos")} <= notes


@pytest.mark.parametrize(
    ("name", "decimal", "separator"),
    [("fi", ",", ";"), ("de_AT", ",", ";"), ("en", ".", ","), ("de-CH", ".", ","), ("es_MX", ".", ",")],
)
def test_a_locale_has_its_decimals_and_its_separator(name, decimal, separator):
    locale = Locale.named(name)
    assert (locale.decimal, locale.separator) == (decimal, separator)


@pytest.mark.parametrize("name", ["", "finnish", "../fi", "de_A1"])
def test_what_is_no_locale_is_told(name):
    with pytest.raises(SettingsError, match="--locale"):
        Locale.named(name)


@pytest.mark.parametrize("name", ["fi", "en"])
def test_csv_of_a_locale_holds_the_numbers_of_the_plain_tables(folder, tmp_path, name):
    assert main(["export", folder, "--format", "csv", "--locale", name, "--out", str(tmp_path)]) == 0
    locale = Locale.named(name)
    for table in all_columns():
        content = (tmp_path / f"{table}.csv").read_bytes()
        assert content.startswith(b"\xef\xbb\xbf")
        rows = list(csv.DictReader(io.StringIO(content.decode("utf-8-sig")), delimiter=locale.separator))
        expected = plain(folder, table)
        assert len(rows) == len(expected)
        for got, want in zip(rows, expected, strict=True):
            for column in all_columns()[table]:
                a, b = got[column.name], want[column.name]
                if column.kind == "DOUBLE" and b:
                    assert float(a.replace(locale.decimal, ".")) == pytest.approx(float(b))
                    assert locale.decimal in a or "e" in a
                else:
                    assert a == b


def test_the_results_folder_keeps_its_own_csv(folder, capsys):
    assert main(["export", folder, "--format", "csv", "--locale", "fi"]) == 2
    assert "--out" in capsys.readouterr().err


def test_spss_knows_what_is_ordered_and_what_is_a_name(folder, tmp_path):
    pytest.importorskip("pandas")
    pyreadstat = pytest.importorskip("pyreadstat")
    assert main(["export", folder, "--format", "spss", "--out", str(tmp_path)]) == 0
    frame, meta = pyreadstat.read_sav(str(tmp_path / "pairs.sav"), user_missing=True)
    assert meta.variable_measure["zone"] == "ordinal" and meta.variable_measure["person_a"] == "nominal"
    assert meta.variable_value_labels["zone"] == {
        1: "intimate",
        2: "personal",
        3: "social",
        4: "public",
        9: "uncertain",
    }
    expected = [r["zone"] for r in plain(folder, "pairs")]
    assert [meta.variable_value_labels["zone"].get(v, "") for v in frame["zone"]] == expected
    without, _ = pyreadstat.read_sav(str(tmp_path / "pairs.sav"))
    assert without["zone"].isna().sum() == sum(zone in ("", "uncertain") for zone in expected)
    people, meta = pyreadstat.read_sav(str(tmp_path / "people.sav"))
    assert meta.variable_measure["shot_size"] == "ordinal" and meta.original_variable_types["person"] == "F8.0"
    assert people["shot_size"].dropna().between(1, 8).all()
    _, meta = pyreadstat.read_sav(str(tmp_path / "photos.sav"))
    assert meta.variable_value_labels["status"][1] == "ok"
    assert meta.variable_measure["n_people"] == "scale"
