"""Agreement of found people with hand-labelled joints: PCK, and lengths relative to the labels'."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.networks.labelled_people import LabelledPerson, labelled_pictures
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo

#: A person is a label's where the trunk's joints lie within this of it on average, in torsos.
_SAME = 0.5
_TRUNK = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")
#: A pair shorter than this in the labels, in torsos, is seen from its end and has no ratio.
_SHORTEST = {"shoulder": 0.3, "hip": 0.2, "ear": 0.1}


@dataclass
class JointErrors:
    """What all labelled people say: errors in torsos, and ratios of found to labelled lengths by pair."""

    labels: int = 0
    found: int = 0
    errors: list[float] = field(default_factory=list)
    ratios: dict[str, list[float]] = field(default_factory=dict)

    def cells(self) -> list[str]:
        """Return the table's cells: people found, PCK@.1, PCK@.2, and the median ratios."""
        errors = np.array(self.errors)
        shares = [f"{(errors < reach).mean():.2f}" if len(errors) else "" for reach in (0.1, 0.2)]
        medians = [f"{np.median(self.ratios[p]):.2f}" if self.ratios.get(p) else "" for p in ("torso", *_SHORTEST)]
        return [f"{self.found} of {self.labels}", *shares, " / ".join(medians)]


def joint_errors(backend: PoseBackend, folder: Path) -> JointErrors:
    """Return how a back end does on the labelled people who show shoulders and hips."""
    total = JointErrors()
    for picture in labelled_pictures(folder):
        labels = [person for person in picture.people if person.torso_px > 0]
        if labels and picture.path.is_file():
            people = backend.detect(Photo.open(picture.path))
            total.labels += len(labels)
            for row, label in _matched(people, labels):
                total.found += 1
                _count(total, people, row, label)
    return total


def _matched(people: People, labels: Sequence[LabelledPerson]) -> list[tuple[int, LabelledPerson]]:
    pairs: list[tuple[float, int, int]] = []
    for j, label in enumerate(labels):
        gaps = np.stack([np.linalg.norm(people.joint(n) - label.joints_px[n], axis=1) for n in _TRUNK])
        seen = np.isfinite(gaps).sum(axis=0) >= 2
        mean = np.where(seen, np.nansum(gaps, axis=0) / np.maximum(np.isfinite(gaps).sum(axis=0), 1), np.inf)
        pairs += [(float(g) / label.torso_px, i, j) for i, g in enumerate(mean) if g < _SAME * label.torso_px]
    taken: dict[int, int] = {}
    for _, i, j in sorted(pairs):
        if i not in taken and j not in taken.values():
            taken[i] = j
    return [(i, labels[j]) for i, j in taken.items()]


def _count(total: JointErrors, people: People, row: int, label: LabelledPerson) -> None:
    at = {name: people.joint(name)[row] for name in people.skeleton.joints}
    for name, point in label.joints_px.items():
        if name in at:  # a joint that was not found is as wrong as can be
            error = float(np.linalg.norm(at[name] - point)) / label.torso_px
            total.errors.append(error if np.isfinite(error) else np.inf)
    torso = (people.joint("neck") - people.joint("mid_hip"))[row]
    lengths = {"torso": float(np.linalg.norm(torso)) / label.torso_px}
    for pair, shortest in _SHORTEST.items():
        left, right = f"left_{pair}", f"right_{pair}"
        if left in label.joints_px and right in label.joints_px:
            labelled = float(np.linalg.norm(label.joints_px[left] - label.joints_px[right]))
            if labelled > shortest * label.torso_px:
                lengths[pair] = float(np.linalg.norm(people.joint(left)[row] - people.joint(right)[row])) / labelled
    for pair, ratio in lengths.items():
        if np.isfinite(ratio):
            total.ratios.setdefault(pair, []).append(ratio)
