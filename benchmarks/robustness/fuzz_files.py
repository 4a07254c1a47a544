"""The whole files that the fuzzer starts from, how it damages them, and how each is handed in."""

from __future__ import annotations

import copy
import io
import json
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

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
from proxemetry.pose.recorded import Recorded
from proxemetry.scene import Scene
from synthetic.camera_files import FOCAL, FOCAL_35, MAKE, MODEL, ORIENTATION, exif_of, gradient
from synthetic.small_photos import write_photos

Rng = np.random.Generator
HandIn = Callable[[], Iterable[Scene]]

WIDTH, HEIGHT = 640, 480
_NAMES = ("a.jpg", "b/c.jpg")
_COCO = (
    (0.0, -0.5), (0.02, -0.53), (-0.02, -0.53), (0.05, -0.5), (-0.05, -0.5), (0.12, -0.3), (-0.12, -0.3), (0.16, -0.1),
    (-0.16, -0.1), (0.17, 0.1), (-0.17, 0.1), (0.08, 0.05), (-0.08, 0.05), (0.08, 0.32), (-0.08, 0.32), (0.08, 0.55),
    (-0.08, 0.55),
)  # fmt: skip


def _person(x: float, size: float = 180.0, joints: int = 17) -> list[list[float]]:
    rows = [[round(x + u * size, 1), round(240 + v * size, 1), 0.9] for u, v in _COCO]
    return [rows[k % len(rows)] for k in range(joints)]


def _flat(x: float, joints: int = 17) -> list[float]:
    return [value for row in _person(x, joints=joints) for value in row]


def _own() -> Any:
    camera = {"fx": 700, "fy": 700, "cx": 320, "cy": 240, "k1": -0.05}
    people = [{"keypoints": _person(x), "box": [x - 40, 140, x + 40, 350], "score": 0.9} for x in (150, 320, 500)]
    images = [{"filename": n, "width": WIDTH, "height": HEIGHT, "camera": camera, "people": people} for n in _NAMES]
    return {"skeleton": "coco17", "images": images}


def _coco_annotations() -> Any:
    images = [{"id": k + 1, "file_name": n, "width": WIDTH, "height": HEIGHT} for k, n in enumerate(_NAMES)]
    marked = [v if k % 3 != 2 else 2 for k, v in enumerate(_flat(150))]
    annotations = [
        {"id": 1, "image_id": 1, "category_id": 1, "keypoints": marked, "bbox": [110, 140, 80, 210], "iscrowd": 0},
        {"id": 2, "image_id": 1, "category_id": 1, "keypoints": _flat(400), "score": 0.8},
    ]
    return {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "person"}]}


def _coco_results() -> Any:
    return [
        {"image_id": 1 + k % 2, "category_id": 1, "keypoints": _flat(150 + 120 * k), "score": 2.5} for k in range(3)
    ]


def _openpose() -> Any:
    people = [{"pose_keypoints_2d": _flat(x, 25)} for x in (150, 400)]
    return {"version": 1.3, "people": people}


def _ultralytics() -> Any:
    def one(x: float) -> dict[str, Any]:
        rows = np.array(_person(x))
        keypoints = {"x": rows[:, 0].tolist(), "y": rows[:, 1].tolist(), "visible": rows[:, 2].tolist()}
        box = {"x1": x - 40, "y1": 140, "x2": x + 40, "y2": 350}
        return {"name": "person", "class": 0, "confidence": 0.9, "box": box, "keypoints": keypoints}

    return [one(x) for x in (150, 400)]


def _mmpose() -> Any:
    def one(x: float) -> dict[str, Any]:
        points = [row[:2] for row in _person(x)]
        return {
            "keypoints": points,
            "keypoint_scores": [0.9] * 17,
            "bbox": [[x - 40, 140, x + 40, 350]],
            "bbox_score": 0.9,
        }

    return {"instance_info": [{"frame_id": 1, "instances": [one(150), one(400)]}], "meta_info": {}}


def _vitpose() -> Any:
    return {"preds": [_person(150), _person(400)], "image_paths": ["x/a.jpg", "x/a.jpg"], "boxes": [[0] * 6] * 2}


def _easy() -> Any:
    frames = {str(k): [[y, x, s] for x, y, s in _person(150 + 200 * k)] for k in range(2)}
    names = Recorded.__init__.__globals__["COCO_17"].joints
    return {"keypoints": [frames], "skeleton": {str(k): n for k, n in enumerate(names)}}


_RECORDINGS: dict[str, Callable[[], Any]] = {
    "own.json": _own, "annotations.json": _coco_annotations, "results.json": _coco_results,
    "a_keypoints.json": _openpose,
    "a.json": _ultralytics, "results_a.json": _mmpose, "preds.json": _vitpose, "a_result.json": _easy,
}  # fmt: skip
_TEXT = "\n".join("0 0.25 0.5 0.12 0.4 " + " ".join(f"{v / 640:.4f}" for v in _flat(x)) for x in (150, 400))


def _recording(rng: Rng, folder: Path) -> HandIn:
    name = _pick(rng, [*_RECORDINGS, "a.txt"])
    path = folder / name
    path.write_bytes(broken_text(rng, _TEXT) if name == "a.txt" else broken_json(rng, _RECORDINGS[name]()))

    def hand_in() -> Iterator[Scene]:
        recorded = Recorded(path if rng.random() < 0.9 else folder)
        for photo in list(recorded.photos)[:2]:
            known = recorded._recording(photo)
            opened = (
                recorded.photo(photo) if known and known.width and known.width > 1 else Photo(photo, WIDTH, HEIGHT, "")
            )
            camera = None if recorded.camera_of(opened) else Camera.centred(700, opened.width, opened.height)
            yield measure(opened, pose=recorded, camera=camera)

    return hand_in


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
        score = score_files(str(folder / "p.json"), str(folder), _pick(rng, list(PROTOCOLS)))
        json.loads(score.to_json(), parse_constant=_refuse)
        yield from ()

    return hand_in


def _labels(rng: Rng, folder: Path) -> HandIn:
    _write_labels(folder)
    (folder / "p.json").write_text(json.dumps(_predictions_whole()))
    name = _pick(rng, list(_LABELS))
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
        recorded = _recorded_whole()
        for name in ("a.jpg", "b/c.jpg"):
            estimate = estimate_camera(Photo(name, WIDTH, HEIGHT, ""), request)
            yield measure(Photo(name, WIDTH, HEIGHT, ""), pose=recorded, camera=estimate)

    return hand_in


@cache
def _recorded_whole() -> Recorded:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "own.json"
        content = _own()
        for image in content["images"]:
            del image["camera"]
        path.write_text(json.dumps(content))
        return Recorded(path)


def _mount(rng: Rng, folder: Path) -> HandIn:
    whole = Mount.stated(0.3, 0.02, 4.0, camera=Camera.centred(700, WIDTH, HEIGHT), size_px=(WIDTH, HEIGHT)).to_dict()
    (folder / "m.json").write_bytes(broken_json(rng, whole))

    def hand_in() -> Iterator[Scene]:
        mount = Mount.read(folder / "m.json")
        photo = Photo("a.jpg", WIDTH, HEIGHT, "")
        yield measure(photo, pose=_recorded_whole(), camera=Camera.centred(700, WIDTH, HEIGHT), mount=mount)

    return hand_in


@cache
def _photo_whole(kind: str) -> bytes:
    buffer = io.BytesIO()
    tags = {MAKE: "Canon", MODEL: "Canon EOS 6D", FOCAL: (50, 1), FOCAL_35: 50, ORIENTATION: 6}
    exif = exif_of(tags, gps={1: "N", 2: (60.0, 10.0, 0.0), 3: "E", 4: (24.0, 0.0, 0.0)})
    Image.fromarray(gradient(80, 60)).save(buffer, kind, exif=exif)
    return buffer.getvalue()


def _metadata(rng: Rng, folder: Path) -> HandIn:
    kind = _pick(rng, ["JPEG", "PNG", "TIFF", "WEBP"])
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
        Photo("a.jpg", WIDTH, HEIGHT, "a1"), pose=_recorded_whole(), camera=Camera.centred(700, WIDTH, HEIGHT)
    )


def _corrections(rng: Rng, folder: Path) -> HandIn:
    scene = _scene_whole()
    chosen = [_ACTIONS[int(rng.integers(len(_ACTIONS)))] for _ in range(3)]
    times = [int(n) for n in rng.choice(3, 3, p=(0.6, 0.3, 0.1))]
    values = [(a, _mutated(rng, copy.deepcopy(value), n)) for (a, value), n in zip(chosen, times, strict=True)]

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
    path = folder / "r" / _pick(rng, names)
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
    command, *more = _pick(rng, commands)

    def hand_in() -> Iterator[Scene]:
        code = main([command, str(folder / "r"), *more])
        if code == 2:
            raise SystemExit(2)
        assert code == 0, f"exit code {code}"
        yield from ()

    return hand_in


@dataclass(frozen=True)
class Whole:
    """A kind of file: its share of the inputs, and what makes a damaged one and hands it in."""

    share: float
    make: Callable[[Rng, Path], HandIn]


WHOLE: dict[str, Whole] = {
    "recording": Whole(40, _recording), "predictions": Whole(14, _predictions), "labels": Whole(10, _labels),
    "camera table": Whole(10, _camera_table), "mount": Whole(6, _mount), "metadata": Whole(10, _metadata),
    "corrections": Whole(7, _corrections), "results": Whole(3, _results),
}  # fmt: skip


def damaged(kind: str, rng: Rng, folder: Path) -> HandIn:
    """Write a damaged file of a kind and return what hands it in."""
    return WHOLE[kind].make(rng, folder)


def _pick(rng: Rng, items: Any) -> Any:
    return items[int(rng.integers(len(items)))]


def _refuse(name: str) -> float:
    raise AssertionError(f"{name} in a score")


_ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 10**400, -(10**400), 2**63, 0.5,
    1e9, 3e9, "", "x", "0", "1e400", "nan", "a\x00b", "\ud800", "=1+1", "../../x", "ä\u202e", [], {}, [[]], [None],
    {"a": 1},
)  # fmt: skip


def _mutated(rng: Rng, content: Any, times: int) -> Any:
    """Return a JSON value with some of its parts replaced, doubled or taken away."""
    for _ in range(times):
        content = _changed(rng, content)
    return content


def _changed(rng: Rng, content: Any) -> Any:
    places: list[tuple[Any, Any]] = []
    waiting = [content]
    while waiting:
        item = waiting.pop()
        keys = list(item) if isinstance(item, dict) else range(len(item)) if isinstance(item, list) else ()
        for key in keys:
            places.append((item, key))
            waiting.append(item[key])
    if not places or rng.random() < 0.02:
        return _odd(rng)
    parent, key = _pick(rng, places)
    way = rng.random()
    if way < 0.6:
        parent[key] = _odd(rng)
    elif way < 0.75 and isinstance(parent[key], int | float) and abs(parent[key]) < 1e300:
        parent[key] = float(parent[key]) * float(_pick(rng, [-1, 0, 1e-9, 1e6, 1e200, 1e-300, 1000]))
    elif way < 0.9:
        del parent[key]
    elif isinstance(parent, list):
        parent.insert(key, copy.deepcopy(parent[key]))
    else:
        parent[f"{key} "] = parent[key]
    return content


def _odd(rng: Rng) -> Any:
    way = rng.random()
    if way < 0.02:
        return "long " * 20_000
    if way < 0.03:
        return [0] * 30_000
    return copy.deepcopy(_pick(rng, _ODD))


def broken_json(rng: Rng, content: Any) -> bytes:
    """Return a JSON text with something changed in it, or broken as a text."""
    way = rng.random()
    if way < 0.01:
        return b"[" * 100_000
    text = json.dumps(_mutated(rng, content, int(rng.choice([1, 2, 3], p=(0.6, 0.3, 0.1)))))
    return text.encode() if way < 0.8 else broken_bytes(rng, text.encode())


def broken_text(rng: Rng, text: str) -> bytes:
    """Return lines of cells with cells or lines changed, or broken as a text."""
    lines = text.split("\n")
    for _ in range(int(rng.choice([1, 2, 3], p=(0.6, 0.3, 0.1)))):
        row = int(rng.integers(len(lines)))
        separator = "," if "," in lines[row] else " "
        cells = lines[row].split(separator)
        column, way = int(rng.integers(len(cells))), rng.random()
        if way < 0.6:
            odd = _odd(rng)
            cells[column] = str(odd if not isinstance(odd, int) or abs(odd) < 10**50 else "1" + "0" * 400)
        elif way < 0.75:
            del cells[column]
        elif way < 0.9:
            cells.insert(column, cells[column])
        else:
            lines.insert(row, lines[row])
        lines[row] = separator.join(cells)
    content = "\n".join(lines).encode("utf-8", "surrogatepass")
    return content if rng.random() < 0.8 else broken_bytes(rng, content)


def broken_bytes(rng: Rng, content: bytes, head: float = 0.0) -> bytes:
    """Return bytes that are cut, flipped, repeated or overwritten; `head`: how often only near their beginning."""
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        if not changed:
            break
        end = min(len(changed), 600) if rng.random() < head else len(changed)
        at, way = int(rng.integers(end)), rng.random()
        if way < 0.4:
            changed[at] ^= 1 << int(rng.integers(8))
        elif way < 0.6:
            changed[at : at + 4] = rng.integers(0, 256, 4, dtype=np.uint8).tobytes()
        elif way < 0.75:
            changed[at:at] = changed[at : at + int(rng.integers(1, 40))]
        elif way < 0.9:
            del changed[at : at + int(rng.integers(1, 40))]
        else:
            del changed[at:]
    return bytes(changed)
