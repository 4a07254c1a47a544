"""`proxemetry annotate` without and with its page, and the benchmark's commands on what it wrote."""

import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import httpx
import pytest

from proxemetry.annotate.actions import replayed
from proxemetry.annotate.label_files import label_files
from proxemetry.annotate.photos import OwnPhoto
from proxemetry.annotate.project import Project
from proxemetry.archive.review.actions import Action
from proxemetry.benchmark import read_labels
from proxemetry.cli import main
from proxemetry.people.skeleton import PARTS
from proxemetry.photo import Photo
from tests.test_annotate_project import POSE, annotated
from tests.test_annotate_project import photos as photos  # the fixture

ROOT = Path(__file__).parent.parent
KORTE = ROOT.parent / "shared" / "data" / "korte"


def command(photos: Path, *options: str) -> list[str]:
    return ["annotate", str(photos), "--out", str(photos.parent / "labels"), "--pose", POSE, *options]


@pytest.fixture
def done(photos: Path) -> Path:
    """Return the photos of a finished folder of annotations, lenses stated."""
    project = annotated(photos)
    project.act(0, "set_lens", {"scope": "all", "lens": {"focal_35mm": 31.2}})
    project.close()
    return photos


def test_a_check_lists_what_is_missing_and_then_nothing(photos: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command(photos, "--check")) == 1
    assert "body_pixel_locations.csv: empty" in capsys.readouterr().out
    annotated(photos).close()
    assert main(command(photos, "--check")) == 0
    told = capsys.readouterr()
    assert told.out.splitlines() == [f"{photos.parent / 'labels'}: no faults"] and told.err == ""
    project = Project([str(photos)], str(photos.parent / "labels"), pose=POSE)
    project.act(None, "set_tape", {"shoot": 0, "a": "P0", "b": "P1", "metres": 2.5})  # typed coordinates say 1.5
    project.close()
    assert main(command(photos, "--check")) == 0
    assert "shoot 0: The measurements contradict each other" in capsys.readouterr().err


def test_the_score_prints_both_protocols_and_keeps_what_it_scored(
    done: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    labels = done.parent / "labels"
    assert main(command(done, "--score", "--jobs", "0", "--method", "torso,combined")) == 0
    printed = capsys.readouterr().out
    assert "protocol v1" in printed and "protocol seker2021" in printed and "1.70 m for all" in printed
    # the benchmark's own commands take the folder
    assert main(["score", "--check", str(labels)]) == 0
    assert main(["score", str(labels / "run"), "--labels", str(labels), "--protocol", "seker2021"]) == 0
    assert main(["score", str(labels / "run" / "predictions_torso.json"), "--labels", str(labels)]) == 0
    capsys.readouterr()
    table = ["--camera-table", str(labels / "camera_table.csv")]
    again = ["benchmark", "--images", str(done), "--labels", str(labels), "--out", str(done.parent / "again"), *table]
    assert main([*again, "--method", "torso", "--pose", POSE, "--jobs", "0"]) == 0
    benchmarked = capsys.readouterr().out
    figure = re.search(r"pair error, mean over pairs +([\d.]+)", benchmarked)
    assert figure is not None and float(figure[1]) < 5  # the stated lens is the drawn camera's
    keypoints = ["benchmark", "--keypoints", "labels", "--labels", str(labels), "--method", "torso"]
    assert main(keypoints) == 0 and "3 of 3 pairs" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({1: "nowhere"}, "no such file or folder"),
        ({"--pose": "nonesuch"}, "pose back end 'nonesuch' is unknown"),
        ({"--pose": "recorded:nowhere.json"}, "nowhere.json"),
        ({"--who": " "}, "--who is empty"),
        ({"--out": "{photos}/a.jpg"}, "a.jpg"),
        ({"--out": "s3://bucket/x"}, "a folder on this machine"),
        ({"--score": "", "--method": "guess"}, "method 'guess' is unknown"),
        ({"--score": ""}, "nobody is annotated"),
    ],
)
def test_what_cannot_be_done_is_one_line(
    photos: Path, capsys: pytest.CaptureFixture[str], change: dict, told: str
) -> None:
    arguments = command(photos, "--jobs", "0")
    for name, value in change.items():
        value = value.replace("{photos}", str(photos))
        if isinstance(name, int):
            arguments[name] = value
        elif name in arguments:
            arguments[arguments.index(name) + 1] = value
        else:
            arguments += [name, *([value] if value else [])]
    assert main([*arguments, *([] if "--score" in change else ["--check"])]) == 2
    error = capsys.readouterr().err
    assert told in error and len(error.splitlines()) == 1 and "Traceback" not in error


def test_the_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["annotate", "--help"])
    text = capsys.readouterr().out
    for taught in ("eyes", "tape", "ground_truth_locations.csv", "--check", "proxemetry score", "Nothing leaves"):
        assert taught in text


def test_a_page_killed_in_the_middle_goes_on(photos: Path) -> None:
    pytest.importorskip("uvicorn")

    def started() -> tuple[subprocess.Popen[str], httpx.Client]:
        environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}"}
        process = subprocess.Popen(
            [sys.executable, "-m", "proxemetry", *command(photos, "--no-browser")], stdout=subprocess.PIPE, text=True,
            env=environment,
        )  # fmt: skip
        assert process.stdout is not None
        address = process.stdout.readline().split("annotation page: ")[1].strip()
        origin = address.partition("/?")[0]
        asking = httpx.Client(base_url=origin, headers={"Origin": origin}, timeout=60)
        asking.get(address, follow_redirects=True).raise_for_status()
        return process, asking

    process, asking = started()
    asking.post("/api/photos/0/propose").raise_for_status()
    body = {"photo": 0, "action": "name_person", "value": {"person": 0, "tag": "P2"}}
    asking.post("/api/actions", json=body).raise_for_status()
    process.send_signal(signal.SIGKILL)
    process.wait()
    process, asking = started()
    assert [p["tag"] for p in asking.get("/api/photos/0").json()["people"]] == ["P2", None]
    assert asking.get("/api/about").json()["undo"] == "named P2 in a.jpg"
    process.send_signal(signal.SIGINT)
    assert process.wait(30) in (0, 130)
    assert "P2,Eyes" in (photos.parent / "labels" / "body_pixel_locations.csv").read_text()


def test_recorded_keypoints_propose_too(photos: Path) -> None:
    import json

    joints = [[100 + 7 * k % 60, 90 + 11 * k, 0.9] for k in range(17)]
    image = {"filename": "a.jpg", "width": 900, "height": 600, "people": [{"keypoints": joints}]}
    recorded = photos.parent / "keypoints.json"
    recorded.write_text(json.dumps({"skeleton": "coco17", "images": [image]}))
    project = Project([str(photos)], str(photos.parent / "labels"), pose=f"recorded:{recorded}")
    project.propose(0)
    (person,) = project.notes(0).people
    assert person.points["Shoulder"] == ((100 + 35 % 60 + 100 + 42 % 60) // 2, 90 + 11 * 11 // 2)


@pytest.mark.skipif(not KORTE.exists(), reason="the labels of the KORTE benchmark are not here")
def test_kortes_own_labels_are_written_as_they_are_read(tmp_path: Path) -> None:
    """All 96 photos as annotations: the files written from them read back as the authors' own."""
    labels = read_labels(KORTE)
    photos: list[OwnPhoto] = []
    entries: list[tuple[str, str, dict]] = []
    for k, image in enumerate(labels):
        sha256 = f"{k:064x}"
        photos.append(OwnPhoto(Photo(image.filename, image.width, image.height, sha256), image.filename, "/nowhere"))
        entries.append(
            (sha256, "place_photos", {"photos": [sha256], "shoot": int(image.shoot), "camera": image.camera})
        )
        for key, (tag, parts) in enumerate(zip(image.tags, image.parts_px, strict=True)):
            points = {p: [int(v) for v in at] for p, at in zip(PARTS, parts, strict=True) if at[0] == at[0]}
            entries.append((sha256, "add_person", {"person": key, "points": points}))
            entries.append((sha256, "name_person", {"person": key, "tag": tag}))
    for shoot, places in {image.shoot: image.places_mm for image in labels}.items():
        for tag, (x, _, z) in places.items():
            entries.append(("", "set_spot", {"shoot": int(shoot), "tag": tag, "at": [x / 1000, z / 1000]}))
    now, lost = replayed([Action(n, "", "", "", sha, a, v) for n, (sha, a, v) in enumerate(entries)])
    assert not lost
    files = [photo.sha256 for photo in photos]
    for name, content in label_files(now, photos, {n: now.places(n, files) for n in (0, 1)}).items():
        if content is not None:
            (tmp_path / name).write_bytes(content)
    again = read_labels(tmp_path)
    assert len(again) == 96
    for image in labels:
        other = again.by_name[image.filename]
        order = [other.tags.index(tag) for tag in image.tags]
        assert sorted(other.tags) == sorted(image.tags) and (other.shoot, other.camera) == (image.shoot, image.camera)
        assert repr(other.parts_px[order].tolist()) == repr(image.parts_px.tolist())
        assert abs(other.positions_mm[order] - image.positions_mm).max() <= 1
