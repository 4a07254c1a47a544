"""Results for other programs: what was written is read back by those programs' own libraries."""

import csv
import json
from pathlib import Path

import pytest

from proxemetry.archive.figures import export
from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store.results import Results
from proxemetry.cli import main
from proxemetry.clip.columns import codebook_page
from proxemetry.scene import Scene
from proxemetry.tables import TABLES, all_columns, rows, safe_distance_columns
from synthetic.small_photos import write_photos


@pytest.fixture
def results(tmp_path):
    photos = write_photos(tmp_path / "photos", 3)
    (photos / "text.jpg").write_text("not a photo")
    run(
        [str(photos)],
        Job(str(tmp_path / "out"), "python:synthetic.small_photos:two_people"),
        jobs=0,
        safe_distance_m=2.0,
    )
    return Results.open(tmp_path / "out")


def table(results, name):
    with (Path(results.folder.location) / f"{name}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_spss_files_have_labels_and_the_same_numbers(results, capsys):
    pyreadstat = pytest.importorskip("pyreadstat")
    pytest.importorskip("pandas")
    assert main(["export", results.folder.location, "--format", "spss"]) == 0
    for name, columns in all_columns().items():
        frame, meta = pyreadstat.read_sav(f"{results.folder.location}/{name}.sav")
        assert list(frame.columns) == [c.name for c in columns]
        assert meta.column_names_to_labels["photo"] == columns[0].meaning
        assert len(frame) == len(table(results, name))
    frame, meta = pyreadstat.read_sav(f"{results.folder.location}/pairs.sav")
    assert meta.column_names_to_labels["distance_m"].endswith("[m]")
    assert frame["distance_m"].tolist() == pytest.approx([float(r["distance_m"]) for r in table(results, "pairs")])
    assert set(frame["on_ground"]) <= {0.0, 1.0}


def test_long_tables_come_in_several_spss_files_that_join(tmp_path, monkeypatch, capsys):
    pyreadstat = pytest.importorskip("pyreadstat")
    pandas = pytest.importorskip("pandas")
    photos, out = write_photos(tmp_path / "photos", 2), tmp_path / "out"
    run([str(photos)], Job(str(out), "python:synthetic.small_photos:a_crowd"), jobs=0)
    assert main(["export", str(out), "--format", "spss"]) == 0
    (whole, _), before = pyreadstat.read_sav(out / "pairs.sav"), (out / "pairs.sav").read_bytes()
    monkeypatch.setattr(export, "_VECTORS_A_FILE", 1)
    assert main(["export", str(out), "--format", "spss"]) == 0
    assert not (out / "pairs.sav").exists()
    assert (out / "photos.sav").exists()
    read = [pyreadstat.read_sav(out / f"pairs_{k}.sav") for k in (1, 2, 3)]
    pandas.testing.assert_frame_equal(pandas.concat([frame for frame, _ in read], ignore_index=True), whole)
    assert len({tuple(meta.variable_storage_width.values()) for _, meta in read}) == 1
    assert "/FILE='pairs_3.sav'" in (out / "pairs.sps").read_text()
    assert "pairs_1.sav" in capsys.readouterr().out
    monkeypatch.undo()
    assert main(["export", str(out), "--format", "spss"]) == 0
    assert sorted(p.name for p in out.glob("pairs*.s*")) == ["pairs.sav"]
    assert len((out / "pairs.sav").read_bytes()) == len(before)


def test_coco_keypoints_are_those_of_the_scenes(results, tmp_path, capsys):
    assert main(["export", results.folder.location, "--format", "coco", "--out", str(tmp_path / "other")]) == 0
    coco = json.loads((tmp_path / "other" / "coco_keypoints.json").read_text())
    assert [i["file_name"] for i in coco["images"]] == [f"00/photo_0000{k}.jpg" for k in range(3)]
    assert coco["categories"][0]["keypoints"][5] == "left_shoulder"
    assert len(coco["annotations"]) == 6
    scene = next(results.scenes())
    first = coco["annotations"][0]
    assert first["keypoints"][15:17] == pytest.approx(scene.people.joint("left_shoulder")[0], abs=0.01)
    assert first["keypoints"][:3] == [0, 0, 0]  # the nose was not seen
    assert first["num_keypoints"] == 6


def test_the_codebook_page_is_that_of_the_tables(capsys):
    assert main(["export", "--codebook"]) == 0
    assert capsys.readouterr().out == codebook_page()
    page = Path(__file__).parents[1] / "docs" / "codebook.md"
    assert page.read_text() == codebook_page(), "make it anew: proxemetry export --codebook > docs/codebook.md"


def test_every_column_has_a_unit_where_its_name_has_one():
    units = {"_px": "px", "_m": "m", "_deg": "deg"}
    for columns in all_columns().values():
        for column in columns:
            for ending, unit in units.items():
                if column.name.endswith(ending):
                    assert column.unit == unit, column.name
            assert column.meaning


def test_the_safe_distance_is_counted_the_same_everywhere(results):
    limit = 2.0
    for row, scene in zip(table(results, "photos"), results.scenes(), strict=True):
        expected = {c.name: c.value(scene) for c in safe_distance_columns(limit)}
        assert float(row["safe_distance_m"]) == expected["safe_distance_m"]
        counted = expected["n_below_safe"]
        assert row["n_below_safe"] == ("" if counted is None else str(counted))


def test_tables_are_the_rows_of_the_scenes(results):
    for name, columns in TABLES.items():
        expected = [row for scene in results.scenes() for row in rows(name, scene)]
        found = table(results, name)
        assert len(found) == len(expected)
        for row, values in zip(found, expected, strict=True):
            for column in columns:
                value = values[column.name]
                if column.name != "seconds" and not isinstance(value, (float, bool)):
                    assert row[column.name] == ("" if value is None else str(value))


def test_corrections_are_in_the_tables_after_every_rerun(results, tmp_path):
    scene = next(results.scenes())
    log = Log(Path(results.folder.location) / FILE)
    log.append(scene, "set_camera", {"focal_px": 100.0}, "ann")
    log.close()
    job = Job(results.folder.location, "python:synthetic.small_photos:two_people")
    before = table(results, "pairs")
    run([str(tmp_path / "photos")], job, jobs=0)
    after = table(results, "pairs")
    assert float(after[0]["distance_m"]) != float(before[0]["distance_m"])
    assert after[1:] == before[1:]
    assert table(results, "photos")[0]["corrections"] == "1"
    run([str(tmp_path / "photos")], job, jobs=0, restart=True)
    assert table(results, "pairs") == after
    assert isinstance(next(results.scenes(corrected=False)), Scene)
