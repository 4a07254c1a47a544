"""What a figure shows and how it words it: which pairs, which colours, which words. No drawing."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from ..camera.sensors import equivalent_mm
from ..distances import UNCERTAIN, Distances
from ..intervals import HALF_WIDTH_SD
from ..people.doubts import in_words
from ..scene import Scene
from .zone_colours import ZONE_COLOURS

#: None of them is a zone's; the number beside each person identifies the same person.
PERSON_COLOURS = ("#009E73", "#F0E442", "#CC79A7", "#7B4FC9", "#A8E6CF")
UNPLACED_COLOUR = "#BBBBBB"
#: Stands after a distance whose interval is to be read instead of the number.
VAGUE_MARK = "?"
#: A line's dashes and gaps in widths of the line, None where it is unbroken.
Dashes = tuple[float, float] | None

_ALL_PAIRS_UP_TO = 3
#: The second decimal of a distance means something where its interval is narrower than this.
_NARROW_M = 0.2
#: A focal length's interval, whose spread is one of logarithms, is written as "± so many per cent" up to this.
_ONE_SPREAD = 0.25
#: From here on a 35 mm equivalent is written in whole millimetres, as lenses are engraved.
_WHOLE_MM = 10.0


def colour_of(person: int) -> str:
    """Return the colour of a person, the same in every view of a scene."""
    return PERSON_COLOURS[person % len(PERSON_COLOURS)]


def text_on(colour: str) -> str:
    """Return black or white, whichever stands out more from a colour "#RRGGBB"."""
    channels = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    luminance = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return "#000000" if luminance > 0.179 else "#FFFFFF"


def pairs_shown(distances: Distances, all_pairs: bool = False) -> list[tuple[int, int]]:
    """Return the pairs (a, b), a < b, to draw, the nearest first.

    Each person's nearest neighbour, or every pair that has a distance: where that is asked for or with up to three
    people.
    """
    metres = distances.distance_m
    known = [(a, b) for a, b in distances.pairs() if math.isfinite(metres[a, b])]
    if not all_pairs and len(distances) > _ALL_PAIRS_UP_TO:
        filled = np.where(np.isfinite(metres), metres, np.inf)
        nearest = {(min(a, b), max(a, b)) for a, b in enumerate(filled.argmin(axis=1).tolist())}
        known = [pair for pair in known if pair in nearest]
    return sorted(known, key=lambda pair: float(metres[pair]))


def decimals(low_m: float, high_m: float) -> int:
    """Return how many decimals of a distance in metres its interval supports: two where it is narrower than 0.2 m."""
    return 2 if high_m - low_m < _NARROW_M else 1


def metres_text(value_m: float, low_m: float = math.nan, high_m: float = math.nan) -> str:
    """Return "2.1 m [1.7, 2.6]", with the decimals that the interval supports; one where there is none."""
    if not math.isfinite(value_m):
        return "unknown"
    digits = decimals(low_m, high_m)
    if not (math.isfinite(low_m) and math.isfinite(high_m)):
        return f"{value_m:.{digits}f} m"
    return f"{value_m:.{digits}f} m [{low_m:.{digits}f}, {high_m:.{digits}f}]"


def pair_text(distances: Distances, a: int, b: int) -> str:
    """Return a pair's distance with its interval, and a question mark where only that is to be read."""
    text = metres_text(*(float(m[a, b]) for m in (distances.distance_m, distances.low_m, distances.high_m)))
    return f"{text} {VAGUE_MARK}" if distances.vague(a, b) else text


def short_pair_text(distances: Distances, a: int, b: int) -> str:
    """Return a pair's distance alone, "0.1–2.2 m ?" where a bare number would claim what is not known."""
    value, low, high = (float(m[a, b]) for m in (distances.distance_m, distances.low_m, distances.high_m))
    if not distances.vague(a, b):
        return metres_text(value, low, high).partition(" [")[0]
    digits = decimals(low, high)
    return f"{low:.{digits}f}–{high:.{digits}f} m {VAGUE_MARK}"


def line_colours(distances: Distances, shown: list[tuple[int, int]]) -> list[str]:
    """Return the colours of pairs' lines: those of their zones."""
    return [ZONE_COLOURS[distances.zone(a, b) or UNCERTAIN] for a, b in shown]


def line_styles(distances: Distances, shown: list[tuple[int, int]]) -> list[Dashes]:
    """Return how the pairs' lines are drawn: broken where the number is not to be relied on."""
    return [(4.0, 2.5) if distances.vague(a, b) else None for a, b in shown]


def _counted(count: int, one: str, many: str) -> str:
    return f"{count} {one if count == 1 else many}"


def headline(scene: Scene) -> str:
    """Return the back end, the method and the version in one line, so that no figure is quoted without them."""
    words = [
        _counted(len(scene), "person", "people"),
        _counted(scene.distances.below(math.inf), "distance", "distances"),
        camera_text(scene),
        f"method {scene.settings.method}",
    ]
    if scene.made_by.pose:
        words.append(f"pose {scene.made_by.pose}")
    return "  ·  ".join(words)


def camera_text(scene: Scene) -> str:
    """Return the focal length with its source and its 90 % interval; or that there is none."""
    camera = scene.camera.camera
    if camera is None:
        return "focal length unknown"
    focal = focal_text(camera.f_px, camera.focal_rel_sd, math.hypot(camera.width, camera.height))
    return f"focal length {focal} ({camera.source})"


def focal_text(f_px: float, rel_sd: float, diagonal_px: float) -> str:
    """Return a focal length in pixels as the 35 mm equivalent with its 90 % interval, and in pixels."""
    middle_mm = equivalent_mm(f_px, diagonal_px)
    spread = HALF_WIDTH_SD * rel_sd
    if spread > _ONE_SPREAD:
        low, high = (_mm_text(middle_mm * math.exp(sign * spread)) for sign in (-1, 1))
        interval = f"[{low}, {high}]"
    else:
        interval = f"± {100 * spread:.0f} %" if spread >= 0.1 else f"± {100 * spread:.2g} %"
    return f"{_mm_text(middle_mm)} mm {interval} as 35 mm equivalent, {f_px:.0f} px"


def _mm_text(millimetres: float) -> str:
    return f"{millimetres:.0f}" if millimetres >= _WHOLE_MM else f"{millimetres:.1f}"


def number_text(scene: Scene, person: int) -> str:
    """Return a person's number, with a question mark where it is doubtful whether this is a person."""
    return f"{person}{VAGUE_MARK}" if scene.doubts[person] else str(person)


def footnote(scene: Scene, shown: list[tuple[int, int]]) -> str:
    """Return what the lines and brackets mean, and who has no place and why."""
    known = scene.distances.below(math.inf)
    which = "all pairs" if len(shown) == known else f"nearest neighbours, {len(shown)} of {known} pairs"
    kind = "along the ground" if scene.distances.on_ground else "in space (gravity unknown)"
    words = [f"Lines: {which}. Distance between body centres {kind} [90 % interval]."] if known else []
    if any(scene.distances.vague(a, b) for a, b in shown):
        words.append(f"{VAGUE_MARK} (broken line): too uncertain for one number, read the interval.")
    unplaced = _by_reason(enumerate(scene.bodies.reasons))
    words += [f"Without a place: {who} ({why})." for why, who in unplaced.items()]
    doubtful = _by_reason((i, in_words(scene.people, i, doubts)) for i, doubts in enumerate(scene.doubts) if doubts)
    if doubtful:
        named = "; ".join(f"{who}: {why}" for why, who in doubtful.items())
        words.append(f"In doubt: perhaps not a person, or one found twice ({VAGUE_MARK}): {named}.")
    if scene.camera.flags:
        words.append(f"Camera: {'; '.join(map(str, scene.camera.flags))}.")
    return " ".join(words)


def _by_reason(people: Iterable[tuple[int, str | None]]) -> dict[str, str]:
    """Return the numbers of the people who share a reason, so that each reason is given once."""
    found: dict[str, list[str]] = {}
    for person, reason in people:
        if reason:
            found.setdefault(reason, []).append(str(person))
    return {reason: ", ".join(numbers) for reason, numbers in found.items()}
