"""A scene as the page reads it: JSON values, pixels of the full-size photo, metres on the ground, missing is null."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..archive.review.actions import Action
from ..archive.review.edits import joints_to_click
from ..archive.store.index import PhotoCard
from ..arrays import FloatArray
from ..camera import Camera
from ..distances import UNCERTAIN
from ..people.doubts import in_words
from ..plots.faces import heads_px
from ..plots.geometry import anchors_px, camera_as_fitted, field_of_view, ground_positions, ground_regions
from ..plots.pair_selection import UNPLACED_COLOUR, camera_text, colour_of, focal_text, pairs_shown, text_on
from ..plots.zone_colours import ZONE_COLOURS
from ..scene import Scene


def number(value: float, digits: int = 4) -> float | None:
    """Return a number for JSON."""
    return round(float(value), digits) if math.isfinite(value) else None


def numbers(values: Iterable[float], digits: int = 4) -> list[float | None] | None:
    """Return numbers for JSON, None where all are missing."""
    found = [number(v, digits) for v in values]
    return found if any(v is not None for v in found) else None


def summary_view(photo_id: int, summary: PhotoCard, marks: Sequence[str]) -> dict[str, Any]:
    """Return a card of the gallery; marks: "checked", "note" and so on."""
    return {
        "id": photo_id,
        "photo": summary.photo,
        "status": summary.status,
        "reason": summary.reason,
        "people": summary.n_people,
        "pairs": summary.n_pairs,
        "nearest_m": number(summary.nearest_m),
        "spread": number(summary.spread),
        "doubtful": summary.doubtful,
        "assumed": summary.assumed,
        "duplicates": summary.duplicates,
        "doubts": summary.doubts,
        "corrections": summary.corrections,
        "marks": list(marks),
    }


def scene_view(scene: Scene, actions: Sequence[Action]) -> dict[str, Any]:
    """Return everything that the photo view shows; actions: those in force, for the history."""
    return {
        "photo": scene.photo,
        "width": scene.width_px,
        "height": scene.height_px,
        "status": scene.status,
        "reason": scene.reason,
        "method": scene.settings.method,
        "pose": scene.made_by.pose,
        "about": {name: getattr(scene.about, name) for name in ("date", "city", "country", "source")},
        "note": None if scene.review is None else scene.review.note,
        "on_ground": scene.distances.on_ground,
        "camera": _camera(scene),
        "joints": list(scene.people.skeleton.joints),
        "click": list(joints_to_click(scene.people.skeleton)),
        "people": _people(scene),
        "pairs": _pairs(scene),
        "history": [_history(a) for a in actions],
    }


def _view(scene: Scene, camera: Camera) -> list[list[float | None] | None]:
    return [numbers(v) for v in field_of_view(camera_as_fitted(camera, scene.bodies), scene.bodies.up)]


def _camera(scene: Scene) -> dict[str, Any]:
    camera, floor = scene.camera.camera, scene.bodies.floor
    diagonal_px = math.hypot(scene.width_px, scene.height_px)
    return {
        "known": camera is not None,
        "text": camera_text(scene),
        "focal_px": None if camera is None else number(camera.f_px, 1),
        "source": None if camera is None else str(camera.source),
        "reason": scene.camera.reason,
        "flags": [str(flag) for flag in scene.camera.flags],
        "candidates": [
            {
                "text": focal_text(c.focal_px, c.rel_sd, diagonal_px),
                "source": str(c.source),
            }
            for c in scene.camera.candidates
        ],
        "view": None if camera is None else _view(scene, camera),
        "height_m": None if floor is None else number(floor.height_m, 2),
        "pitch_deg": None if floor is None else number(math.degrees(floor.pitch_rad), 1),
    }


def _people(scene: Scene) -> list[dict[str, Any]]:
    people, bodies = scene.people, scene.bodies
    heads, anchors = heads_px(people), anchors_px(people)
    positions, regions = ground_positions(bodies), ground_regions(bodies)
    locate = scene.settings.locate
    sizes = locate.body_sizes or (None,) * len(scene)
    return [
        {
            "number": i,
            "colour": (colour := colour_of(i) if bodies.placed[i] else UNPLACED_COLOUR),
            "ink": text_on(colour),
            "keypoints": [numbers(point, 1) for point in people.keypoints_px[i]],
            "bones": [
                segment
                for a, b in people.skeleton.bones
                if (segment := _segment(people.joint(a)[i], people.joint(b)[i])) is not None
            ],
            "box": [float(v) for v in people.boxes_px[i]] if np.isfinite(people.boxes_px[i]).all() else None,
            "head": numbers(heads[i], 1),
            "anchor": numbers(anchors[i], 1),
            "score": number(people.person_scores[i], 2),
            "doubt": in_words(people, i, scene.doubts[i]),
            "placed": bool(bodies.placed[i]),
            "reason": bodies.reasons[i],
            "basis": bodies.basis[i],
            "ground": numbers(positions[i], 3),
            "region": [numbers(p, 2) for p in regions[i]] if np.isfinite(regions[i]).all() else None,
            "heading": number(bodies.heading_rad[i], 3),
            "stature_m": number(bodies.stature_m[i], 2),
            "size": sizes[i] if i < len(sizes) else None,
            "off_floor": i in locate.off_floor,
            "attributes": dict(people.attributes[i]) if people.attributes else {},
        }
        for i in range(len(scene))
    ]


def _segment(start: FloatArray, end: FloatArray) -> list[float] | None:
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        return None
    return [round(float(v), 1) for v in (*start, *end)]


def _pairs(scene: Scene) -> list[dict[str, Any]]:
    distances = scene.distances
    shown = set(pairs_shown(distances))
    listed = [
        {
            "a": a,
            "b": b,
            "distance_m": number(distances.distance_m[a, b], 3),
            "low_m": number(distances.low_m[a, b], 3),
            "high_m": number(distances.high_m[a, b], 3),
            "vague": distances.vague(a, b),
            "zone": distances.zone(a, b),
            "colour": ZONE_COLOURS[distances.zone(a, b) or UNCERTAIN],
            "zones": numbers(distances.zone_probability[a, b], 3),
            "group": number(distances.group_probability[a, b], 2),
            "nearest": (a, b) in shown,
        }
        for a, b in distances.pairs()
    ]
    return sorted(listed, key=lambda p: (p["distance_m"] is None, p["distance_m"] or 0.0))


def _history(action: Action) -> dict[str, Any]:
    details = {k: v for k, v in action.value.items() if k not in ("box", "joints")}
    return {"number": action.number, "time": action.time, "who": action.who, "action": action.action, **details}
