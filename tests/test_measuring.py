"""A folder measured from the page: states, stopping, refusals."""

import threading
import time
from pathlib import Path

import pytest

from proxemetry.archive.run.schedule import Note, Progress
from proxemetry.errors import OutputError, SettingsError
from proxemetry.web.measuring import Measuring, folders


def finished(measuring):
    for _ in range(500):
        if (state := measuring.state())["status"] != "running":
            return state
        time.sleep(0.01)
    raise AssertionError("still running")


def test_folders_are_listed_with_their_photos(tmp_path):
    (tmp_path / "a" / "deep").mkdir(parents=True)
    (tmp_path / ".hidden").mkdir()
    for name in ("1.jpg", "2.PNG", "notes.txt"):
        (tmp_path / name).write_text("x")
    found = folders(str(tmp_path))
    assert found["folders"] == ["a"] and found["photos"] == 2
    assert found["parent"] == str(tmp_path.parent) and found["results"].startswith(str(tmp_path))
    with pytest.raises(SettingsError, match="cannot be listed"):
        folders(str(tmp_path / "none"))


def test_a_run_goes_from_running_to_done(tmp_path):
    def run(paths, job, on_progress):
        on_progress(Note("fetching"))
        on_progress(Progress(2, 4, 1))

    measuring = Measuring(run)
    assert measuring.state() == {"status": "idle"}
    measuring.start(str(tmp_path), str(tmp_path / "out"), 35.0)
    state = finished(measuring)
    assert (state["status"], state["done"], state["total"], state["failed"]) == ("done", 2, 4, 1)
    assert state["note"] == "fetching" and state["seconds_left"] >= 0


def test_a_run_is_stopped_and_only_one_runs_at_a_time(tmp_path):
    begun = threading.Event()

    def run(paths, job, on_progress):
        while True:
            begun.set()
            on_progress(Progress(1, 10, 0))
            time.sleep(0.01)

    measuring = Measuring(run)
    measuring.start(str(tmp_path), str(tmp_path / "out"))
    begun.wait(5)
    with pytest.raises(SettingsError, match="already"):
        measuring.start(str(tmp_path), str(tmp_path / "out"))
    measuring.stop()
    assert finished(measuring)["status"] == "stopped"


@pytest.mark.parametrize(
    ("error", "told"), [(OutputError("no space"), "no space"), (ValueError("oops"), "internal error")]
)
def test_what_goes_wrong_is_told(tmp_path, error, told):
    def run(paths, job, on_progress):
        raise error

    measuring = Measuring(run)
    measuring.start(str(tmp_path), str(tmp_path / "out"))
    state = finished(measuring)
    assert state["status"] == "failed" and told in state["error"]


def test_what_cannot_be_measured_is_refused_at_once(tmp_path):
    with pytest.raises(SettingsError, match="no such folder"):
        Measuring().start(str(tmp_path / "none"), "out")
    with pytest.raises(SettingsError, match="results"):
        Measuring().start(str(tmp_path), "  ")
    with pytest.raises(SettingsError):
        Measuring().start(str(tmp_path), "out", -5.0)


def test_the_folder_that_the_program_was_started_in_comes_first_where_photos_lie_in_it(tmp_path, monkeypatch):
    home, photos = tmp_path / "home", tmp_path / "photos"
    for folder in (home, photos):
        folder.mkdir()
    monkeypatch.setattr(Path, "home", lambda: home)
    monkeypatch.chdir(photos)
    assert folders("")["path"] == str(home.resolve())
    (photos / "A.JPG").touch()
    assert folders("")["path"] == str(photos.resolve())
    assert folders(str(home))["path"] == str(home.resolve())
