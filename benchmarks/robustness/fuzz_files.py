"""The kinds of file that the fuzzer damages: the whole one that it starts from, and how each is handed in."""

from __future__ import annotations

import copy
import io
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks.robustness.fuzz_annotations import annotations
from benchmarks.robustness.fuzz_damage import Rng, broken_bytes, broken_json, broken_text, mutated, pick
from benchmarks.robustness.fuzz_fixed_camera import calibration, clip, detections, region
from benchmarks.robustness.fuzz_recordings import HEIGHT, WIDTH, HandIn, recorded_whole, recording
from proxemetry.archive.review.corrections import FILE, Action, Log, corrected_scenes
from proxemetry.benchmark import PROTOCOLS, score_files
from proxemetry.benchmark.labels import read_labels
from proxemetry.benchmark.validate_labels import check_labels
from proxemetry.camera import Camera, Mount
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.table import CameraTable
from proxemetry.cli import main
from proxemetry.measure import measure
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, MODEL, ORIENTATION, exif_of, gradient
from synthetic.small_photos import write_photos


def _predictions_whole() -> Any:
    people = [
        {"position_mm": [x, 0, 3000], "points": {"Torso": [u, 100], "Head": [u, 60]}}
        for x, u in ((0, 100), (1000, 300))
    ]
    return {"images": [{
        "filename": "a.jpg", "width": WIDTH, "height": HEIGHT, "people": people, "up": [0, -1, 0],
        "distances_mm": [[0, 1, 1000]], "intervals_mm": [[0, 1, 800, 1300]],
    }]}  # fmt: skip


_LABELS = {
    "body_pixel_locations.csv": (
        "P1,Torso,100,100,a.jpg,640,480\nP2,Torso,300,100,a.jpg,640,480\nP1,Head,99,60,a.jpg,640,480\n"
    ),
    "ground_truth_locations.csv": "0,P1,0,0,0\n0,P2,1000,0,0\n0,C1,0,1500,3000\n",
    "camera_locations_photoshoot_identifiers.csv": "0,C1,a.jpg\n",
    "settings.csv": "shoot,setting\n0,hall\n",
    "focal_lengths.csv": "filename,focal_length_mm\na.jpg,35\n",
}  # fmt: skip


def _write_labels(folder: Path) -> None:
    for name, text in _LABELS.items():
        (folder / name).write_text(text)


def _predictions(rng: Rng, folder: Path) -> HandIn:
    _write_labels(folder)
    (folder / "p.json").write_bytes(broken_json(rng, _predictions_whole()))

    def hand_in() -> Iterator[Scene]:
        score = score_files(str(folder / "p.json"), str(folder), pick(rng, list(PROTOCOLS)))
        json.loads(score.to_json(), parse_constant=_refuse)
        yield from ()

    return hand_in


def _labels(rng: Rng, folder: Path) -> HandIn:
    _write_labels(folder)
    (folder / "p.json").write_text(json.dumps(_predictions_whole()))
    name = pick(rng, list(_LABELS))
    (folder / name).write_bytes(broken_text(rng, _LABELS[name]))

    def hand_in() -> Iterator[Scene]:
        faults = check_labels(folder)
        assert all("\n" not in str(fault) for fault in faults), "a fault of several lines"
        labels = read_labels(folder)
        assert all(not image.focal_mm <= 0 for image in labels), "a focal length of 0 or less"
        score_files(str(folder / "p.json"), str(folder), "v1")
        yield from ()

    return hand_in


_TABLE = (
    "photo,make,model,focal_mm,focal_35mm,sensor_width_mm,sensor_height_mm,focal_px,focal_y_px,cx_px,cy_px,k1,pitch_deg,"
    "height_m\na.jpg,,,50,,36,24,,,,,,10,2\n*.jpg,,,,28,,,,,,,,,\n,Canon,EOS*,,,,,,,,,-0.1,,\nb*,,,,,,,700,701,320,240,0.01,,\n"
)


def _camera_table(rng: Rng, folder: Path) -> HandIn:
    (folder / "t.csv").write_bytes(broken_text(rng, _TABLE))

    def hand_in() -> Iterator[Scene]:
        request = FocalRequest(camera_table=CameraTable.read(folder / "t.csv"))
        recorded = recorded_whole()
        for name in ("a.jpg", "b/c.jpg"):
            estimate = estimate_camera(Photo(name, WIDTH, HEIGHT, ""), request)
            yield measure(Photo(name, WIDTH, HEIGHT, ""), pose=recorded, camera=estimate)

    return hand_in


def _mount(rng: Rng, folder: Path) -> HandIn:
    whole = Mount.stated(0.3, 0.02, 4.0, camera=Camera.centred(700, WIDTH, HEIGHT), size_px=(WIDTH, HEIGHT)).to_dict()
    (folder / "m.json").write_bytes(broken_json(rng, whole))

    def hand_in() -> Iterator[Scene]:
        mount = Mount.read(folder / "m.json")
        photo = Photo("a.jpg", WIDTH, HEIGHT, "")
        yield measure(photo, pose=recorded_whole(), camera=Camera.centred(700, WIDTH, HEIGHT), mount=mount)

    return hand_in


@cache
def _photo_whole(kind: str) -> bytes:
    buffer = io.BytesIO()
    tags = {MAKE: "Canon", MODEL: "Canon EOS 6D", FOCAL: (50, 1), FOCAL_35: 50, ORIENTATION: 6}
    exif = exif_of(tags, gps={1: "N", 2: (60.0, 10.0, 0.0), 3: "E", 4: (24.0, 0.0, 0.0)})
    Image.fromarray(gradient(80, 60)).save(buffer, kind, exif=exif)
    return buffer.getvalue()


def _metadata(rng: Rng, folder: Path) -> HandIn:
    kind = pick(rng, ["JPEG", "PNG", "TIFF", "WEBP"])
    (folder / "a.jpg").write_bytes(broken_bytes(rng, _photo_whole(kind), head=0.7))

    def hand_in() -> Iterator[Scene]:
        photo = Photo.open(folder / "a.jpg", with_names=True, with_gps=True)
        estimate_camera(photo, FocalRequest(assume_fov_deg=60))
        photo.pixels(64)
        yield from ()

    return hand_in


_BOX = [110.0, 130.0, 190.0, 345.0]
_ACTIONS: tuple[tuple[str, Any], ...] = (
    ("remove_person", {"box": _BOX}),
    ("add_person", {"joints": {"left_shoulder": [200, 150], "right_shoulder": [230, 150]}}),
    ("move_joint", {"box": _BOX, "joint": "nose", "to": [150, 140]}), ("set_camera", {"focal_px": 900}),
    ("set_camera", {"focal_mm": 50, "sensor_mm": [36, 24]}), ("set_camera", {"focal_35mm": 28}),
    ("off_floor", {"box": _BOX, "off_floor": True}), ("body_size", {"box": _BOX, "body_size": "adults"}),
    ("exclude", {"excluded": True, "reason": "x"}), ("note", {"text": "x"}), ("checked", {}), ("undo", {"number": 1}),
)  # fmt: skip


@cache
def _scene_whole() -> Scene:
    return measure(
        Photo("a.jpg", WIDTH, HEIGHT, "a1"), pose=recorded_whole(), camera=Camera.centred(700, WIDTH, HEIGHT)
    )


def _corrections(rng: Rng, folder: Path) -> HandIn:
    scene = _scene_whole()
    chosen = [_ACTIONS[int(rng.integers(len(_ACTIONS)))] for _ in range(3)]
    times = [int(n) for n in rng.choice(3, 3, p=(0.6, 0.3, 0.1))]
    values = [(a, mutated(rng, copy.deepcopy(value), n)) for (a, value), n in zip(chosen, times, strict=True)]

    def hand_in() -> Iterator[Scene]:
        log = Log(folder / FILE)
        refused = None
        for action, value in values:
            value = value if isinstance(value, dict) else {}
            try:
                log.append(scene, action, value, "ada")
            except Exception as error:
                refused = error
            if rng.random() < 0.2:  # as an earlier version, or another program, may have kept it
                log.keep(Action(0, "t", "ada", scene.photo, scene.sha256, action, _storable(value)))
        log.close()
        if rng.random() < 0.1:
            (folder / FILE).write_bytes(broken_bytes(rng, (folder / FILE).read_bytes()))
        yield from corrected_scenes(folder, lambda names, files: iter([scene])).values()
        if refused is not None:
            raise refused

    return hand_in


def _storable(value: dict[str, Any]) -> dict[str, Any]:
    try:
        json.dumps(value, allow_nan=False)
    except (ValueError, RecursionError):
        return {"box": "damaged"}
    return value


@cache
def _results_whole() -> dict[str, bytes]:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        photos, results = write_photos(Path(folder) / "photos", 3), Path(folder) / "r"
        pose = ["--pose", "python:synthetic.small_photos:two_people", "--jobs", "0"]
        assert main(["measure", str(photos), "--out", str(results), *pose]) == 0
        with_log = Log(results / FILE)
        with_log.close()
        return {str(p.relative_to(results)): p.read_bytes() for p in sorted(results.rglob("*")) if p.is_file()}


def _results(rng: Rng, folder: Path) -> HandIn:
    for name, content in _results_whole().items():
        (folder / "r" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "r" / name).write_bytes(content)
    names = [n for n in _results_whole() if not n.endswith((".csv",))]
    path = folder / "r" / pick(rng, names)
    way = rng.random()
    if way < 0.75:
        is_json = path.suffix == ".json" and rng.random() < 0.7
        content = path.read_bytes()
        path.write_bytes(broken_json(rng, json.loads(content)) if is_json else broken_bytes(rng, content))
    else:
        path.unlink()
        if way > 0.85:
            path.mkdir()
    commands = (["export", "--format", "csv"], ["summary"], ["export", "--format", "coco"])
    command, *more = pick(rng, commands)

    def hand_in() -> Iterator[Scene]:
        code = main([command, str(folder / "r"), *more])
        if code == 2:
            raise SystemExit(2)
        # 1: photos of a damaged part are rows that say so, the rest is answered.
        assert code in (0, 1), f"exit code {code}"
        yield from ()

    return hand_in


@dataclass(frozen=True)
class Whole:
    """A kind of file: its share of the inputs, and what makes a damaged one and hands it in."""

    share: float
    make: Callable[[Rng, Path], HandIn]


WHOLE: dict[str, Whole] = {
    "recording": Whole(40, recording), "predictions": Whole(14, _predictions), "labels": Whole(10, _labels),
    "camera table": Whole(10, _camera_table), "mount": Whole(6, _mount), "metadata": Whole(10, _metadata),
    "corrections": Whole(7, _corrections), "results": Whole(3, _results), "calibration": Whole(5, calibration),
    "detections": Whole(4, detections), "region": Whole(2, region), "clip": Whole(1, clip),
    "annotations": Whole(3, annotations),
}  # fmt: skip


def damaged(kind: str, rng: Rng, folder: Path) -> HandIn:
    """Write a damaged file of a kind and return what hands it in."""
    return WHOLE[kind].make(rng, folder)


def _refuse(name: str) -> float:
    raise AssertionError(f"{name} in a score")
