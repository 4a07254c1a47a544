"""A clip from file to tables against its truth: PETS 2009 S2.L1, view 1, frames 0-399.

    python -m benchmarks.accuracy.clips FOLDER [--pose yolox-tinypose] [--camera people points exact] [--out DIR]

FOLDER is read by `benchmarks.accuracy.pets`. Each camera is a run of its own: `people` knows the focal length and the
centre of the picture alone; `points` are four points on the floor, clicked to 2 pixels and taped to 0.1 m, of the
same lens; `exact` is the data set's calibration. Pairs are those of people whose boxes overlap the annotated ones by
half. IDF1, switches and MOTA are those of MOT Challenge, from the track's boxes.
"""

from __future__ import annotations

import argparse
import csv
import json
import resource
import tempfile
import time
from collections import defaultdict
from pathlib import Path

import cv2
import numpy as np

from benchmarks.accuracy.pets import Calibration, read_truth
from proxemetry.assignment import assign
from proxemetry.camera import Camera, Mount
from proxemetry.camera.focal import FocalRequest
from proxemetry.clip.analysis import Wanted
from proxemetry.clip.measuring import Job
from proxemetry.clip.run import run_clip
from proxemetry.clip.tracking import intersection_over_union
from proxemetry.measure import Settings
from proxemetry.pose import PoseOptions

FPS = 5.0
LAST_S = 39.95
LIMITS = (1.0, 1.5, 2.0)
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
    parser.add_argument("--seed", type=int, default=0, help="of the clicks")
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
        mount = {
            "people": lambda: None,
            "points": lambda: from_clicks(calibration, args.seed),
            "exact": calibration.mount,
        }[camera]()
        focal = FocalRequest(focal_px=calibration.camera.f_px) if mount is None else FocalRequest()
        settings = Settings(focal=focal, mount=mount)
        begun = time.perf_counter(), _cpu()
        run_clip(
            clip, str(out / camera), Job(args.pose, PoseOptions(), settings),
            Wanted(LIMITS, mount=mount, settings=settings), fps=FPS, jobs=args.jobs,
        )  # fmt: skip
        spent = time.perf_counter() - begun[0], _cpu() - begun[1]
        print(score(out / camera, truth, camera), flush=True)
        print(f"    {camera}: {spent[0]:.0f} s, {spent[1]:.0f} s of processor time, for {len(truth) // 2} frames")


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


def from_clicks(calibration: Calibration, seed: int, click_px: float = 2.0, tape_m: float = 0.1) -> Mount:
    """Return the mount of four points of the floor, by least squares on noisy clicks, with its spread by bootstrap."""
    rng = np.random.default_rng(seed)
    camera = Camera.centred(calibration.camera.f_px, calibration.camera.width, calibration.camera.height)
    clicked = calibration.project(POINTS_M) + rng.normal(0, click_px, (4, 2))
    taped = POINTS_M + rng.normal(0, tape_m, (4, 2))
    best = _pose(camera, clicked, taped)
    spread = np.array([
        _pose(camera, clicked + rng.normal(0, click_px, (4, 2)), taped + rng.normal(0, tape_m, (4, 2)))
        for _ in range(300)
    ])  # fmt: skip
    covariance = np.full((4, 4), np.nan)
    covariance[:3, :3] = np.cov(spread.T)
    rows = tuple(tuple(r) for r in covariance.tolist())
    return Mount(best[0], best[1], float(np.exp(best[2])), rows, camera, source="four points")


def _pose(camera: Camera, clicked: np.ndarray, taped: np.ndarray) -> np.ndarray:
    """Return pitch, roll and log height of the camera that sees these points of the floor there."""
    matrix = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    world = np.column_stack([taped, np.zeros(4)])
    _, turn, shift = cv2.solvePnP(world, clicked, matrix, None, flags=cv2.SOLVEPNP_IPPE)
    turn, shift = cv2.solvePnPRefineLM(world, clicked, matrix, None, turn, shift)
    rotation = cv2.Rodrigues(turn)[0]
    up, height = rotation[:, 2], float(-(rotation.T @ shift)[2, 0])
    if height < 0:
        up, height = -up, -height
    return np.array([-np.arcsin(up[2]), np.arctan2(up[0], -up[1]), np.log(height)])


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
        overlap = intersection_over_union(moment.boxes_px, np.array([boxes[frame][t] for t in tracks]).reshape(-1, 4))
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
