"""The photo with its people: skeletons, numbers, and the pairs' distances as labelled lines."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, Stroke

from ..arrays import FloatArray
from ..distances import Distances
from ..photo import RGBArray
from ..scene import Scene
from .cased_lines import DASHED, DOTTED, Casing, Line, draw_cased, pair_lines
from .faces import heads_px, pixelated
from .geometry import anchors_px, known_horizon_px
from .lettering import badge_radius_pt, draw_badges, draw_pair_labels, to_points
from .pair_selection import UNPLACED_COLOUR, Dashes, colour_of, line_colours, number_text, pair_text
from .picture import draw_picture
from .placement import Obstacles, around

_BLANK = (232, 233, 235)
_MANY = 14
_TRUNK = ("left_shoulder", "right_shoulder", "left_hip", "right_hip")
#: How many of its own heights a label moves to leave a head and a body, and how thick limbs are in heads' radii.
_HEAD_COST, _BODY_COST, _LIMB = 14.0, 8.0, 0.35


def draw_photo(
    axes: Axes, scene: Scene, pixels: RGBArray | None, shown: list[tuple[int, int]], blur: bool = False
) -> None:
    """Draw the photo in its full-size pixel coordinates, whatever size `pixels` has, and everything on it."""
    width, height = scene.width_px or 1, scene.height_px or 1
    if pixels is None:
        pixels = np.full((2, 2, 3), _BLANK, dtype=np.uint8)
    elif blur:
        factors = pixels.shape[1] / width, pixels.shape[0] / height
        pixels = pixelated(pixels, heads_px(scene.people.scaled(*factors)))
    draw_picture(axes, pixels, width, height)
    axes.set_axis_off()
    heads, anchors = heads_px(scene.people), to_points(axes, anchors_px(scene.people))
    ends = [(anchors[a], anchors[b]) for a, b in shown]
    _draw_horizon(axes, scene)
    _draw_skeletons(axes, scene)
    _draw_lines(axes, anchors_px(scene.people), shown, scene.distances)
    people = range(len(scene))
    colours = [badge_colour(scene, i) for i in people]
    taken = draw_badges(axes, _badge_spots(axes, heads, anchors), [number_text(scene, i) for i in people], colours)
    texts = [pair_text(scene.distances, a, b) for a, b in shown]
    draw_pair_labels(axes, ends, texts, line_colours(scene.distances, shown), taken, _bodies(axes, scene, heads))


def _draw_horizon(axes: Axes, scene: Scene) -> None:
    """Draw the horizon where pitch and roll are known independently of the people: stated, or by straight lines."""
    ends = known_horizon_px(scene)
    if ends is None:
        return
    axes.add_line(Line2D(*ends.T, zorder=1.5, **horizon_style()))


def horizon_style() -> dict[str, Any]:
    """Return how the horizon is drawn, in the photo and in the legend: white with a dark casing."""
    casing = [Stroke(linewidth=2.2, foreground="#000000", alpha=0.4), Normal()]
    return {"color": "#FFFFFF", "linewidth": 0.9, "linestyle": (0.0, (6.0, 4.0)), "path_effects": casing}


def badge_colour(scene: Scene, person: int) -> str:
    """Return a person's colour, grey for one without a place."""
    return colour_of(person) if scene.bodies.placed[person] else UNPLACED_COLOUR


def _draw_skeletons(axes: Axes, scene: Scene) -> None:
    people, few = scene.people, len(scene) <= _MANY
    width = 1.9 if few else 1.3
    ends = np.stack([np.stack([people.joint(a), people.joint(b)], axis=1) for a, b in people.skeleton.bones], axis=1)
    skeletons = [
        [
            Line(segment, badge_colour(scene, person), _dashes(scene, person))
            for segment in ends[person]
            if np.isfinite(segment).all()
        ]
        for person in range(len(people))
    ]
    draw_cased(axes, skeletons, width, [Casing(1.5, "#000000", 0.5)], zorder=2, caps="round")
    seen = np.isfinite(people.keypoints_px).all(axis=-1)
    colours = [badge_colour(scene, int(person)) for person in np.nonzero(seen)[0]]
    axes.scatter(
        *people.keypoints_px[seen].T, s=7 if few else 4, color=colours, edgecolors="#000000", linewidths=0.4,
        zorder=2.1,
    )  # fmt: skip


def _dashes(scene: Scene, person: int) -> Dashes:
    """Return how a skeleton is drawn: dotted without a place, broken where it is doubtful whether this is a person."""
    if not scene.bodies.placed[person]:
        return DOTTED
    return DASHED if scene.doubts[person] else None


def _draw_lines(axes: Axes, anchors: FloatArray, shown: list[tuple[int, int]], distances: Distances) -> None:
    """Draw the pairs' lines in their zones' colours between white and black edges, the nearest pairs on top."""
    shown = shown[::-1]
    width = 2.2 if len(shown) <= _MANY else 1.4
    edges = [Casing(2.6, "#000000"), Casing(1.4, "#FFFFFF")]
    draw_cased(axes, [pair_lines(distances, anchors, shown)], width, edges, zorder=3)


def _badge_spots(axes: Axes, heads: FloatArray, anchors: FloatArray) -> list[FloatArray]:
    """Return candidates for each person's number, in points: above the head, then around it."""
    origin, right = to_points(axes, np.array([[0.0, 0.0], [1.0, 0.0]]))
    point_per_px = float(np.linalg.norm(right - origin))
    reach = badge_radius_pt(len(heads)) + 1.5
    spots: list[FloatArray] = []
    for head, centre, anchor in zip(heads, to_points(axes, heads[:, :2]), anchors, strict=True):
        seen = bool(np.isfinite(head).all())
        point = centre if seen else np.nan_to_num(anchor)
        spots.append(around(point, reach + (float(head[2]) * point_per_px if seen else 0.0), 4.0))
    return spots


def _bodies(axes: Axes, scene: Scene, heads: FloatArray) -> Obstacles:
    """Return what labels should leave visible: heads first, then trunks and limbs, the box of a person without any."""
    people = scene.people
    low, high = heads[:, :2] - 0.8 * heads[:, 2:], heads[:, :2] + 0.8 * heads[:, 2:]
    head_boxes = np.concatenate([low, high], axis=1)
    ends = [np.stack([people.joint(a), people.joint(b)], axis=1) for a, b in people.skeleton.bones]
    ends.append(np.stack([people.joint(joint) for joint in _TRUNK], axis=1))
    bones = np.stack([np.concatenate([e.min(axis=1), e.max(axis=1)], axis=1) for e in ends], axis=1)
    margin = _LIMB * np.nan_to_num(heads[:, 2])[:, None, None] * np.array([-1.0, -1.0, 1.0, 1.0])
    bones = bones + margin
    seen = np.asarray(np.isfinite(bones).all(axis=2))
    boneless = ~seen.any(axis=1)
    bodies = np.concatenate([bones.reshape(-1, 4), people.boxes_px[boneless]])
    found = []
    for boxes, cost in ((head_boxes, _HEAD_COST), (bodies, _BODY_COST)):
        known = boxes[np.isfinite(boxes).all(axis=1)]
        upright = np.concatenate([to_points(axes, known[:, [0, 3]]), to_points(axes, known[:, [2, 1]])], axis=1)
        found.append((upright, np.full(len(known), cost)))
    return Obstacles(np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found]))
