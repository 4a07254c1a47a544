"""The four estimators of Seker et al. 2021, section 4: `shoulder`, `pupil`, `torso`, `combined`.

Each person is placed from one body length that is assumed parallel to the sensor and as long as an average adult's:
d = f D_w / D_i (eqs. 5-7), and the position is the middle of the pair at that depth (eqs. 8, 9). `combined` takes, for
each person, the position nearest to the camera. Their numbers are kept as published, biases included: the torso
constant is 8-10 % shorter than detectors see torsos, and nothing corrects for a pitched camera or a turned body.

The intervals are ours: the spread of the length in the population, how far the constant may be off for the detector's
joints (shared by all people in the photo), the angle to the sensor, keypoint noise, and the focal length (shared).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FloatArray
from ..bodies import Bodies
from ..camera import Camera, Mount
from ..people import People
from . import LocateSettings

CUES = ("torso", "shoulder", "pupil")


@dataclass(frozen=True)
class Cue:
    """One body length and the relative standard deviations of the depth that it gives.

    population: of the length among adults (ANSUR II, half women, half men). constant: how far the paper's constant may
    lie from the length between the joints that a detector marks. angle: foreshortening by posture and heading, the root
    mean square of 1 - cos h: bodies face anywhere, faces that show both eyes are turned by up to 60 degrees.
    above_m: how far the middle of the pair lies above the middle of the torso, which is where a person is.
    """

    length_m: float
    population: float
    constant: float
    angle: float
    above_m: float


#: Lengths: Seker et al. 2021. Relative standard deviations (docs/method.md, "The paper's four estimators"): ANSUR II's
#: of the population, of the constant on a detector's joints, and of the angle to the sensor. above_m: from ANSUR II's
#: means.
_CUES = {
    "torso": Cue(length_m=0.444, population=0.078, constant=0.08, angle=0.05, above_m=0.0),
    "shoulder": Cue(length_m=0.389, population=0.080, constant=0.08, angle=0.48, above_m=0.255),
    "pupil": Cue(length_m=0.063, population=0.059, constant=0.03, angle=0.23, above_m=0.48),
}
#: The published code's torso, and its largest ratio of neck to one shoulder and to the other.
_CODE_TORSO_M = 0.4445
_SHOULDER_RATIO = 1.25
#: Far eye to the one visible ear over the distance of the pupils, in the published code.
_EYE_EAR_RATIO = 1.95
#: A keypoint's noise: a floor in pixels, and a share of what half a metre of body is in pixels.
_NOISE_FLOOR_PX, _NOISE_SHARE = 0.7, 0.015

_UNSEEN = {
    "torso": "neck and hips are not both visible",
    "shoulder": "the shoulders are not both visible, or the body is turned too far",
    "pupil": "the face is not turned to the camera with both eyes visible",
    "combined": "none of torso, shoulders and eyes is visible as a pair",
}


def locate_torso(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Place people by neck to mid-hip, 444 mm."""
    return _locate("torso", ("torso",), people, camera, settings)


def locate_shoulder(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Place people by the shoulders, 389 mm; refused where the two halves differ by more than 1.25 times."""
    return _locate("shoulder", ("shoulder",), people, camera, settings)


def locate_pupil(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Place people by the pupils, 63 mm; only faces that look towards the camera."""
    return _locate("pupil", ("pupil",), people, camera, settings)


def locate_combined(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Place each person by whichever of the three lengths puts them nearest to the camera."""
    return _locate("combined", CUES, people, camera, settings)


def _locate(method: str, cues: tuple[str, ...], people: People, camera: Camera, settings: LocateSettings) -> Bodies:
    camera = camera.without_distortion()
    lengths = {cue: _MEASURES[cue](people, camera, settings.quirks) for cue in CUES}
    constants = {cue: _length_m(cue, settings.quirks) for cue in CUES}
    places = np.stack([_positions(*lengths[cue], constants[cue], settings.quirks) for cue in cues])  # (C, P, 3)
    reach = np.linalg.norm(places, axis=-1)
    reach = np.where(np.isnan(reach), np.inf, reach)
    nearest = reach.argmin(axis=0)
    placed = np.isfinite(reach.min(axis=0, initial=np.inf))
    rows = np.arange(len(people))
    positions = np.where(placed[:, None], places[nearest, rows], np.nan)
    chosen = tuple(cues[n] if ok else "" for n, ok in zip(nearest, placed, strict=True))
    size_px = _half_metre_px(lengths, camera)
    return Bodies(
        positions_m=positions,
        covariance_m2=_covariance(positions, chosen, lengths, size_px, camera),
        method=method,
        basis=chosen,
        reasons=tuple(None if ok else _UNSEEN[method] for ok in placed),
    )


def _length_m(cue: str, quirks: frozenset[str]) -> float:
    if cue == "torso" and "code-torso-length" in quirks:
        return _CODE_TORSO_M
    return _CUES[cue].length_m


#: Per person the middle of a pair as a ray (P, 3) and the pair's length at unit depth (P,), NaN where unseen.
Measure = tuple[FloatArray, FloatArray]


def _pair(a: FloatArray, b: FloatArray) -> Measure:
    return (a + b) / 2, np.linalg.norm(a - b, axis=-1)


def _measure_torso(people: People, camera: Camera, quirks: frozenset[str]) -> Measure:
    return _pair(camera.rays(people.joint("neck")), camera.rays(people.joint("mid_hip")))


def _measure_shoulder(people: People, camera: Camera, quirks: frozenset[str]) -> Measure:
    left, right = people.joint("left_shoulder"), people.joint("right_shoulder")
    middle, length = _pair(camera.rays(left), camera.rays(right))
    if people.skeleton.index("neck") is None:
        return middle, length  # the neck is the shoulders' middle by definition: the test would always pass
    neck = people.joint("neck")
    halves = np.stack([np.linalg.norm(left - neck, axis=-1), np.linalg.norm(right - neck, axis=-1)])
    refused = halves.max(axis=0) > _SHOULDER_RATIO * halves.min(axis=0)
    length = np.where(refused, np.nan, length)
    if "shoulder-counter" in quirks:
        # The counter stands still at a refused person: the next one is written into an earlier row.
        rows = np.arange(len(people)) - np.cumsum(refused) + refused
        shifted_middle, shifted_length = np.full_like(middle, np.nan), np.full_like(length, np.nan)
        kept = ~refused
        shifted_middle[rows[kept]], shifted_length[rows[kept]] = middle[kept], length[kept]
        return shifted_middle, shifted_length
    return middle, length


def _measure_pupil(people: People, camera: Camera, quirks: frozenset[str]) -> Measure:
    left, right = people.joint("left_eye"), people.joint("right_eye")
    left_ray, right_ray = camera.rays(left), camera.rays(right)
    middle, length = _pair(left_ray, right_ray)
    length = np.where(left[:, 0] > right[:, 0], length, np.nan)  # a face seen from the front: x16 > x15
    left_ear, right_ear = camera.rays(people.joint("left_ear")), camera.rays(people.joint("right_ear"))
    sees_left, sees_right = people.joint_score("left_ear") > 0, people.joint_score("right_ear") > 0
    by_left = np.linalg.norm(right_ray - left_ear, axis=-1) / _EYE_EAR_RATIO
    by_right = np.linalg.norm(left_ray - right_ear, axis=-1) / _EYE_EAR_RATIO
    turned = np.where(sees_left & ~sees_right, by_left, np.where(sees_right & ~sees_left, by_right, length))
    return middle, np.where(np.isnan(length), np.nan, turned)


_MEASURES = {"torso": _measure_torso, "shoulder": _measure_shoulder, "pupil": _measure_pupil}


def _positions(middle: FloatArray, length: FloatArray, length_m: float, quirks: frozenset[str]) -> FloatArray:
    """d = f D_w / D_i with D_i / f the pair's length at unit depth (eq. 7); position by eqs. 8 and 9."""
    with np.errstate(divide="ignore"):
        depth = np.where(length > 0, length_m / length, 0.0 if "zero-length" in quirks else np.nan)
    depth = np.where(np.isnan(length), np.nan, depth)
    return middle * depth[:, None]


def _half_metre_px(lengths: dict[str, Measure], camera: Camera) -> FloatArray:
    """Return how many pixels half a metre of each person's body is, by the cue that shows it largest."""
    unit = np.stack([np.nan_to_num(lengths[cue][1]) / _CUES[cue].length_m for cue in CUES])
    return 0.5 * camera.f_px * unit.max(axis=0)


def _covariance(
    positions: FloatArray, chosen: tuple[str, ...], lengths: dict[str, Measure], size_px: FloatArray, camera: Camera
) -> FloatArray:
    """Return the joint covariance (3P, 3P): own errors in blocks, the focal length's and the constants' across all."""
    count = len(chosen)
    covariance = np.full((3 * count, 3 * count), np.nan)
    rows = [i for i in range(count) if chosen[i]]
    if not rows:
        return covariance
    place = positions[rows]
    depth = place[:, 2]
    noise_px = np.hypot(_NOISE_FLOOR_PX, _NOISE_SHARE * size_px[rows])
    pair_px = camera.f_px * np.array([lengths[chosen[i]][1][i] for i in rows])
    with np.errstate(divide="ignore", invalid="ignore"):
        pair_rel = np.nan_to_num(np.sqrt(2) * noise_px / pair_px, nan=1.0, posinf=1.0)
    cue = [_CUES[chosen[i]] for i in rows]
    own_rel = np.sqrt(np.array([c.population**2 + c.angle**2 for c in cue]) + pair_rel**2)
    joint = np.zeros((len(rows), 3, len(rows), 3))
    for k in range(len(rows)):
        across = (depth[k] / camera.f_px) ** 2 * (noise_px[k] ** 2 / 2)
        joint[k, :, k, :] = own_rel[k] ** 2 * np.outer(place[k], place[k]) + across * np.eye(3)
    for name in CUES:  # a constant that is off scales all who are placed by it
        scale = np.where(np.array([chosen[i] == name for i in rows])[:, None], place * _CUES[name].constant, 0.0)
        joint += np.einsum("ia,jb->iajb", scale, scale)
    # The published places are those of the pairs: one person's eyes and another's torso are not at one height.
    above = np.zeros_like(place)
    for name in CUES:
        above[:, 1] = [_CUES[name].above_m if chosen[i] == name else 0.0 for i in rows]
        joint += np.einsum("ia,jb->iajb", above, above)
    focal = np.zeros_like(place)
    focal[:, 2] = camera.focal_rel_sd * depth  # X and Y do not depend on f: both d and 1/f scale
    principal = np.zeros((2, len(rows), 3))
    for axis in range(2):
        principal[axis, :, axis] = camera.principal_sd_px * depth / camera.f_px
    for shared in (focal, *principal):
        joint += np.einsum("ia,jb->iajb", shared, shared)
    index = np.concatenate([[3 * i, 3 * i + 1, 3 * i + 2] for i in rows])
    covariance[np.ix_(index, index)] = joint.reshape(3 * len(rows), 3 * len(rows))
    return covariance
