"""Two candidates for one person: which pairs are the same, and which of them stays."""

from __future__ import annotations

import numpy as np

from ...arrays import FloatArray
from ...overlap import keypoint_similarity, sigmas_of
from ...people.skeleton import BLAZEPOSE_33, COCO_17
from .landmarks import Candidate

_COCO = np.array([BLAZEPOSE_33.joints.index(joint) for joint in COCO_17.joints])
_SIGMAS = sigmas_of(COCO_17.joints)
_NOSE, _EARS, _SHOULDERS, _HIPS = [0], [7, 8], [11, 12], [23, 24]
_FACE = [0, 2, 5, 7, 8]

# Two people side by side have a keypoint similarity near 0, two passes over one person above 0.6; a torso whose points
# lie mostly in the other's silhouette belongs to the other. Set between what was seen of either in labelled photos.
_SAME_POSE, _INSIDE = 0.45, 0.6
# The same head and shoulders: middles nearer than these shares of the larger torso. A body in the other's silhouette is
# the other's unless it is as large (`_AS_LARGE`) and its head elsewhere (`_HEAD_ELSEWHERE`); one that holds the other's
# silhouette where the heads are near (`_HEAD_NEAR`). Set by hand; the labelled people of `tests/test_blazepose.py` hold
# that they lose no person and double none.
_SAME_HEAD, _SAME_SHOULDERS = 0.25, 0.45
_AS_LARGE, _HEAD_ELSEWHERE, _HEAD_NEAR = 0.85, 0.5, 0.6
# In torsos (METHOD section 4: shoulders to hips .5 m): from a joint to the skin, and from the eyes to the crown.
_FLESH, _CROWN = 0.1, 0.35
# Of ten points of head and torso more than eight in the silhouettes of surer people: a mix of these people's parts.
_MIXED = 0.8


def torso_px(candidate: Candidate) -> float:
    """Return the length of the torso, or the shoulders' breadth where that is longer (a person seen from above)."""
    points = candidate.keypoints_px
    length = np.linalg.norm(points[_SHOULDERS].mean(axis=0) - points[_HIPS].mean(axis=0))
    return float(max(length, np.linalg.norm(points[11] - points[12]), 1.0))


def head_px(candidate: Candidate) -> FloatArray:
    """Return the middle of the nose, eyes and ears, shape (2,)."""
    return candidate.keypoints_px[_FACE].mean(axis=0)


def extent_px(candidate: Candidate) -> FloatArray:
    """Return the box (4,) that the body fills: its joints', with flesh around them and the crown above the face."""
    torso = torso_px(candidate)
    low = candidate.keypoints_px.min(axis=0) - _FLESH * torso
    high = candidate.keypoints_px.max(axis=0) + _FLESH * torso
    low[1] = min(low[1], head_px(candidate)[1] - _CROWN * torso)
    return np.concatenate([low, high])


def are_same(a: Candidate, b: Candidate) -> bool:
    """Return whether two candidates are the same person."""
    size_a, size_b = torso_px(a), torso_px(b)
    larger, smaller = max(size_a, size_b), min(size_a, size_b)
    heads = np.linalg.norm(head_px(a) - head_px(b))
    shoulders = np.linalg.norm(a.keypoints_px[_SHOULDERS].mean(axis=0) - b.keypoints_px[_SHOULDERS].mean(axis=0))
    if similarity(a, b) > _SAME_POSE or (heads < _SAME_HEAD * larger and shoulders < _SAME_SHOULDERS * larger):
        return True
    if _share_inside(a, b) > _INSIDE and (smaller / larger < _AS_LARGE or heads < _HEAD_ELSEWHERE * larger):
        return True
    return _share_inside(b, a) > _INSIDE and bool(heads < _HEAD_NEAR * larger)


def is_among(candidate: Candidate, surer: list[Candidate]) -> bool:
    """Return whether a candidate is the same as one of surer people, or a mix of several."""
    return any(are_same(candidate, other) for other in surer) or _is_mixed(candidate, surer)


def agree(first: Candidate, second: Candidate) -> bool:
    """Return whether two looks show the same pose."""
    return similarity(first, second) > _SAME_POSE


def _is_mixed(candidate: Candidate, surer: list[Candidate]) -> bool:
    if len(surer) < 2:
        return False
    return bool(np.max([_inside(candidate, other) for other in surer], axis=0).mean() > _MIXED)


def similarity(a: Candidate, b: Candidate) -> float:
    """Return the object keypoint similarity of the 17 common joints, weighted by visibility."""
    area = np.array((2.2 * min(torso_px(a), torso_px(b))) ** 2)  # a body's, in torsos
    weights = np.minimum(a.visibility, b.visibility)[_COCO] + 1e-3
    squared = ((a.keypoints_px - b.keypoints_px)[_COCO] ** 2).sum(axis=1)
    return float(keypoint_similarity(squared, area, _SIGMAS, weights))


def _share_inside(a: Candidate, b: Candidate) -> float:
    """Return the share of a's head and torso points that lie in b's silhouette."""
    return float(_inside(a, b).mean())


def _inside(a: Candidate, b: Candidate) -> FloatArray:
    """Return b's silhouette, 0..1, at ten points of a's head and torso."""
    points = a.keypoints_px
    shoulders, hips = points[_SHOULDERS], points[_HIPS]
    middles = np.stack([shoulders.mean(axis=0), hips.mean(axis=0), np.concatenate([shoulders, hips]).mean(axis=0)])
    tested = np.concatenate([points[_NOSE], points[_EARS], shoulders, hips, middles])
    assert b.mask is not None  # only second looks are compared, and those draw it
    side = b.mask.shape[0]
    cells = np.floor(b.region.from_photo(tested) * side).astype(int)
    inside = ((cells >= 0) & (cells < side)).all(axis=1)
    cells = np.clip(cells, 0, side - 1)
    return np.where(inside, b.mask[cells[:, 1], cells[:, 0]], 0.0)
