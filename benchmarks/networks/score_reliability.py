"""Reliability of scores: the share of real people by person score, and the error of joints by joint score.

    python -m benchmarks.networks.score_reliability --photos DIR --pose NAME [--models DIR] [--effort normal]

DIR is the folder of backends.py, which defines who is a labelled person, a double or false. The thresholds are lowered
to `--least` and all tiles are searched, since hardly anyone above the usual thresholds is false. People in the zones of
real but unlabelled ones are not counted.

Per bin of scores it prints the share of labelled people with Wilson's 90 % interval, as if each person were
in a photo of their own, and the probability from a logistic curve of the score that was fitted on all other photos.
Below that are Brier scores, of everyone and of those whom the back end would have kept: of the raw
score as it is, of that curve, and of one number for all, the share of the other photos. A curve is worth having where
it beats that number.

The table of joints is about the middle of the shoulders (its score is the lower of the two) and its label: of people
matched by their heads alone, so that large errors are not excluded. The unit is the labelled distance from head to
shoulders; a hand label itself is accurate to about a tenth of it.
"""

from __future__ import annotations

import argparse
import importlib
import itertools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.backends import verdicts
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.onnx.backend import OnnxBackend

_EDGES = np.array([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0])
#: A weak normal prior (standard deviation) on the curve's slope: where the score parts real from false without
#: overlap, the likelihood alone would have it infinite.
_SLOPE_SD = 10.0


@dataclass(frozen=True)
class Candidates:
    """Everyone who scored at all: shape (N,) each. photos numbers the photo; what is `backends.verdicts`'s word."""

    scores: FloatArray
    what: NDArray[np.str_]
    photos: NDArray[np.intp]

    @property
    def are_real(self) -> NDArray[np.bool_]:
        """Whether each is a labelled person, found for the first time."""
        return np.isin(self.what, ("clear", "hard"))


def loosened(name: str, options: PoseOptions, least: float) -> tuple[PoseBackend, float]:
    """Return the back end with its thresholds lowered, where any are known here, and what a person's was."""
    backend = backend_named(name, options)
    if isinstance(backend, OnnxBackend):
        spec = backend.specification
        detector = replace(spec.detector, score=least, suspicion=0.0)
        lowered = replace(spec, detector=detector, person_score=min(least, spec.person_score))
        return OnnxBackend(lowered, options), spec.person_score
    module = importlib.import_module(type(backend).__module__)
    known = [constant for constant in ("LIKELY", "PERSON_MINIMUM") if hasattr(module, constant)]
    kept_from = float(getattr(module, "PERSON_MINIMUM", 0.0))
    for constant in known:
        setattr(module, constant, least)
    print(f"thresholds lowered: {', '.join(known) or 'none, only who passed them is in the table'}")
    return backend, kept_from


def candidates(seen: Sequence[People], labels: Sequence[Mapping[str, Any]]) -> Candidates:
    """Return everyone in all photos but those whom the labels say nothing of."""
    what = [verdicts(people, label) for people, label in zip(seen, labels, strict=True)]
    numbers = np.repeat(np.arange(len(seen)), [len(people) for people in seen])
    all_of = Candidates(
        np.concatenate([p.person_scores for p in seen]), np.array(list(itertools.chain(*what))), numbers
    )
    known = all_of.what != "unlabelled"
    return Candidates(all_of.scores[known], all_of.what[known], all_of.photos[known])


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return Wilson's 90 % interval of a share (Wilson 1927); 0 to 1 of nobody."""
    if count == 0:
        return 0.0, 1.0
    share, z2 = hits / count, HALF_WIDTH_SD**2
    middle = (share + z2 / (2 * count)) / (1 + z2 / count)
    half = np.sqrt(z2 * (share * (1 - share) / count + z2 / (4 * count**2))) / (1 + z2 / count)
    return max(0.0, middle - half), min(1.0, middle + half)


def logistic_curve(scores: FloatArray, are_real: NDArray[np.bool_]) -> tuple[float, float]:
    """Return bias and slope of the likeliest logistic curve of the score, by Newton's method."""
    design = np.stack([np.ones_like(scores), scores], axis=1)
    prior = np.diag([0.0, 1 / _SLOPE_SD**2])
    beta = np.zeros(2)
    for _ in range(50):
        chance = 1 / (1 + np.exp(-design @ beta))
        slope = design.T @ (are_real - chance) - prior @ beta
        curvature = (design * (chance * (1 - chance))[:, None]).T @ design + prior + 1e-9 * np.eye(2)
        step = np.linalg.solve(curvature, slope)
        beta += step * min(1.0, 5 / max(float(np.abs(step).max()), 1e-12))
    return float(beta[0]), float(beta[1])


def left_out(found: Candidates) -> FloatArray:
    """Return everyone's probability from the curve of the other photos, shape (N,)."""
    chances = np.full(len(found.scores), np.nan)
    for photo in np.unique(found.photos):
        here = found.photos == photo
        bias, slope = logistic_curve(found.scores[~here], found.are_real[~here])
        chances[here] = 1 / (1 + np.exp(-bias - slope * found.scores[here]))
    return chances


def brier_line(found: Candidates, curve: FloatArray, least: float) -> str:
    """Return the mean squared difference between what was said and what is, of those who score at least `least`."""
    rows = found.scores >= least
    shares = np.array([found.are_real[rows & (found.photos != photo)].mean() for photo in found.photos])
    raw, of_curve, of_share = (np.mean((p - found.are_real)[rows] ** 2) for p in (found.scores, curve, shares))
    hits, count = int(found.are_real[rows].sum()), int(rows.sum())
    low, high = wilson(hits, count)
    return (
        f"score {least:.2f} and more: {hits} of {count} real, {hits / count:.2f} [{low:.2f}, {high:.2f}]; Brier score "
        f"raw {raw:.3f}, curve {of_curve:.3f}, one share for all {of_share:.3f}"
    )


def people_table(found: Candidates, kept_from: float) -> str:
    """Return the table of people; kept_from is the score from which the back end would have kept them."""
    curve = left_out(found)
    lines = ["score       people  real double false   share real [90 %]    curve of the other photos"]
    for low, high in itertools.pairwise(_EDGES):
        rows = (found.scores >= low) & ((found.scores < high) | (high == 1.0))
        count, hits = int(rows.sum()), int(found.are_real[rows].sum())
        if count == 0:
            continue
        doubles, false = (int((found.what[rows] == kind).sum()) for kind in ("double", "false"))
        interval = "[{:.2f}, {:.2f}]".format(*wilson(hits, count))
        lines.append(
            f"{low:.1f} to {high:.1f} {count:7d} {hits:6d} {doubles:6d} {false:5d}      {hits / count:4.2f} {interval}"
            f"            {curve[rows].mean():.2f}"
        )
    lines.extend(brier_line(found, curve, least) for least in (0.0, kept_from))
    bias, slope = logistic_curve(found.scores, found.are_real)
    lines.append(f"curve of all photos: 1 / (1 + exp({-bias:.2f} - {slope:.2f} score))")
    return "\n".join(lines)


def shoulder_errors(seen: Sequence[People], labels: Sequence[Mapping[str, Any]]) -> FloatArray:
    """Return score and error of the shoulders' middle, shape (N, 2), in head-to-shoulder lengths."""
    rows: list[tuple[float, float]] = []
    for people, label in zip(seen, labels, strict=True):
        heads, necks, scores = people.part("Head"), people.joint("neck"), people.joint_score("neck")
        for person in label["people"]:
            size = float(np.linalg.norm(np.subtract(person["head"], person["mid_shoulder"])))
            gaps = np.nan_to_num(np.linalg.norm(heads - person["head"], axis=1), nan=np.inf)
            if size == 0 or not len(gaps) or gaps.min() > size:
                continue
            row = int(gaps.argmin())
            error = float(np.linalg.norm(necks[row] - person["mid_shoulder"])) / size
            if np.isfinite(error):
                rows.append((float(scores[row]), error))
    return np.array(rows).reshape(-1, 2)


def joint_table(errors: FloatArray) -> str:
    """Return the table of the shoulders' middle."""
    lines = ["shoulders   people   median error   within half the way [90 %]"]
    for low, high in itertools.pairwise(_EDGES):
        off = errors[(errors[:, 0] >= low) & ((errors[:, 0] < high) | (high == 1.0)), 1]
        if len(off):
            hits = int((off < 0.5).sum())
            interval = "[{:.2f}, {:.2f}]".format(*wilson(hits, len(off)))
            lines.append(
                f"{low:.1f} to {high:.1f} {len(off):7d} {np.median(off):14.2f}   {hits / len(off):6.2f} {interval}"
            )
    return "\n".join(lines)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    add_models_option(parser)
    parser.add_argument("--pose", required=True)
    parser.add_argument("--effort", default="normal")
    parser.add_argument("--least", type=float, default=0.05)
    args = parser.parse_args()
    labelled = json.loads((args.photos / "people.json").read_text())["images"]
    backend, kept_from = loosened(args.pose, PoseOptions(effort=args.effort), args.least)
    seen = [backend.detect(Photo.open(args.photos / name)) for name in labelled]
    print(f"{args.pose} {args.effort}, {len(labelled)} photos, thresholds at {args.least}")
    print(people_table(candidates(seen, list(labelled.values())), kept_from))
    print(joint_table(shoulder_errors(seen, list(labelled.values()))))


if __name__ == "__main__":
    main()
