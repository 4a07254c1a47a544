"""The JSON form of what a scene is made of: camera, people and bodies as dictionaries, and back."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from .arrays import FloatArray
from .bodies import Bodies, Floor, Intrinsics, Mode
from .camera import Camera, CameraEstimate, Candidate, Flag, Mount, Source, Testimony
from .people import People
from .people.rival import Rival
from .people.skeleton import SKELETONS, Skeleton, skeleton_named

_DIGITS = 7
#: Rows of a covariance that is written as numbers: of 300 people.
_MOST_AS_NUMBERS = 900


def _numbers(array: FloatArray) -> list[Any]:
    """Return an array as nested lists of 7 significant digits, NaN as None."""
    flat = [float(f"{v:.{_DIGITS}g}") if math.isfinite(v) else None for v in array.ravel()]
    for size in reversed(array.shape[1:]):
        flat = [flat[i : i + size] for i in range(0, len(flat), size)] if size else []
    return flat


def _array(values: list[Any], *shape: int) -> FloatArray:
    return np.array(values, dtype=float).reshape(shape)


def _triangle(covariance: FloatArray) -> list[Any] | str:
    """Return a covariance's lower triangle: as numbers, or of a crowd, which has millions, as base64 of float32."""
    triangle = covariance[np.tril_indices(len(covariance))]
    if len(covariance) > _MOST_AS_NUMBERS:
        return base64.b64encode(triangle.astype("<f4").tobytes()).decode()
    return _numbers(triangle)


def _from_triangle(values: list[Any] | str, size: int) -> FloatArray:
    covariance = np.zeros((size, size))
    triangle = np.frombuffer(base64.b64decode(values), "<f4") if isinstance(values, str) else values
    covariance[np.tril_indices(size)] = np.array(triangle, dtype=float)
    return covariance + np.tril(covariance, -1).T


def none_if_nan(value: float) -> float | None:
    """Return a number for JSON, which knows no NaN."""
    return value if math.isfinite(value) else None


def camera_to_dict(estimate: CameraEstimate) -> dict[str, Any]:
    """Return a camera estimate for JSON."""
    return {
        "camera": asdict(estimate.camera) if estimate.camera else None,
        "candidates": [asdict(c) for c in estimate.candidates],
        "flags": [asdict(f) for f in estimate.flags],
        "reason": estimate.reason,
        "lens": estimate.lens,
        "mount": None if estimate.mount is None else estimate.mount.to_dict(),
        "why": estimate.why,
        "testimony": [asdict(t) for t in estimate.testimony],
    }


def camera_from_dict(fields: Mapping[str, Any]) -> CameraEstimate:
    """Read what `camera_to_dict` wrote; raises KeyError, ValueError or TypeError for anything else."""
    camera = fields["camera"]
    return CameraEstimate(
        Camera(**_with_source(camera)) if camera else None,
        tuple(Candidate(**_with_source(c)) for c in fields["candidates"]),
        tuple(map(Flag.from_dict, fields["flags"])),
        fields["reason"],
        fields.get("lens"),
        Mount.from_dict(fields["mount"]) if fields.get("mount") else None,
        fields.get("why") or "",
        tuple(map(Testimony.from_dict, fields.get("testimony", ()))),
    )


def _with_source(fields: Mapping[str, Any]) -> dict[str, Any]:
    return {**fields, "source": Source.from_dict(fields["source"])}


def people_to_dict(people: People) -> dict[str, Any]:
    """Return people for JSON; what they all lack is left out."""
    arrays = ("keypoints_px", "scores", "boxes_px", "person_scores", "heading_rad", "heading_sd_rad")
    skeleton: dict[str, Any] = {"skeleton": people.skeleton.name}
    if people.skeleton != SKELETONS.get(people.skeleton.name):
        skeleton["joints"] = list(people.skeleton.joints)  # no other place has it
    if people.source:
        skeleton["source"] = people.source
    if np.isfinite(people.depth_m).any():
        arrays += ("depth_m", "depth_sd_m")
    if any(people.attributes):
        skeleton["attributes"] = [dict(one) for one in people.attributes]
    if any(people.rivals):
        skeleton["rivals"] = [
            None if r is None else [r.name, *_numbers(np.array([r.ratio])), *([True] if r.shows else [])]
            for r in people.rivals
        ]
    if any(people.framed):
        skeleton["framed"] = list(people.framed)
    return {**skeleton, **{name: _numbers(getattr(people, name)) for name in arrays}}


def people_from_dict(fields: Mapping[str, Any]) -> People:
    """Read what `people_to_dict` wrote; raises as `camera_from_dict` does."""
    joints_named = fields.get("joints")
    skeleton = Skeleton(fields["skeleton"], tuple(joints_named)) if joints_named else skeleton_named(fields["skeleton"])
    count, joints = len(fields["scores"]), len(skeleton)
    return People(
        skeleton,
        _array(fields["keypoints_px"], count, joints, 2),
        _array(fields["scores"], count, joints),
        _array(fields["boxes_px"], count, 4),
        _array(fields["person_scores"], count),
        _array(fields["heading_rad"], count),
        _array(fields["heading_sd_rad"], count),
        fields.get("source", ""),
        depth_m=_stated("depth_m", fields, count),
        depth_sd_m=_stated("depth_sd_m", fields, count),
        attributes=fields.get("attributes", ()),
        rivals=[None if one is None else Rival(*one) for one in fields.get("rivals", ())],
        framed=fields.get("framed", ()),
    )


def _stated(name: str, fields: Mapping[str, Any], count: int) -> FloatArray:
    """Return a vector that is written only where it has a number, empty where it is not."""
    return _array(fields[name], count) if name in fields else np.zeros(0)


def bodies_to_dict(bodies: Bodies) -> dict[str, Any]:
    """Return bodies for JSON."""
    vectors = ("positions_m", "heading_rad", "heading_sd_rad", "stature_m", "stature_sd_m")
    return {
        "method": bodies.method,
        "basis": list(bodies.basis),
        "reasons": list(bodies.reasons),
        **{name: _numbers(getattr(bodies, name)) for name in vectors},
        "covariance_m2": _triangle(bodies.covariance_m2),
        "up": None if bodies.up is None else _numbers(bodies.up),
        "floor": None if bodies.floor is None else {k: none_if_nan(v) for k, v in asdict(bodies.floor).items()},
        "modes": [
            {
                "weight": m.weight,
                "positions_m": _numbers(m.positions_m),
                "covariance_m2": _triangle(m.covariance_m2),
            }
            for m in bodies.modes
        ],
        "mount_misfit": none_if_nan(bodies.mount_misfit),
        "focal_factor": bodies.intrinsics.focal_factor,
        "principal_shift": list(bodies.intrinsics.shift),
        **({"depth_misfit": _numbers(bodies.depth_misfit)} if np.isfinite(bodies.depth_misfit).any() else {}),
    }


def bodies_from_dict(fields: Mapping[str, Any]) -> Bodies:
    """Read what `bodies_to_dict` wrote; raises as `camera_from_dict` does."""
    count = len(fields["basis"])
    floor = fields["floor"]
    vectors = {k: _array(fields[k], count) for k in ("heading_rad", "heading_sd_rad", "stature_m", "stature_sd_m")}
    return Bodies(
        _array(fields["positions_m"], count, 3),
        _from_triangle(fields["covariance_m2"], 3 * count),
        fields["method"],
        tuple(fields["basis"]),
        tuple(fields["reasons"]),
        up=None if fields["up"] is None else _array(fields["up"], 3),
        floor=None if floor is None else Floor(**{k: math.nan if v is None else v for k, v in floor.items()}),
        modes=tuple(
            Mode(m["weight"], _array(m["positions_m"], count, 3), _from_triangle(m["covariance_m2"], 3 * count))
            for m in fields["modes"]
        ),
        mount_misfit=math.nan if fields.get("mount_misfit") is None else fields["mount_misfit"],
        depth_misfit=_stated("depth_misfit", fields, count),
        intrinsics=Intrinsics(fields.get("focal_factor", 1.0), tuple(fields.get("principal_shift", (0.0, 0.0)))),
        **vectors,
    )
