"""Archives over weeks: photos replaced under their name, renamed, deleted, touched, on another disk."""

from __future__ import annotations

import csv
import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from proxemetry.archive.figures import overlays
from proxemetry.archive.review.corrections import FILE, Log
from proxemetry.archive.run import manifest_update
from proxemetry.archive.run.run import run
from proxemetry.archive.run.schedule import Note
from proxemetry.archive.run.work import Job
from proxemetry.archive.store import manifest, parts
from proxemetry.archive.store.file_state import FileState
from proxemetry.archive.store.folder import Folder, overlay_name
from proxemetry.archive.store.results import Results
from proxemetry.camera.focal import FocalRequest
from proxemetry.camera.table import CameraTable
from proxemetry.cli import main
from proxemetry.errors import OutputError
from proxemetry.settings import Settings
from synthetic import small_photos
from synthetic.manifests import listed_photos
from synthetic.small_photos import write_photo, write_photos


def job(out):
    return Job(str(out), "python:synthetic.small_photos:counted")


def rows(out, name="photos"):
    with (Path(out) / f"{name}.csv").open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def go_on(photos, out, **options):
    """Run again; return how often a photo was measured, what was told, and the outcome."""
    steps, before = [], small_photos.COUNT["calls"]
    outcome = run([str(photos)], job(out), jobs=0, on_progress=steps.append, **options)
    notes = [step.text for step in steps if isinstance(step, Note)]
    return small_photos.COUNT["calls"] - before, notes, outcome


@pytest.fixture(autouse=True)
def counting(monkeypatch):
    monkeypatch.setitem(small_photos.COUNT, "calls", 0)


@pytest.fixture
def measured(tmp_path, monkeypatch):
    """Return photos and the results folder of a run over them: five photos in two shards."""
    monkeypatch.setattr(manifest_update, "SHARDS_OF_A_SMALL_RUN", 2)
    photos, out = write_photos(tmp_path / "photos", 5), tmp_path / "out"
    run([str(photos)], job(out), jobs=0)
    return photos, out


def test_a_replaced_photo_is_measured_again_and_nothing_else_is(measured):
    photos, out = measured
    before = {r["photo"]: r for r in rows(out)}
    Folder(out).write(overlay_name("00/photo_00003.jpg"), b"a drawing")
    Folder(out).write(overlay_name("00/photo_00002.jpg"), b"a drawing")
    write_photo(photos / "00" / "photo_00003.jpg", 999)
    times, notes, outcome = go_on(photos, out)
    assert times == outcome.measured.again == 1
    assert any("1 photo had been replaced" in note for note in notes)
    after = {r["photo"]: r for r in rows(out)}
    assert [p for p in after if after[p] != before[p]] == ["00/photo_00003.jpg"]
    assert after.keys() == before.keys()
    assert not (out / overlay_name("00/photo_00003.jpg")).exists()
    assert (out / overlay_name("00/photo_00002.jpg")).exists()
    times, notes, outcome = go_on(photos, out)
    assert times == outcome.measured.photos == 0
    assert not any("replaced" in note for note in notes)


def test_tables_after_a_replacement_are_those_of_a_new_run(measured, tmp_path):
    photos, out = measured
    write_photo(photos / "00" / "photo_00003.jpg", 999)
    go_on(photos, out)
    run([str(photos)], job(tmp_path / "anew"), jobs=0)
    assert (tmp_path / "anew" / "pairs.csv").read_bytes() == (out / "pairs.csv").read_bytes()
    assert (tmp_path / "anew" / "people.csv").read_bytes() == (out / "people.csv").read_bytes()


def test_the_same_picture_with_another_date_is_only_looked_at(measured):
    photos, out = measured
    path = photos / "00" / "photo_00003.jpg"
    before = (out / "photos.csv").read_bytes()
    os.utime(path, ns=(1, 1))
    times, notes, outcome = go_on(photos, out)
    assert (times, outcome.measured.again) == (0, 0)
    assert any("another size or date" in note for note in notes)
    assert (out / "photos.csv").read_bytes() == before
    assert not any("another size or date" in note for note in go_on(photos, out)[1])


def test_a_photo_that_could_not_be_read_is_tried_again_when_it_can(tmp_path):
    photos, out = write_photos(tmp_path / "photos", 2), tmp_path / "out"
    (photos / "late.jpg").write_bytes(b"still being copied")
    run([str(photos)], job(out), jobs=0)
    assert [r["status"] for r in rows(out)] == ["ok", "ok", "failed"]
    write_photo(photos / "late.jpg", 7)
    assert go_on(photos, out)[0] == 1
    assert [r["status"] for r in rows(out)] == ["ok", "ok", "ok"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes on this system")
def test_what_could_never_be_read_is_neither_changed_nor_gone(tmp_path):
    photos, out = write_photos(tmp_path / "photos", 2), tmp_path / "out"
    os.mkfifo(photos / "00" / "a.jpg")
    (photos / "00" / "b.jpg").symlink_to(tmp_path / "nowhere")
    run([str(photos)], job(out), jobs=0)
    assert not any("another size" in note or "any more" in note for note in go_on(photos, out)[1])
    (photos / "00" / "a.jpg").unlink()
    (photos / "00" / "photo_00001.jpg").unlink()
    (told,) = [note for note in go_on(photos, out)[1] if "any more" in note]
    assert "1 photo that was measured is not there any more (00/photo_00001.jpg)" in told


def test_what_is_gone_keeps_its_rows_and_is_told(measured):
    photos, out = measured
    (photos / "00" / "photo_00003.jpg").rename(photos / "renamed.jpg")
    times, notes, _ = go_on(photos, out)
    assert times == 0  # a copy of what was measured
    assert any("1 photo that was measured is not there any more (00/photo_00003.jpg)" in note for note in notes)
    assert len(rows(out)) == 6


def test_a_share_of_the_work_looks_at_its_own_photos(measured):
    photos, out = measured
    for number in range(4):
        write_photo(photos / "00" / f"photo_{number:05d}.jpg", 1000 + number)
    first = go_on(photos, out, shard=(1, 2))[0]
    second = go_on(photos, out, shard=(2, 2))[0]
    assert first and second
    assert first + second == 4
    assert len({r["sha256"] for r in rows(out)}) == 5


def test_corrections_stay_with_the_file_they_were_made_on(measured):
    photos, out = measured
    scene = next(Results.open(out).scenes(["00/photo_00003.jpg"]))
    log = Log(out / FILE)
    log.append(scene, "exclude", {"excluded": True}, "ada")
    log.close()
    go_on(photos, out)
    assert rows(out)[3]["status"] == "excluded"
    write_photo(photos / "00" / "photo_00003.jpg", 999)
    _, notes, _ = go_on(photos, out)
    assert rows(out)[3]["status"] == "ok"
    assert any("1 corrected photo is another file now or gone (00/photo_00003.jpg)" in note for note in notes)


def test_a_drawing_never_shows_another_file_than_was_measured(measured, monkeypatch):
    pytest.importorskip("matplotlib")
    photos, out = measured
    write_photo(photos / "00" / "photo_00003.jpg", 999)
    drawn = []
    monkeypatch.setattr("proxemetry.plots.overlay", lambda scene, photo, faces="": drawn.append((scene.photo, photo)))
    monkeypatch.setattr("proxemetry.plots.save", lambda figure, path: None)
    overlays.draw(Results.open(out), faces="blur")
    shown = dict(drawn)
    assert shown.pop("00/photo_00003.jpg") is None  # its heads would be elsewhere
    assert None not in shown.values()


def test_an_archive_mounted_elsewhere_is_known_although_a_photo_is_gone(measured, tmp_path):
    photos, out = measured
    (photos / "00" / "photo_00000.jpg").unlink()
    write_photo(photos / "00" / "photo_00001.jpg", 999)
    shutil.move(photos, tmp_path / "elsewhere")
    times, notes, outcome = go_on(tmp_path / "elsewhere", out)
    assert (times, outcome.photos) == (1, 5)
    assert any("not there any more" in note for note in notes)
    # From now on it is the home of what is added.
    write_photo(tmp_path / "elsewhere" / "new" / "one.jpg", 1000)
    assert go_on(tmp_path / "elsewhere" / "new", out)[0] == 1
    assert rows(out)[-1]["photo"] == "new/one.jpg"
    assert go_on(tmp_path / "elsewhere", out)[0] == 0


def test_whatever_ended_it_a_replaced_photo_is_measured_once(measured, monkeypatch):
    photos, out = measured
    write_photo(photos / "00" / "photo_00003.jpg", 999)

    def ended(*_):
        raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(parts, "write", ended)
        with pytest.raises(KeyboardInterrupt):
            run([str(photos)], job(out), jobs=0)
    assert go_on(photos, out)[0] == 1
    assert len(rows(out)) == 5


def test_a_row_that_is_kept_is_kept_to_the_last_digit(measured):
    _, out = measured
    folder = Folder(out)
    known = manifest.read(folder)
    assert known is not None
    before = parts.previous_rows(folder, 0)
    parts.write(folder, 0, [row.record(FileState(5, 6)) for row in before.values()], {"proxemetry_version": "test"})
    after = parts.previous_rows(folder, 0)
    assert [r.file for r in after.values()] == [FileState(5, 6)] * len(before)
    same = [{**r.fields, "file_bytes": 0, "file_modified_ns": 0} for r in before.values()]
    assert [{**r.fields, "file_bytes": 0, "file_modified_ns": 0} for r in after.values()] == same
    assert listed_photos(folder, sorted(known.names())).n_shards == known.n_shards


def test_a_file_that_is_not_there_has_no_state(tmp_path):
    assert FileState.of(str(tmp_path / "nothing.jpg")) is None
    assert FileState.of(None) is None
    path = write_photo(tmp_path / "one.jpg", 1)
    assert FileState.of(str(path)) == FileState(path.stat().st_size, path.stat().st_mtime_ns)


@pytest.mark.parametrize("ending", [".jpg", ".tif"])
def test_a_photo_may_be_called_as_long_as_a_disk_allows(tmp_path, ending):
    pytest.importorskip("matplotlib")
    photos, out = tmp_path / "photos", tmp_path / "out"
    name = "\u00fc" * ((255 - len(ending)) // 2) + ending
    write_photo(photos / name, 1)
    run([str(photos)], job(out), jobs=0)
    overlays.draw(Results.open(out))
    assert rows(out)[0]["photo"] == name
    assert [p.name for p in (out / "overlays").iterdir()] == [Path(overlay_name(name)).name]


def test_a_camera_table_that_was_edited_is_told_so(measured, tmp_path):
    photos, _ = measured
    path = tmp_path / "cameras.csv"

    def with_table(text):
        path.write_text(text)
        table = Settings(focal=FocalRequest(camera_table=CameraTable.read(path)))
        run([str(photos)], replace(job(tmp_path / "other"), settings=table), jobs=0)

    with_table("photo,focal_px\n*,100\n")
    with pytest.raises(OutputError, match=r"--camera-table cameras[.]csv has another content now"):
        with_table("photo,focal_px\n*,200\n")


@pytest.fixture
def drawings(monkeypatch):
    """Return what is drawn, as (photo, faces, people), without drawing."""
    pytest.importorskip("matplotlib")
    drawn = []

    def overlay(scene, photo, faces="show"):
        drawn.append((scene.photo, faces, len(scene)))
        return faces

    monkeypatch.setattr("proxemetry.plots.overlay", overlay)
    monkeypatch.setattr("proxemetry.plots.save", lambda figure, path: path.write_text(figure))
    return drawn


def test_drawings_with_open_faces_do_not_stay_where_blurred_ones_are_asked_for(measured, drawings):
    _, out = measured
    results = Results.open(out)
    overlays.draw(results)
    overlays.draw(results)
    assert len(drawings) == 5  # once
    overlays.draw(results, faces="blur")
    assert {p.read_text() for p in (out / "overlays").rglob("*.jpg")} == {"blur"}
    assert len(drawings) == 10


def test_a_drawing_follows_corrections_and_their_taking_back(measured, drawings):
    _, out = measured
    results = Results.open(out)
    overlays.draw(results)
    drawings.clear()
    scene = next(results.scenes())
    log = Log(out / FILE)
    log.append(scene, "remove_person", {"box": scene.people.boxes_px[0].tolist()}, "ada")
    overlays.draw(results)
    log.undo(scene, "ada")
    overlays.draw(results)
    assert drawings == [(scene.photo, "show", 1), (scene.photo, "show", 2)]
    log.append(scene, "exclude", {"excluded": True}, "ada")
    log.close()
    overlays.draw(results)
    assert not (out / overlay_name(scene.photo)).exists()


@pytest.mark.parametrize(
    ("file", "advice"),
    [("manifest/manifest-000.parquet", "--restart"), ("photos.parquet", "export DIR")],
)
def test_a_damaged_file_is_one_line_that_says_what_to_do(measured, capsys, file, advice):
    _, out = measured
    (out / file).write_bytes((out / file).read_bytes()[:-20])
    command = "summary" if file == "photos.parquet" else "report"
    assert main([command, str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert str(out / file) in line and "damaged" in line and advice in line


def test_a_run_does_not_go_on_with_a_damaged_part(measured):
    photos, out = measured
    part = out / "scenes" / "part-000001.parquet"
    part.write_bytes(part.read_bytes()[:-20])
    with pytest.raises(OutputError, match=r"part-000001.parquet: damaged.*delete it"):
        go_on(photos, out)


def test_a_part_that_was_damaged_and_deleted_is_measured_again(measured):
    photos, out = measured
    before = (out / "pairs.csv").read_bytes()
    (out / "scenes" / "part-000001.parquet").unlink()
    assert go_on(photos, out)[0] == 2
    assert (out / "pairs.csv").read_bytes() == before


def test_photos_of_another_folder_in_the_same_results_are_told(measured, tmp_path):
    """`--out` has a default: two archives measured one after the other would become one without a word."""
    photos, out = measured
    other = write_photos(tmp_path / "other", 1)
    _, notes, _ = go_on(other, out)
    (told,) = [note for note in notes if "same tables" in note]
    assert str(photos) in told and str(other) in told
    for again in (photos, photos / "00"):
        assert not any("same tables" in note for note in go_on(again, out)[1])
    assert len(rows(out)) == 6
