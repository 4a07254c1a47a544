"""The people that a pose back end saw in one photo, and what a back end is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..arrays import FloatArray
from ..errors import KeypointsError
from .attributes import Attributes, checked
from .rival import Rival
from .skeleton import MIDDLES, Skeleton

if TYPE_CHECKING:
    from ..photo import Photo


def _empty() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class People:
    """P people with K keypoints each, in pixels of the upright full-size photo.

    skeleton: which joint each keypoint is.
    keypoints_px: shape (P, K, 2); NaN where a joint was not seen.
    scores: shape (P, K), 0..1; 0 exactly where the keypoint is NaN.
    boxes_px: shape (P, 4) as x0, y0, x1, y1; around the keypoints where none is given.
    person_scores: shape (P,), 0..1; the mean keypoint score where none is given.
    heading_rad, heading_sd_rad: shape (P,); where each person's torso faces according to the back end, NaN
        if it gives none. 0 faces the viewer, positive turns towards the image's right. It is seen along the line
        of sight: a heading h of a person who stands at azimuth a, to the right of the camera's axis, faces
        (sin(h - a), 0, -cos(h - a)) in the camera frame.
    source: the name of the back end that saw them, for weighing joints (`keypoint_noise`); "" where it is unknown.
    depth_m, depth_sd_m: shape (P,); how far each person is along the camera's axis as another instrument measured it
    (an
        RGB-D camera, a lidar, a metric-depth network), and the standard deviation; NaN where none did. It is the
        depth of the body's middle: to a measured surface, add the distance to the middle (half a chest's depth,
        0.12 m, for a person seen from the front).
    attributes: what else the recording states about each person, by key (`attributes.attributes_of`).
    rivals: of each person, what else the detector sees in the same place; None where it sees nothing else or does not
        state it.
    framed: shape (P,); who lies inside a closed rectangle of straight edges in the photo, as in a picture's frame
        (`camera.lines.picture_frames`); no one where it was not looked for.

    Construction raises KeypointsError where shapes do not fit. A keypoint with score 0, a NaN score or a NaN
    coordinate is missing in all three arrays.
    """

    skeleton: Skeleton
    keypoints_px: FloatArray
    scores: FloatArray
    boxes_px: FloatArray = field(default_factory=_empty)
    person_scores: FloatArray = field(default_factory=_empty)
    heading_rad: FloatArray = field(default_factory=_empty)
    heading_sd_rad: FloatArray = field(default_factory=_empty)
    source: str = ""
    depth_m: FloatArray = field(default_factory=_empty)
    depth_sd_m: FloatArray = field(default_factory=_empty)
    attributes: Sequence[Attributes] = ()
    rivals: Sequence[Rival | None] = ()
    framed: Sequence[bool] = ()

    def __repr__(self) -> str:
        return f"People({len(self.keypoints_px)} with {len(self.skeleton)} keypoints, {self.skeleton.name})"

    def __post_init__(self) -> None:
        if not isinstance(cast(object, self.skeleton), Skeleton):
            raise KeypointsError(f"people need a Skeleton, as SKELETONS['coco17'] is one, not {self.skeleton!r:.40}")
        keypoints, scores = _numbers("keypoints_px", self.keypoints_px), _numbers("scores", self.scores)
        count, joints = len(keypoints) if keypoints.ndim == 3 else 0, len(self.skeleton)
        if keypoints.size == 0:
            keypoints = keypoints.reshape(count, joints, 2)
        if keypoints.shape != (count, joints, 2):
            raise KeypointsError(
                f"people of skeleton {self.skeleton.name} need keypoints of shape (P, {joints}, 2), "
                f"not {keypoints.shape}"
            )
        scores = scores.reshape(count, joints) if scores.size == keypoints.size == 0 else scores
        if scores.shape != (count, joints):
            raise KeypointsError(
                f"{count} people of skeleton {self.skeleton.name} need scores of shape ({count}, {joints}), "
                f"not {scores.shape}"
            )
        missing = ~np.isfinite(keypoints).all(axis=-1) | ~(scores > 0)
        keypoints[missing], scores[missing] = np.nan, 0.0
        self._set("keypoints_px", keypoints, keypoints.shape)
        self._set("scores", scores, scores.shape)
        self._set("boxes_px", self.boxes_px if np.size(self.boxes_px) else _bounds(keypoints), (count, 4))
        self._set(
            "person_scores",
            self.person_scores if np.size(self.person_scores) else _mean_score(scores),
            (count,),
        )
        for name in ("heading_rad", "heading_sd_rad", "depth_m", "depth_sd_m"):
            value = getattr(self, name)
            self._set(name, value if np.size(value) else np.full(count, np.nan), (count,))
        self._check_depth()
        object.__setattr__(self, "attributes", checked(self.attributes, count))
        if len(self.rivals) not in (0, count):
            raise KeypointsError(f"people.rivals has {len(self.rivals)} entries for {count} people")
        object.__setattr__(self, "rivals", tuple(self.rivals) or (None,) * count)
        if len(self.framed) not in (0, count):
            raise KeypointsError(f"people.framed has {len(self.framed)} entries for {count} people")
        object.__setattr__(self, "framed", tuple(map(bool, self.framed)) or (False,) * count)

    def _check_depth(self) -> None:
        depth, sd = self.depth_m, self.depth_sd_m
        if (np.isfinite(depth) != np.isfinite(sd)).any():
            raise KeypointsError(
                "a person's depth needs its standard deviation, in metres both, and the other way round"
            )
        if (depth <= 0).any() or (sd <= 0).any() or np.isinf(depth).any() or np.isinf(sd).any():
            raise KeypointsError("a person's depth and its standard deviation are metres above 0")

    def __iter__(self) -> Iterator[People]:
        return (self[row] for row in range(len(self)))

    def _set(self, name: str, value: ArrayLike, shape: tuple[int, ...]) -> None:
        array = np.array(value, dtype=float)
        if array.size == 0:
            array = array.reshape(shape) if 0 in shape else array
        if array.shape != shape:
            raise KeypointsError(f"people.{name} must have shape {shape}, not {array.shape}")
        array.setflags(write=False)
        object.__setattr__(self, name, array)

    @classmethod
    def none(cls, skeleton: Skeleton) -> People:
        """Return no people."""
        return cls(skeleton, np.zeros((0, len(skeleton), 2)), np.zeros((0, len(skeleton))))

    def __len__(self) -> int:
        return len(self.keypoints_px)

    def __getitem__(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice | list[int] | int) -> People:
        if isinstance(rows, int | np.integer):
            rows = [range(len(self))[rows]]  # one person is people too; beyond the last is an IndexError
        return People(
            self.skeleton, self.keypoints_px[rows], self.scores[rows], self.boxes_px[rows], self.person_scores[rows],
            self.heading_rad[rows], self.heading_sd_rad[rows], self.source, self.depth_m[rows], self.depth_sd_m[rows],
            [self.attributes[i] for i in np.arange(len(self))[rows]],
            [self.rivals[i] for i in np.arange(len(self))[rows]],
            [self.framed[i] for i in np.arange(len(self))[rows]],
        )  # fmt: skip

    def joint(self, name: str) -> FloatArray:
        """Return the pixels of one joint, shape (P, 2), NaN where it was not seen or the skeleton has none.

        "neck" and "mid_hip" are the middles of the shoulders and of the hips where the skeleton has none.
        """
        row = self.skeleton.index(name)
        if row is not None:
            return self.keypoints_px[:, row]
        if name in MIDDLES:
            a, b = MIDDLES[name]
            return (self.joint(a) + self.joint(b)) / 2
        return np.full((len(self), 2), np.nan)

    def joint_score(self, name: str) -> FloatArray:
        """Return the scores of one joint, shape (P,); a middle has the lower score of its pair, an absent one 0."""
        row = self.skeleton.index(name)
        if row is not None:
            return self.scores[:, row]
        if name in MIDDLES:
            a, b = MIDDLES[name]
            return np.minimum(self.joint_score(a), self.joint_score(b))
        return np.zeros(len(self))

    def part(self, name: str) -> FloatArray:
        """Return the pixels of one of the benchmark's parts, shape (P, 2), NaN where unseen (see `skeleton.PARTS`).

        Eyes: middle of both eyes, or the one that is seen. Shoulder: middle of the shoulders, or the one that is seen.
        Torso: middle of neck and mid-hip. Head: middle of the ears, else the mean of what is seen of nose, eyes and
        ears. Raises KeyError for any other name.
        """
        return self._parts[name]

    @cached_property
    def _parts(self) -> dict[str, FloatArray]:
        """Made once: the table of people asks for every part of every person."""
        shoulders = (self.joint("left_shoulder") + self.joint("right_shoulder")) / 2
        ears = (self.joint("left_ear") + self.joint("right_ear")) / 2
        face = self._mean_of("nose", "left_eye", "right_eye", "left_ear", "right_ear")
        parts = {
            "Eyes": _first_seen(self.joint("eyes_centre"), self._mean_of("left_eye", "right_eye")),
            "Shoulder": _first_seen(shoulders, self.joint("neck"), self._mean_of("left_shoulder", "right_shoulder")),
            "Torso": (self.joint("neck") + self.joint("mid_hip")) / 2,
            "Head": _first_seen(self.joint("head_centre"), ears, face),
        }
        for points in parts.values():
            points.setflags(write=False)
        return parts

    def _mean_of(self, *joints: str) -> FloatArray:
        points = np.stack([self.joint(j) for j in joints])
        seen = np.asarray(np.isfinite(points).all(axis=-1))
        total = np.where(seen[..., None], points, 0.0).sum(axis=0)
        count = seen.sum(axis=0)[:, None]
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def scaled(self, factor_x: float, factor_y: float) -> People:
        """Return the same people in a photo resized by these factors."""
        factors = np.array([factor_x, factor_y])
        return replace(self, keypoints_px=self.keypoints_px * factors, boxes_px=self.boxes_px * np.tile(factors, 2))

    def mirrored(self, width: float) -> People:
        """Return the same people in a photo of `width` pixels flipped left to right, with left and right exchanged."""
        order = list(self.skeleton.mirror)
        keypoints = self.keypoints_px[:, order] * (-1, 1) + (width, 0)
        boxes = self.boxes_px[:, [2, 1, 0, 3]] * (-1, 1, -1, 1) + (width, 0, width, 0)
        return replace(
            self,
            keypoints_px=keypoints,
            scores=self.scores[:, order],
            boxes_px=boxes,
            heading_rad=-self.heading_rad,
        )


def _numbers(name: str, values: ArrayLike) -> FloatArray:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise KeypointsError(f"people.{name} must be numbers ({error})") from error


def _bounds(keypoints: FloatArray) -> FloatArray:
    """Return the boxes around the keypoints that were seen, shape (P, 4), NaN where there are none."""
    seen = np.isfinite(keypoints)
    low = np.where(seen, keypoints, np.inf).min(axis=1, initial=np.inf)
    high = np.where(seen, keypoints, -np.inf).max(axis=1, initial=-np.inf)
    boxes = np.concatenate([low, high], axis=-1)
    return np.where(np.isfinite(boxes), boxes, np.nan)


def _mean_score(scores: FloatArray) -> FloatArray:
    seen = np.maximum((scores > 0).sum(axis=1), 1)
    return scores.sum(axis=1) / seen


def _first_seen(*candidates: FloatArray) -> FloatArray:
    result = candidates[0]
    for candidate in candidates[1:]:
        result = np.where(np.isfinite(result), result, candidate)
    return result


class PoseBackend(Protocol):
    """What finds people: anything with these attributes and this call.

    `name` is how options call it, `models` maps each network's file name to its sha256 (empty where there is none).
    `detect` returns people in pixels of the upright full-size photo, each person once, and leaves its input untouched;
    a photo without people gives an empty `People`, never a guess.
    """

    @property
    def name(self) -> str:
        """How options call it."""
        ...

    @property
    def skeleton(self) -> Skeleton:
        """The joints that it finds."""
        ...

    @property
    def models(self) -> Mapping[str, str]:
        """Network file names and their sha256."""
        ...

    def detect(self, photo: Photo) -> People:
        """Return the people in a photo."""
        ...
