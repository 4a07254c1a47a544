"""Answers with a mistake in all of them: a score that is not the method's says so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from proxemetry.benchmark import Score, read_predictions, score
from proxemetry.cli import main
from proxemetry.errors import LabelsError
from proxemetry.files import csv_lines, read_json, read_text
from tests.test_benchmark_v1 import answers, person, photo, triangle


def _scored(folder: Path, *images: dict[str, Any]) -> Score:
    return score(triangle(folder), answers(folder, *images))


def _said(folder: Path, capsys: pytest.CaptureFixture[str], *images: dict[str, Any]) -> str:
    triangle(folder)
    answers(folder, *images)
    capsys.readouterr()
    assert main(["score", str(folder / "answers.json"), "--labels", str(folder)]) == 0
    return capsys.readouterr().err


def _in_units(factor: float) -> list[dict[str, Any]]:
    people = [person(k) for k in range(3)]
    return [{**p, "position_mm": [v * factor for v in p["position_mm"]]} for p in people]


@pytest.mark.parametrize(("factor", "told"), [(1.0, ""), (0.4, ""), (0.1, "0.1 of the true"), (0.001, "0.001 of the")])
def test_centimetres_and_metres_are_told_from_a_poor_method(factor, told, tmp_path, capsys):
    said = _said(tmp_path, capsys, photo(_in_units(factor)))
    assert told in said and bool(said) == bool(told)


def test_swapped_sides_are_told_and_a_resized_picture_is_none(tmp_path, capsys):
    people = [person(k) for k in range(3)]
    label = next(iter(triangle(tmp_path)))
    width, height = label.width, label.height
    assert "another shape" in _said(tmp_path, capsys, photo(people, width=height, height=width))
    for scale in (1.0, 0.5, 0.3333):
        size = {"width": round(width * scale), "height": round(height * scale)}
        assert _scored(tmp_path, photo(people, **size)).n_misshapen == 0
    assert not _said(tmp_path, capsys, photo(people, width=width, height=height))


def test_points_of_a_larger_picture_than_is_stated_are_told(tmp_path, capsys):
    people = [person(k) for k in range(3)]
    label = next(iter(triangle(tmp_path)))
    quarter = {"width": label.width // 4, "height": label.height // 4}
    assert "most points of 1 predictions lie outside" in _said(tmp_path, capsys, photo(people, **quarter))
    assert _scored(tmp_path, photo(people)).n_outside == 0  # of the photo's own size
    assert _scored(tmp_path, photo([])).n_outside == 0


def test_a_labelled_photo_without_an_answer_is_counted(tmp_path):
    people = [person(k) for k in range(3)]
    one = _scored(tmp_path, photo(people))
    assert one.n_unanswered == 1 and ", 1 photo without an answer" in one.caption
    both = _scored(tmp_path, photo(people), photo([], "b.jpg"))  # that nobody is there is an answer
    assert both.n_unanswered == 0 and "without an answer" not in both.caption


def test_a_table_of_a_results_folder_names_the_folder(tmp_path):
    (tmp_path / "pairs.csv").write_text("photo,person_a,person_b,distance_m\na.jpg,0,1,1.5\n")
    with pytest.raises(LabelsError, match=r"and no table$"):
        read_predictions(tmp_path / "pairs.csv")
    (tmp_path / "photos.csv").write_text("photo\na.jpg\n")
    with pytest.raises(LabelsError, match="the results folder is"):
        read_predictions(tmp_path / "pairs.csv")


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_what_windows_redirects_into_a_file_is_read(encoding, tmp_path):
    """PowerShell's > writes UTF-16 with a mark."""
    file = tmp_path / "answers.json"
    file.write_text(json.dumps({"name": "Grüße"}, ensure_ascii=False), encoding=encoding)
    assert read_json(file) == {"name": "Grüße"} and read_text(file)[0] == "{"


@pytest.mark.parametrize("sign", ["\x0b", "\x0c", "\x1c", "\x85", "\u2028", "\u2029"])
def test_a_sign_that_only_looks_like_a_line_end_stays_in_its_cell(sign, tmp_path):
    """Captions of layout programs hold them, and neither our tables nor a spreadsheet quote them."""
    assert csv_lines(f"a{sign}b,c\r\nd\ne") == [f"a{sign}b,c\r\n", "d\n", "e"]
    columns = "photo,width_px,height_px,caption"
    (tmp_path / "photos.csv").write_text(f"{columns}\na.jpg,640,480,one{sign}two\n", encoding="utf-8")
    parts = ",".join(f"{p}_{axis}_px" for p in ("eyes", "shoulder", "torso", "head") for axis in "uv")
    (tmp_path / "people.csv").write_text(f"photo,person,x_m,y_m,z_m,{parts}\n")
    (tmp_path / "pairs.csv").write_text("photo,person_a,person_b,distance_m,low_m,high_m\n")
    assert [image.filename for image in read_predictions(tmp_path)] == ["a.jpg"]
