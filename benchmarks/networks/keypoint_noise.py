"""How steady each joint of a pose back end is: the numbers behind `keypoint_noise.toml`.

    python -m benchmarks.networks.keypoint_noise --photos DIR [--models DIR] --pose NAME [--runs 6]

Every photo is shown several times, each time cut and resized a little differently and every other time mirrored, and
each joint's spread over the runs is fitted by the law of `proxemetry.people.keypoint_noise`: what a detector's answer
owes to how a person happens to lie on its grid. What it owes to where people would put the joint is not in it: that is
the law's `definition`, COCO's spread between annotators (the OKS sigmas). Where the photos have labels (people.json:
the middle of the shoulders, to about 5 px), the error against them is a check of both.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np

from benchmarks.networks.backends import photos_in
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.people import People, PoseBackend
from proxemetry.people.keypoint_noise import NoiseLaw, apparent_stature_px, laws
from proxemetry.people.skeleton import MIDDLES, kind_of
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.cross_check import _closeness  # pyright: ignore[reportPrivateUsage]

_MOST_CUT, _MOST_RESIZED = 0.05, 0.12
_FEWEST_RUNS = 4
_MEDIAN_OF_NORMAL = 0.6745


def jittered(photo: Photo, rng: np.random.Generator, mirror: bool) -> tuple[Photo, FloatArray, float]:
    """Return the photo cut at random edges and resized, where its corner was, and the factor."""
    pixels = photo.pixels()
    height, width = pixels.shape[:2]
    x0, x1 = rng.integers(0, round(_MOST_CUT * width) + 1, 2)
    y0, y1 = rng.integers(0, round(_MOST_CUT * height) + 1, 2)
    part = pixels[y0 : height - y1, x0 : width - x1]
    wanted = 1 + rng.uniform(-_MOST_RESIZED, _MOST_RESIZED)
    size = round(part.shape[1] * wanted), round(part.shape[0] * wanted)
    drawn = cv2.resize(part, size, interpolation=cv2.INTER_AREA if wanted < 1 else cv2.INTER_CUBIC)
    factor = size[0] / part.shape[1]
    return Photo.from_array(np.ascontiguousarray(drawn[:, ::-1] if mirror else drawn)), np.array([x0, y0]), factor


def runs_of(backend: PoseBackend, photo: Photo, runs: int, rng: np.random.Generator) -> list[People]:
    """Return the people of each run, in pixels of the photo; the first run is of the photo itself."""
    seen = [backend.detect(photo)]
    for run in range(runs - 1):
        shown, corner, factor = jittered(photo, rng, mirror=run % 2 == 1)
        people = backend.detect(shown)
        people = people.mirrored(shown.width) if run % 2 == 1 else people
        people = people.scaled(1 / factor, 1 / factor)
        boxes = people.boxes_px + np.tile(corner, 2)
        seen.append(People(people.skeleton, people.keypoints_px + corner, people.scores, boxes, people.person_scores))
    return seen


def spreads(seen: Sequence[People]) -> Iterator[tuple[int, float, float, FloatArray]]:
    """Yield joint, mean score, apparent stature in pixels, and deviations of shape (runs, 2) from their median."""
    reference = seen[0]
    statures = apparent_stature_px(reference)
    same = [_closeness(reference, people) for people in seen]
    for person in range(len(reference)):
        rows = [
            (people, int(near[person].argmax()))
            for people, near in zip(seen, same, strict=True)
            if near.size and near[person].max() > 0.5
        ]
        if len(rows) < _FEWEST_RUNS:
            continue
        points = np.stack([people.keypoints_px[row] for people, row in rows])
        scores = np.stack([people.scores[row] for people, row in rows])
        for joint in range(points.shape[1]):
            there = scores[:, joint] > 0
            if there.sum() >= _FEWEST_RUNS:
                own = points[there, joint]
                deviation = (own - np.median(own, axis=0)) * np.sqrt(len(own) / (len(own) - 1))
                yield joint, float(scores[there, joint].mean()), float(statures[person]), deviation


def fitted(rows: Sequence[tuple[int, float, float, FloatArray]], joints: Sequence[str]) -> NoiseLaw:
    """Return the law under which the spreads are likeliest, their tails as heavy as Student's with 3 degrees."""
    joint = np.concatenate([np.full(d.size, j) for j, _, _, d in rows])
    score = np.concatenate([np.full(d.size, s) for _, s, _, d in rows])
    body = np.concatenate([np.full(d.size, b) for _, _, b, d in rows])
    deviation = np.abs(np.concatenate([d.ravel() for *_, d in rows]))
    names = [kind_of(name) for name in joints]
    kind = np.array([names[j] for j in joint])
    best: tuple[float, NoiseLaw] | None = None
    for floor in (0.2, 0.35, 0.5, 0.7, 1.0):
        for power in np.arange(0, 2.51, 0.1):
            relative: dict[str, float] = {}
            cost = 0.0
            for each in sorted(set(kind)):
                own = kind == each
                unit = np.clip(score[own], 0.1, 1) ** -power * body[own]
                relative[each] = _scale(deviation[own], unit, floor)
                sd = np.hypot(floor, relative[each] * unit)
                cost += float((np.log(sd) + 2 * np.log1p((deviation[own] / sd) ** 2 / 3)).sum())
            if best is None or cost < best[0]:
                relative["other"] = max(relative.values())
                best = cost, NoiseLaw(laws()["default"].definition, relative, float(power), floor, "this run")
    assert best is not None
    return best[1]


def _scale(deviation: FloatArray, unit: FloatArray, floor: float) -> float:
    """Return the factor at which half of the deviations lie within a normal distribution's middle half."""
    low, high = 1e-6, 1.0
    for _ in range(40):
        middle = np.sqrt(low * high)
        inside = np.median(deviation / np.hypot(floor, middle * unit)) < _MEDIAN_OF_NORMAL
        low, high = (low, middle) if inside else (middle, high)
    return float(high)


def check_against_labels(backend: PoseBackend, folder: Path, law: NoiseLaw) -> str:
    """Return one line on the middle of the shoulders against its labels, in units of the law's deviation."""
    images = json.loads((folder / "people.json").read_text())["images"]
    ratios: list[float] = []
    for path in photos_in(folder):
        people = backend.detect(Photo.open(path))
        statures, neck = apparent_stature_px(people), people.joint("neck")
        for label in images.get(path.name, {"people": []})["people"]:
            gaps = np.linalg.norm(neck - label["mid_shoulder"], axis=1) / np.maximum(statures, 1)
            if not len(gaps) or not np.nanmin(np.nan_to_num(gaps, nan=np.inf)) < 0.1:
                continue
            row = int(np.nanargmin(gaps))
            pair = [law.sd_px(j, people.joint_score(j)[row], statures[row]) for j in MIDDLES["neck"]]
            sd = np.sqrt(np.square(pair).sum() / 4 + 5.0**2)
            ratios.extend(np.abs(neck[row] - label["mid_shoulder"]) / sd)
    within = np.mean(np.array(ratios) < HALF_WIDTH_SD)
    return f"# middle of the shoulders against {len(ratios) // 2} labels: {within:.0%} within 90 % of the law's noise"


def main() -> None:
    """Print the law as a table for `keypoint_noise.toml`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    add_models_option(parser)
    parser.add_argument("--pose", required=True)
    parser.add_argument("--effort", default="normal")
    parser.add_argument("--runs", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    backend = backend_named(args.pose, PoseOptions(effort=args.effort))
    rng = np.random.default_rng(args.seed)
    rows = [
        row for path in photos_in(args.photos) for row in spreads(runs_of(backend, Photo.open(path), args.runs, rng))
    ]
    steady = fitted(rows, backend.skeleton.joints)
    number = len(rows)
    print(f"[{backend.name}]")
    print(f'origin = "spread over {args.runs} jittered runs of {number} joints; definition as the default"')
    print(f"score_power = {steady.score_power:.1f}\nfloor_px = {steady.floor_px}\n\n[{backend.name}.spread]")
    for kind, value in steady.spread.items():
        print(f"{kind} = {value:.4f}")
    if (args.photos / "people.json").is_file():
        print(check_against_labels(backend, args.photos, steady))


if __name__ == "__main__":
    main()
