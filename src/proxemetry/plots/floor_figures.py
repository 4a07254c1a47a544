"""Figures on the floor: circles around people in the photo's perspective, and the floor from above with the people.

Circles have the limit as their diameter: two touch where two people stand nearer than the limit. After the safe-space
circles of Aghaei et al. 2021 (IIT), and the bird's-eye view of Yang et al. 2021.
"""

from __future__ import annotations

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch, Polygon
from matplotlib.patheffects import Normal, Stroke

from ..arrays import FloatArray
from ..distances import probability_within
from ..photo import Photo, RGBArray
from ..scene import Scene
from .faces import heads_px, pixelated
from .figure import aspect_of, sheet
from .floor import Level, laid_flat
from .geometry import ground_positions
from .lettering import badge_radius_pt, draw_badges, draw_pair_labels, panel_box, to_points
from .placement import Obstacles, around
from .plan_panel import draw_camera, draw_grid, draw_nobody

#: Okabe and Ito's colours (2008) that stand for no zone: two people touch, may touch, stand apart.
TOUCHING, PERHAPS, APART = "#CC79A7", "#F0E442", "#009E73"
#: Two circles touch where that is likelier than not; from this probability on they may.
_LIKELY, _POSSIBLE = 0.5, 0.1
_LONG_SIDE_PX, _BLANK_RGB, _PAPER_RGB = 2400, (232, 233, 235), (251, 251, 249)
#: Floor around everyone beyond their circles, metres.
_AROUND_M = 1.0
#: Pixels of the floor laid flat, along its longer side.
_FLAT_PX = 1400


def circles_figure(scene: Scene, photo: Photo | None, within_m: float, faces: str) -> Figure:
    """Return the photo with a circle on the floor around each person, coloured by whether two touch."""
    chance, level = probability_within(scene.bodies, within_m), Level.of(scene)
    aspect = aspect_of(scene)
    tall = min(7.2, 11.0 / aspect)
    size = (tall * aspect, tall)
    figure, (axes,) = sheet(
        scene, _foot(scene, chance, within_m, level), max(size[0], 6.0), tall, [(0.0, 0.0)], [size], _legend(within_m)
    )
    pixels = _pixels(scene, photo, faces)
    width, height = scene.width_px or 1, scene.height_px or 1
    axes.imshow(pixels, extent=(0, width, height, 0), interpolation="antialiased", aspect="auto")
    axes.set(xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    if level is None:
        return figure
    places = ground_positions(scene.bodies)
    outlines = level.circles_px(places, within_m / 2)
    middles = level.to_pixels(places, level.height_m)
    for person in _farthest_first(scene):
        _draw_outline(axes, outlines[person], _colour(chance, person))
    _draw_links(axes, scene, chance, middles)
    return figure


def birds_eye_figure(scene: Scene, photo: Photo | None, within_m: float, faces: str) -> Figure:
    """Return the floor as seen from straight above, laid flat out of the photo, with the people and circles on it."""
    chance, level = probability_within(scene.bodies, within_m), Level.of(scene)
    figure, (axes,) = sheet(
        scene, _foot(scene, chance, within_m, level), 8.2, 7.4, [(0.45, 0.0)], [(7.75, 7.4)], _legend(within_m)
    )
    placed = np.flatnonzero(scene.bodies.placed)
    if not len(placed):
        draw_nobody(axes, scene)
        return figure
    places = ground_positions(scene.bodies)
    _set_bounds(axes, places[placed], within_m)
    if photo is not None and level is not None and level.is_floor:
        _draw_flat(axes, _pixels(scene, photo, faces), level)
    draw_grid(axes, "#FFFFFF", 0.45)
    draw_camera(axes, scene)
    for person in _farthest_first(scene):
        colour = _colour(chance, person)
        middle = (float(places[person, 0]), float(places[person, 1]))
        for face, alpha in ((colour, 0.35), ("none", 1.0)):
            edge = Circle(middle, within_m / 2, facecolor=face, edgecolor=colour, linewidth=1.6, alpha=alpha, zorder=2)
            edge.set_path_effects([Stroke(linewidth=3.0, foreground="#222222"), Normal()] if face == "none" else [])
            axes.add_patch(edge)
    _draw_links(axes, scene, chance, places)
    return figure


def _pixels(scene: Scene, photo: Photo | None, faces: str) -> RGBArray:
    """Return the photo, heads pixelated where asked for, or grey where there is none."""
    if photo is None:
        return np.full((2, 2, 3), _BLANK_RGB, dtype=np.uint8)
    pixels = photo.pixels(_LONG_SIDE_PX)
    if faces != "blur":
        return pixels
    people = scene.people.scaled(pixels.shape[1] / scene.width_px, pixels.shape[0] / scene.height_px)
    return pixelated(pixels, heads_px(people))


def _farthest_first(scene: Scene) -> list[int]:
    placed = np.flatnonzero(scene.bodies.placed)
    return placed[np.argsort(-scene.bodies.positions_m[placed, 2])].tolist()


def _highest(chance: FloatArray, person: int) -> float:
    """Return the highest probability with which anyone is nearer to a person than the limit."""
    return float(np.nan_to_num(chance[person]).max(initial=0.0))


def _colour(chance: FloatArray, person: int) -> str:
    highest = _highest(chance, person)
    return TOUCHING if highest >= _LIKELY else PERHAPS if highest >= _POSSIBLE else APART


def _draw_outline(axes: Axes, outline: FloatArray, colour: str) -> None:
    """Draw a circle as the photo shows it; of one that reaches behind the lens the part before it."""
    seen = np.asarray(np.isfinite(outline).all(axis=1), dtype=bool)
    if seen.all():
        axes.add_patch(Polygon(outline, closed=True, facecolor=colour, edgecolor="none", alpha=0.3, zorder=1))
    casing = [Stroke(linewidth=3.4, foreground="#000000", alpha=0.6), Normal()]
    axes.plot(*np.where(seen[:, None], outline, np.nan).T, color=colour, linewidth=1.9, zorder=2, path_effects=casing)


def _draw_links(axes: Axes, scene: Scene, chance: FloatArray, middles: FloatArray) -> None:
    """Draw each person's number on the floor, and lines with the probability that two circles touch."""
    placed = [p for p in np.flatnonzero(scene.bodies.placed).tolist() if np.isfinite(middles[p]).all()]
    pairs = [(a, b) for k, a in enumerate(placed) for b in placed[k + 1 :] if chance[a, b] >= _POSSIBLE]
    pairs.sort(key=lambda pair: -chance[pair])
    colours = [TOUCHING if chance[pair] >= _LIKELY else PERHAPS for pair in pairs]
    casing = [Stroke(linewidth=3.2, foreground="#000000", alpha=0.6), Normal()]
    for (a, b), colour in zip(pairs, colours, strict=True):
        axes.plot(*middles[[a, b]].T, color=colour, linewidth=1.6, zorder=3, path_effects=casing)
    points = to_points(axes, middles)
    reach = 2 * badge_radius_pt(len(placed))
    spots = [np.concatenate([points[[p]], around(points[p], reach, 3.0)]) for p in placed]
    taken = draw_badges(axes, spots, placed, [_colour(chance, p) for p in placed], with_dots=True)
    texts = [f"{100 * chance[pair]:.0f} %" for pair in pairs]
    draw_pair_labels(axes, [(points[a], points[b]) for a, b in pairs], texts, colours, taken, Obstacles.none())


def _set_bounds(axes: Axes, places: FloatArray, within_m: float) -> None:
    """Show everyone with some floor around them, in the panel's shape."""
    margin = within_m / 2 + _AROUND_M
    low, high = places.min(axis=0) - margin, places.max(axis=0) + margin
    x0, y0, x1, y1 = panel_box(axes)
    panel = np.array([x1 - x0, y1 - y0])
    half = panel * float(((high - low) / panel).max()) / 2
    middle = (low + high) / 2
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]), ylim=(middle[1] - half[1], middle[1] + half[1]))


def _draw_flat(axes: Axes, pixels: RGBArray, level: Level) -> None:
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    scale = _FLAT_PX / max(x1 - x0, y1 - y0)
    blank = np.empty((round((y1 - y0) * scale), round((x1 - x0) * scale), 3), dtype=np.uint8)
    blank[:] = _PAPER_RGB
    flat = laid_flat(pixels, level, (x0, x1, y0, y1), blank)
    axes.imshow(flat, extent=(x0, x1, y0, y1), aspect="auto", interpolation="antialiased", zorder=0)


def _legend(within_m: float) -> list[Artist]:
    signs = ((TOUCHING, f"nearer than {within_m:g} m"), (PERHAPS, "perhaps nearer"), (APART, "further apart"))
    return [Patch(facecolor=colour, edgecolor="#222222", linewidth=0.7, label=label) for colour, label in signs]


def _foot(scene: Scene, chance: FloatArray, within_m: float, level: Level | None) -> str:
    """Return what the circles mean and how many touch."""
    upper = np.triu(np.nan_to_num(chance), 1)
    likely, expected = int((upper >= _LIKELY).sum()), float(upper.sum())
    where = (
        "on the floor" if level is not None and level.is_floor else "at the height of the bodies (no floor was found)"
    )
    circles = (
        f"Circles {where} have a diameter of {within_m:g} m: two that touch are nearer, between body centres. {likely} "
        f"pair{'' if likely == 1 else 's'} likelier than not, {expected:.1f} expected; numbers beside lines are the "
        f"probabilities, from {100 * _POSSIBLE:.0f} % on."
    )
    words = [circles] if scene.bodies.placed.any() else []
    without = [str(p) for p in np.flatnonzero(~scene.bodies.placed)]
    if without:
        words.append(f"Without a place: {', '.join(without)}.")
    if scene.camera.flags:
        words.append(f"Camera: {'; '.join(map(str, scene.camera.flags))}.")
    return " ".join(words)
