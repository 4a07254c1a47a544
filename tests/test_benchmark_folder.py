"""A results folder as predictions: what a spreadsheet or a script did to its tables is read, or refused in one line."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from proxemetry.benchmark import read_predictions
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.errors import LabelsError
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25
from proxemetry.settings import Settings
from proxemetry.tables import TABLES, rows

Row = dict[str, object]
Change = Callable[[list[Row]], list[Row]]


def _folder(tmp_path: Path, table: str = "", change: Change | None = None) -> Path:
    """Write the tables of three people, half a metre of torso each, one of the tables changed."""
    points = np.full((3, 25, 2), np.nan)
    for k, x in enumerate((100.0, 300.0, 500.0)):
        points[k, 1], points[k, 8] = (x, 150), (x, 250)
    people = People(BODY_25, points, np.isfinite(points[..., 0]).astype(float))
    camera = CameraEstimate(Camera.centred(700, 640, 480))
    scene = place("a.jpg", "", 640, 480, people, camera, Settings("torso"))
    for name, columns in TABLES.items():
        content = rows(name, scene)
        content = change(content) if change and name == table else content
        with (tmp_path / f"{name}.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, [c.name for c in columns])
            writer.writeheader()
            writer.writerows(content)
    return tmp_path


def _with(**values: object) -> Change:
    return lambda content: [{**row, **values} for row in content]


def test_numbers_that_a_script_wrote_as_3_0_are_whole(tmp_path: Path) -> None:
    plain = next(iter(read_predictions(_folder(tmp_path))))
    floats = _folder(tmp_path, "people", lambda content: [{**r, "person": f"{r['person']}.0"} for r in content])
    again = next(iter(read_predictions(floats)))
    np.testing.assert_array_equal(again.positions_mm, plain.positions_mm)
    np.testing.assert_array_equal(again.low_mm, plain.low_mm)
    assert np.isfinite(again.low_mm).sum() == 6


@pytest.mark.parametrize(
    ("table", "change", "said"),
    [
        ("people", _with(person="one"), r"people\.csv: photo a\.jpg: person is 'one' where a number"),
        ("people", _with(person=""), "person is '' where a whole number"),
        ("people", _with(person=1.5), r"person is '1\.5' where a whole number"),
        ("people", lambda content: content * 2, r"people\.csv: photo a\.jpg: a person is listed twice"),
        ("people", _with(photo="b.jpg"), r"people\.csv: photo b\.jpg is not in photos\.csv"),
        ("people", _with(x_m="-2,05"), "x_m is '-2,05' where a number"),
        ("pairs", _with(photo="b.jpg"), r"pairs\.csv: photo b\.jpg is not in photos\.csv"),
        ("pairs", _with(person_b=9), r"pairs\.csv: photo a\.jpg: person 9 is not in people\.csv"),
        ("pairs", _with(person_a=1, person_b=1), "pair 1-1 is not a pair"),
        ("pairs", lambda content: [*content, *content], "pair 0-1 is listed twice"),
        ("pairs", _with(distance_m=-1), "a length is negative"),
        ("pairs", _with(distance_m="inf"), "distance_m is 'inf'"),
        ("pairs", _with(low_m=3, high_m=2), "low_m above high_m"),
        ("photos", lambda content: content * 2, r"a\.jpg is answered twice"),
    ],
)
def test_tables_that_contradict_themselves_are_refused(tmp_path: Path, table: str, change: Change, said: str) -> None:
    with pytest.raises(LabelsError, match=said) as caught:
        read_predictions(_folder(tmp_path, table, change))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda text: text.replace(b",", b";"), "column photo is missing; commas are expected"),
        (lambda text: text.replace(b"a.jpg", b"\xe4.jpg"), "cannot be read as UTF-8 text"),
        (lambda _: b"", "column photo is missing"),
        (lambda text: text[: text.rindex(b"a.jpg") + 7], "row 3 ends early"),
    ],
)
def test_files_that_are_no_such_tables_are_refused(tmp_path: Path, spoil: Callable[[bytes], bytes], said: str) -> None:
    path = _folder(tmp_path) / "pairs.csv"
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(LabelsError, match=rf"pairs\.csv: {said}"):
        read_predictions(tmp_path)
