"""A user's own detector: a Python callable as a back end, and its answer, whatever its shape, as People."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..errors import KeypointsError, SettingsError
from ..files import sha256_of
from ..people import People
from ..people.skeleton import COCO_17, Skeleton
from ..photo import Photo
from . import PoseOptions
from .bare_arrays import BY_COUNT, are_fractions, skeleton_of


class CallableBackend:
    """A user's function as a back end: it gets RGB pixels of shape (H, W, 3), uint8, and answers in their pixels.

    The answer may be `People`, a `supervision.KeyPoints`, an Ultralytics result, an MMPose sample, an array of shape
    (P, K, 2) or (P, K, 3) with scores last, or a pair of keypoints (P, K, 2) and scores (P, K). The skeleton follows
    from K unless it is stated.
    """

    def __init__(
        self, function: Callable[[NDArray[np.uint8]], Any], skeleton: Skeleton | None = None, name: str | None = None
    ) -> None:
        self.function = function
        self.name = name or f"python:{getattr(function, '__name__', type(function).__name__)}"
        self.skeleton = skeleton or COCO_17
        self.models: Mapping[str, str] = MappingProxyType({})
        self._stated = skeleton

    def detect(self, photo: Photo) -> People:
        """Return the people that the function sees; raises KeypointsError where its answer has no known shape."""
        pixels = photo.pixels()
        people = people_from(self.function(pixels), self._stated, self.name)
        height, width = pixels.shape[:2]
        return people.scaled(photo.width / width, photo.height / height)


def open_backend(argument: str, options: PoseOptions) -> CallableBackend:
    """Return the back end of `python:MODULE:FUNCTION`; raises SettingsError where there is no such function.

    The module may lie in the current folder, which an installed command does not look into by itself; it comes last,
    so that no file there takes the place of a package.
    """
    module, _, attribute = argument.partition(":")
    if (here := str(Path.cwd())) not in sys.path:
        sys.path.append(here)
    try:
        found = importlib.import_module(module)
        function = getattr(found, attribute)
    except (ImportError, AttributeError, ValueError) as error:
        raise SettingsError(f"--pose python:{argument}: {error}; write python:MODULE:FUNCTION") from error
    if not callable(function):
        raise SettingsError(f"--pose python:{argument}: it is not a function")
    backend = CallableBackend(function, name=f"python:{argument}")
    file = getattr(found, "__file__", None)
    if file:  # a run must not continue with what is another function by now
        backend.models = MappingProxyType({Path(file).name: sha256_of(Path(file))})
    return backend


def people_from(answer: object, skeleton: Skeleton | None = None, origin: str = "the detector") -> People:
    """Return what a detector answered as People; the forms are those of `CallableBackend`.

    A keypoint at exactly (0, 0) or with score 0 is missing: that is how these libraries write it.
    Raises KeypointsError, naming `origin`, where the form or the number of keypoints is unknown.
    """
    if isinstance(answer, People):
        return answer
    keypoints, scores, boxes, person_scores = _arrays(answer, origin)
    if keypoints.size == 0:
        return People.none(skeleton or BY_COUNT.get(keypoints.shape[-2] if keypoints.ndim == 3 else 0, COCO_17))
    if keypoints.ndim != 3 or keypoints.shape[2] not in (2, 3):
        raise KeypointsError(f"{origin}: keypoints must have shape (P, K, 2) or (P, K, 3), not {keypoints.shape}")
    if keypoints.shape[2] == 3 and scores is None:
        scores = keypoints[..., 2]
    keypoints = keypoints[..., :2]
    if skeleton is None and (skeleton := skeleton_of(keypoints.shape[1])) is not None:
        keypoints, scores = keypoints[:, : len(skeleton)], None if scores is None else scores[:, : len(skeleton)]
    if are_fractions(keypoints):
        raise KeypointsError(f"{origin}: coordinates are fractions, not pixels: multiply them by the photo's size")
    if skeleton is None or len(skeleton) != keypoints.shape[1]:
        raise KeypointsError(f"{origin}: {keypoints.shape[1]} keypoints fit no known skeleton; state which")
    if scores is None:
        scores = np.ones(keypoints.shape[:2])
    if scores.shape != keypoints.shape[:2]:
        raise KeypointsError(f"{origin}: scores must have shape {keypoints.shape[:2]}, not {scores.shape}")
    missing = (keypoints == 0).all(axis=-1)
    scores = np.where(missing, 0.0, np.clip(scores, 0.0, 1.0))
    return People(skeleton, keypoints, scores, _or_empty(boxes), _or_empty(person_scores))


def _arrays(answer: object, origin: str) -> tuple[FloatArray, FloatArray | None, FloatArray | None, FloatArray | None]:
    """Return keypoints, scores, boxes and person scores of an answer, by what it has and not by what it is."""
    if hasattr(answer, "pred_instances"):  # MMPose: PoseDataSample
        found: Any = answer.pred_instances  # type: ignore[attr-defined]
        return (
            _array(found.keypoints), _array(found.keypoint_scores), _optional(found, "bboxes"),
            _optional(found, "bbox_scores"),
        )  # fmt: skip
    if hasattr(answer, "keypoints") and hasattr(answer, "boxes"):  # Ultralytics: Results
        points: Any = answer.keypoints  # type: ignore[attr-defined]
        boxes: Any = answer.boxes  # type: ignore[attr-defined]
        if points is None:
            raise KeypointsError(f"{origin}: the result has boxes but no keypoints; use a pose model")
        return _array(points.xy), _optional(points, "conf"), _optional(boxes, "xyxy"), _optional(boxes, "conf")
    if hasattr(answer, "xy"):  # supervision: KeyPoints, older and newer spelling
        newer = hasattr(answer, "keypoint_confidence")  # the older name warns there before it goes
        scores = _optional(answer, "keypoint_confidence" if newer else "confidence")
        visible = _optional(answer, "visible")  # what its user has filtered out
        if visible is not None:
            scores = visible if scores is None else scores * visible
        return _array(answer.xy), scores, None, _optional(answer, "detection_confidence")  # type: ignore[attr-defined]
    if isinstance(answer, (tuple, list)) and len(answer) == 2 and np.ndim(_array(answer[0])) == 3:
        return _array(answer[0]), _array(answer[1]), None, None
    try:
        return _array(answer), None, None, None
    except (TypeError, ValueError) as error:
        raise KeypointsError(f"{origin}: an answer of type {type(answer).__name__} is not understood") from error


def _array(value: Any) -> FloatArray:
    """Return numbers as an array, wherever a tensor library keeps them."""
    for method in ("detach", "cpu", "numpy"):
        value = getattr(value, method)() if hasattr(value, method) else value
    return np.asarray(value, dtype=float)


def _optional(owner: object, name: str) -> FloatArray | None:
    value = getattr(owner, name, None)
    return None if value is None else _array(value)


def _or_empty(value: FloatArray | None) -> FloatArray:
    return np.zeros(0) if value is None else value
