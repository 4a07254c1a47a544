"""Clips end to end against PETS 2009 S2.L1, view 1: distances, seconds near each other, identities, speed.

    python -m benchmarks.accuracy.clips FOLDER [--pose yolox-tinypose] [--camera people points exact]

FOLDER holds the data set's files (`benchmarks/accuracy/pets.py`). Everything is done by the commands that users have,
from the video's own pixels: `proxemetry video` with the camera estimated from the people (focal length known), with a
mount that `proxemetry calibrate --points` makes from four points (2 px clicks, 0.1 m tape), and with the data set's own
calibration. The truth is where the lower edges of the annotated boxes meet the data set's floor, a plane: accurate to
0.1-0.2 m. Seconds within X are counted over annotated pairs, frame by frame. IDF1, switches and MOTA are those of MOT
Challenge, from the tracks' boxes.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import resource
import tempfile
import time
from collections import defaultdict
from contextlib import redirect_stdout
from pathlib import Path

import cv2
import numpy as np

from benchmarks.accuracy.pets import Calibration, read_truth
from proxemetry.assignment import assign
from proxemetry.cli import main as proxemetry
from proxemetry.overlap import pairwise_iou

FPS = 5.0
LAST_S = 39.95
LIMITS = (1.0, 1.5, 2.0)
CLICK_PX, TAPE_M = 2.0, 0.1
POINTS_M = np.array([[-13.0, -13.0], [-8.0, 5.0], [6.0, -8.0], [-2.0, -12.0]])


def main() -> None:
    """Run the clip with each camera and print a row each."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--pose", default="yolox-tinypose")
    parser.add_argument(
        "--camera", nargs="+", default=["people", "points", "exact"], choices=("people", "points", "exact")
    )
    parser.add_argument("--out", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0, help="seed of the simulated clicks")
    args = parser.parse_args()
    out = args.out or Path(tempfile.mkdtemp())
    clip = _first_frames(args.folder, out)
    calibration, truth = Calibration.read(args.folder), read_truth(args.folder)
    print(
        "| camera | pitch, height | tracks | IDF1 | switches | MOTA | pairs | mean pair error | median | bias "
        "| 90 % holds | seconds within 1, 1.5, 2 m | truth |"
    )
    print("|---|---|---|---|---|---|---|---|---|---|---|---|---|")
    for camera in args.camera:
        told = _camera_options(camera, clip, calibration, args.seed)
        begun = time.perf_counter(), _cpu()
        _run("video", clip, "--out", out / camera, "--restart", "--pose", args.pose, "--fps", FPS, "--jobs", args.jobs,
             "--within", *LIMITS, *told)  # fmt: skip
        wall, spent = time.perf_counter() - begun[0], _cpu() - begun[1]
        frames = len(_rows(out / camera, "frames"))
        print(score(out / camera, truth, camera), flush=True)
        print(
            f"    {camera}: {frames} frames in {wall:.0f} s; {1000 * spent / frames:.0f} ms of processor time a frame, "
            f"everything included: two cores would do {2 * frames / spent:.1f} frames a second", flush=True,
        )  # fmt: skip


def _run(*arguments: object) -> None:
    """Run a command of proxemetry as a user does, its own report kept off stdout."""
    with redirect_stdout(io.StringIO()) as said:
        code = proxemetry([str(a) for a in arguments])
    if code:
        raise SystemExit(f"proxemetry {' '.join(map(str, arguments))}: exit code {code}\n{said.getvalue()}")


def _camera_options(camera: str, clip: Path, calibration: Calibration, seed: int) -> list[object]:
    """Return what `proxemetry video` is told of the camera; four points are given to `proxemetry calibrate` first."""
    focal = ["--focal-px", f"{calibration.camera.f_px:.2f}"]
    if camera == "people":
        return focal
    path = clip.with_name(f"{camera}.json")
    if camera == "exact":
        calibration.mount().write(path)
    else:
        points = clip.with_name("points.csv")
        write_clicks(points, calibration, seed)
        _run("calibrate", clip, "--points", points, "--click-sd-px", CLICK_PX, "--tape-sd-m", TAPE_M, *focal,
             "--out", path)  # fmt: skip
    return ["--mount", path]


def _cpu() -> float:
    return sum(
        r.ru_utime + r.ru_stime for r in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def _first_frames(folder: Path, out: Path) -> Path:
    """Write the frames whose truth is known as a clip of their own, without loss."""
    path = out / "pets.avi"
    out.mkdir(parents=True, exist_ok=True)
    if path.exists():
        return path
    source = cv2.VideoCapture(str(folder / "vtest.avi"))
    target = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"FFV1"), 10.0, (768, 576))
    for _ in range(400):
        target.write(source.read()[1])
    target.release()
    return path


def write_clicks(path: Path, calibration: Calibration, seed: int) -> None:
    """Write four points of the floor as someone with a mouse and a tape would find them."""
    rng = np.random.default_rng(seed)
    clicked = calibration.project(POINTS_M) + rng.normal(0, CLICK_PX, (4, 2))
    taped = POINTS_M + rng.normal(0, TAPE_M, (4, 2))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("u_px", "v_px", "x_m", "y_m"))
        writer.writerows(np.column_stack([clicked, taped]).round(4).tolist())


def _rows(folder: Path, table: str) -> list[dict[str, str]]:
    with (folder / f"{table}.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def score(folder: Path, truth: dict, name: str) -> str:
    """Return a table row: how far a results folder is from the truth."""
    boxes = defaultdict(dict)
    for line in (folder / "mot.txt").read_text().splitlines():
        frame, track, x, y, w, h, *_ = map(float, line.split(","))
        boxes[int(frame) - 1][int(track)] = (x, y, x + w, y + h)
    times = {int(r["frame"]): float(r["t_s"]) for r in _rows(folder, "frames")}
    distance = {
        (int(r["frame"]), int(r["track_a"]), int(r["track_b"])): [
            float(r[k]) for k in ("distance_m", "low_m", "high_m")
        ]
        for r in _rows(folder, "pairs_over_time")
    }
    last, shared = {}, defaultdict(int)
    counted = np.zeros(4)  # truths, hypotheses, matched, switches
    apart, holds, seconds = [], [], np.zeros(len(LIMITS))
    for frame, t_s in times.items():
        moment = truth.get(round(10 * t_s))
        if moment is None or t_s > LAST_S:
            continue
        tracks = list(boxes[frame])
        overlap = pairwise_iou(moment.boxes_px, np.array([boxes[frame][t] for t in tracks]).reshape(-1, 4))
        for i, j in np.argwhere(overlap >= 0.5):
            shared[moment.ids[i], tracks[j]] += 1
        keep = np.array([[last.get(i) == t for t in tracks] for i in moment.ids]).reshape(overlap.shape)
        pairs = [(i, j) for i, j in assign(1 - overlap - 10.0 * (keep & (overlap >= 0.5))) if overlap[i, j] >= 0.5]
        counted += (
            len(moment.ids),
            len(tracks),
            len(pairs),
            sum(last.get(moment.ids[i], tracks[j]) != tracks[j] for i, j in pairs),
        )
        last.update({moment.ids[i]: tracks[j] for i, j in pairs})
        gaps = np.linalg.norm(moment.places_m[:, None] - moment.places_m, axis=-1)
        seconds += [(gaps[np.triu_indices(len(gaps), 1)] < x).sum() / FPS for x in LIMITS]
        for k, (i, a) in enumerate(pairs):
            for j, b in pairs[k + 1 :]:
                found = distance.get((frame, *sorted((tracks[a], tracks[b]))))
                if found is not None:
                    apart.append(found[0] / gaps[i, j] - 1)
                    holds.append(found[1] <= gaps[i, j] <= found[2])
    return _line(folder, name, counted, shared, np.array(apart), np.array(holds), seconds)


def _line(folder, name, counted, shared, apart, holds, seconds) -> str:
    ids, tracks = sorted({i for i, _ in shared}), sorted({t for _, t in shared})
    table = np.zeros((len(ids), len(tracks)))
    for (i, t), n in shared.items():
        table[ids.index(i), tracks.index(t)] = n
    right = sum(table[i, t] for i, t in assign(-table))
    truths, found, matched, switches = counted
    summary, mount = (json.loads((folder / n).read_text()) for n in ("summary.json", "mount.json"))
    near = [summary["within_m"][f"{x:g}"]["pair_seconds"] for x in LIMITS]
    said = ", ".join(f"{v['seconds']:.1f} [{v['low_s']:.1f}, {v['high_s']:.1f}]" for v in near)
    return (
        f"| {name} | {mount['pitch_deg']:.1f}, {mount['height_m']:.2f} m | {summary['n_tracks']} "
        f"| {2 * right / (truths + found):.2f} | {switches:.0f} "
        f"| {1 - (truths + found - 2 * matched + switches) / truths:.2f} | {len(apart)} "
        f"| {100 * np.abs(apart).mean():.1f} % | {100 * np.median(np.abs(apart)):.1f} % | {100 * apart.mean():+.1f} % "
        f"| {100 * holds.mean():.0f} % | {said} "
        f"| {', '.join(f'{s:.1f}' for s in seconds)} |"
    )


if __name__ == "__main__":
    main()
