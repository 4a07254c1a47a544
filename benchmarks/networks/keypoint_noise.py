"""The noise of a back end's joints: the rows of `keypoint_noise.toml`.

    python -m benchmarks.networks.keypoint_noise --pose NAME [--labels DIR] [--repeat DIR] [--beside NAME]

From hand-labelled people (`hand_labels`): how far each kind of joint lies from its label by score and by size in the
photo (`proxemetry.people.keypoint_noise` has the law); by how much lengths between joints differ from the labelled ones
for everyone (`scale`), and from person to person beyond what the noise of their ends explains (`common`). Errors have
Student's tails, as the scene fit has them. Kinds of joint are pooled where labels are few: all of the head, shoulders,
hips, knees with ankles and what is below them. The annotators' own scatter is in it, so the rows are a
little too wide where scores are high.

With --repeat the photos of a folder are shown in other ways (`consistency`), and a comment says which part of the law's
noise differs from look to look: the rest is the same in every look, so that no second look reveals it.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.consistency import looks_at, photos_below, same_people
from benchmarks.networks.hand_labels import LENGTHS, Pair, joint_arrays, labelled_people, pairs
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.people import PoseBackend
from proxemetry.people.keypoint_noise import NoiseLaw, apparent_stature_px, laws
from proxemetry.people.skeleton import COCO_17, Skeleton, kind_of
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named

FloatArray = NDArray[np.float64]

#: Kinds of joint that are measured together; the last has the others besides.
GROUPS: Mapping[str, tuple[str, ...]] = {
    "head": ("nose", "eye", "eye_inner", "eye_outer", "ear", "mouth"),
    "shoulders": ("shoulder",),
    "hips": ("hip",),
    "arms": ("elbow", "wrist", "pinky", "index", "thumb"),
    "legs": ("knee", "ankle", "heel", "big_toe", "small_toe"),
}
#: The scene fit does not use them: they do not choose power and floor.
_UNUSED = ("arms",)
_FLOORS_PX = (0.2, 0.35, 0.5, 0.7, 1.0, 1.3, 1.6, 2.0)
_POWERS = np.arange(0.4, 2.41, 0.2)
_SCALES = np.geomspace(5e-4, 0.08, 90)
_DOF = 5.0
_MEDIAN_OF_NORMAL = 0.6745
#: Fewer labelled lengths say nothing of how people differ.
_FEWEST = 12


def fitted(joints: Sequence[str], score: FloatArray, body_px: FloatArray, error: FloatArray) -> NoiseLaw:
    """Return the law under which errors are likeliest: score and body_px (N,), error (N, 2) in statures."""
    group = np.array([_group_of(kind_of(joint)) for joint in joints])
    best: tuple[float, float, float, dict[str, float]] | None = None
    for floor in _FLOORS_PX:
        for power in _POWERS:
            scales, total = {}, 0.0
            for name in sorted(set(group)):
                own = group == name
                unit = np.clip(score[own], 0.1, 1) ** -power
                sd = np.hypot(_SCALES[:, None] * unit, floor / body_px[own])[..., None]
                cost = np.log(sd) * 2 + (_DOF + 1) / 2 * np.log1p((error[own] / sd) ** 2 / _DOF).sum(-1, keepdims=True)
                costs = cost.sum(axis=(1, 2))
                scales[name] = float(_SCALES[costs.argmin()])
                total += float(costs.min()) * (name not in _UNUSED)
            if best is None or total < best[0]:
                best = total, floor, float(power), scales
    assert best is not None
    _, floor, power, scales = best
    spread = {kind: scales[name] for name, kinds in GROUPS.items() if name in scales for kind in kinds}
    return NoiseLaw(
        laws()["default"].definition, {**spread, "other": max(scales.values())}, round(power, 1), floor, "this run"
    )


def _group_of(kind: str) -> str:
    return next((name for name, kinds in GROUPS.items() if kind in kinds), "legs")


def lengths(found: Sequence[Pair], law: NoiseLaw) -> Iterator[tuple[str, int, float, float, float]]:
    """Yield name, number, median ratio to the labelled length and its standard error, and what people have in common.

    The last is the relative standard deviation from person to person beyond the noise of the length's ends.
    """
    for name in LENGTHS:
        rows = [(*ratio, pair.stature_px) for pair in found if (ratio := pair.ratio(name)) is not None]
        if len(rows) < _FEWEST:
            continue
        ratios = np.array([row[0] for row in rows])
        expected = np.array([_end_noise(name, law, row[2], row[3]) / row[1] for row in rows])
        middle = float(np.median(ratios))
        spread = np.median(np.abs(ratios - middle)) / _MEDIAN_OF_NORMAL
        common = float(np.sqrt(max(spread**2 - np.median(expected) ** 2, 0.0)))
        yield name, len(rows), middle, float(1.2533 * spread / np.sqrt(len(rows))), common


def _end_noise(name: str, law: NoiseLaw, scores: tuple[float, float], body_px: float) -> float:
    """Return the noise of a length along itself, in statures; middles of two joints have half the variance."""
    one, other, _ = LENGTHS[name]
    variance = 0.0
    for joint, score in zip((one, other), scores, strict=True):
        kind, halved = {"neck": ("shoulder", 2), "mid_hip": ("hip", 2)}.get(joint, (joint, 1))
        own = law.score_noise([kind], [max(score, 0.1)])[0] ** 2 + (law.floor_px / body_px) ** 2
        variance += float(own) / halved
    return float(np.sqrt(variance))


def repeated(backend: PoseBackend, photos: Sequence[Path], law: NoiseLaw) -> float:
    """Return how much of the law's noise differs from look to look: 1 where all of it does."""
    units: list[FloatArray] = []
    for path in photos:
        first, *others = looks_at(Photo.open(path), backend)
        people = first.in_photo()
        statures = apparent_stature_px(people)
        for other in others:
            again = other.in_photo()
            for row, column in same_people(people, again):
                moved = (again.keypoints_px[column] - people.keypoints_px[row]) / statures[row]
                noise = [
                    law.score_noise(people.skeleton.joints, p.scores[r]) for p, r in ((people, row), (again, column))
                ]
                floor = law.floor_px / statures[row]
                units.append(np.abs(moved / np.hypot(*(np.hypot(w, floor) for w in noise))[:, None]).ravel())
    return float(np.nanmedian(np.concatenate(units)) / _MEDIAN_OF_NORMAL)


def beside(found: Sequence[Pair], others: Sequence[Pair]) -> Iterator[tuple[str, int, FloatArray, float, float]]:
    """Yield group, number of joints, how far the back end and another one are from the labels and from each other
    (3,), in statures, and the share of the first's variance that is the labels', with its standard error.

    From three that err independently each one's variance follows (Grubbs 1948). What both networks get wrong alike
    counts as the labels': shares are upper limits.
    """
    there = {(pair.photo, pair.row): pair for pair in others}
    both = [(pair, there[pair.photo, pair.row]) for pair in found if (pair.photo, pair.row) in there]
    rng = np.random.default_rng(0)
    for name, kinds in GROUPS.items():
        gaps = [gap for one, other in both for gap in _three_gaps(one, other, kinds)]
        if len(gaps) < _FEWEST:
            continue
        apart = np.array(gaps)
        drawn = [_share(apart[rng.integers(len(apart), size=len(apart))]) for _ in range(200)]
        yield name, len(apart), _spreads(apart), _share(apart), float(np.std(drawn))


def _three_gaps(one: Pair, other: Pair, kinds: Sequence[str]) -> Iterator[FloatArray]:
    """Yield of each joint of these kinds that all three have (3, 2): one and other minus the label, one minus other."""
    for joint in COCO_17.joints:
        if kind_of(joint) in kinds:
            label = one.truth.joint(joint)[one.row]
            seen, again = one.seen.joint(joint)[one.seen_row], other.seen.joint(joint)[other.seen_row]
            gaps = np.array([seen - label, again - label, seen - again]) / one.stature_px
            if np.isfinite(gaps).all():
                yield gaps


def _spreads(gaps: FloatArray) -> FloatArray:
    return np.median(np.abs(gaps), axis=(0, 2)) / _MEDIAN_OF_NORMAL


def _share(gaps: FloatArray) -> float:
    one, other, between = _spreads(gaps) ** 2
    return float((one + other - between) / 2 / one)


def row_of(name: str, skeleton: Skeleton, found: Sequence[Pair], law: NoiseLaw) -> list[str]:
    """Return the lines of a back end's row."""
    number = sum(len(list(pair.errors())) for pair in found)
    lines = [
        f"[{name}]",
        f'origin = "{number} joints of {len(found)} people labelled by hand (benchmarks/networks/keypoint_noise.py)"',
        f"score_power = {law.score_power}", f"floor_px = {law.floor_px}", "", f"[{name}.spread]",
    ]  # fmt: skip
    kinds = dict.fromkeys([*map(kind_of, skeleton.joints), "other"])
    lines += [f"{kind} = {law.spread.get(kind, law.spread['other']):.4f}" for kind in kinds]
    lines.append("")
    for length, count, ratio, error, common in lengths(found, law):
        lines.append(f"# {length}: {ratio:.3f} of {count} labelled, give or take {error:.3f}; common {common:.3f}")
    return lines


def main() -> None:
    """Print the row of a back end as it stands in `keypoint_noise.toml`."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, default=Path("../shared/data/labelled_people"))
    parser.add_argument("--repeat", type=Path, help="photos to measure repeatedly")
    parser.add_argument("--beside", help="another back end: how much of the errors is the labels'")
    add_models_option(parser)
    parser.add_argument("--pose", required=True)
    parser.add_argument("--effort", default="normal")
    args = parser.parse_args()
    backend = backend_named(args.pose, PoseOptions(effort=args.effort))
    found = pairs(backend, labelled_people(args.labels))
    arrays = joint_arrays(found)
    law = fitted(arrays["joint"], arrays["score"], arrays["body_px"], arrays["error"])
    print("\n".join(row_of(backend.name, backend.skeleton, found, law)))
    if args.beside:
        others = pairs(backend_named(args.beside, PoseOptions(effort=args.effort)), labelled_people(args.labels))
        for name, count, (one, other, between), share, error in beside(found, others):
            print(
                f"# {name}: {one:.4f} from {count} labels, {args.beside} {other:.4f}, {between:.4f} from each other: "
                f"{share:.2f} give or take {error:.2f} of the variance is the labels'"
            )
    if args.repeat:
        print(f"# {repeated(backend, photos_below([args.repeat]), law):.2f} of it differs from look to look")


if __name__ == "__main__":
    main()
