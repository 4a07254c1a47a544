"""Would colours tell statues from people? What was tried for photos, to be repeated; nothing of it is used.

    python -m benchmarks.networks.one_colour --people DIR [--stone DIR] [--pictured DIR] [--pose NAME] [--half report]

Two cues, by what does not depend on lightness, the logarithms of red over green and of blue over green of linear light:
a figure of one colour (`spread`: so far from its median are nine tenths of face, hair, torso and limbs), and a face
that is no redder than grey (`redness`: of nine tenths of the face), since blood and melanin redden every skin. Photos
with hardly any colour and figures with few or dark parts or a small face are left out ("counted" are the others).

--people: photos of real people. --stone: pictures that show stone, plaster or bronze and nothing else; figures are
composed of real people's shading and their colours. --pictured: statues, dolls, paintings. Per pair of limits it prints
how many would be marked, and of real people by the lightness of their faces in quarters, so that unfairness shows.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.composed_people import body_mask
from benchmarks.networks.doubtful import photos_in
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.overlap import pairwise_iou
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named

#: Photos are looked at with this longer side, and a body with that, pixels.
_LOOK_PX, _BODY_PX = 640, 128
#: Darker than this, linear light, a pixel's colour is noise; brighter than that, of 255, a channel is cut off.
_DARK, _BRIGHT = 0.02, 250
#: A part counts where this share of it has a colour; so many parts, face and torso among them, and so large a face,
#: pixels from nose to ear, make a figure that counts.
_TELLS, _FEWEST_PARTS, _FACE_PX = 0.5, 4, 6.0
#: The surroundings have colours: a tenth of them is further than this from their usual one.
_COLOURFUL = 0.35
#: Limits of redness and spread that are tried.
LIMITS = ((0.25, 0.2), (0.5, 0.3), (np.inf, 0.3), (0.25, np.inf))
_LIMBS = (
    ("left_shoulder", "left_elbow", "left_wrist"), ("right_shoulder", "right_elbow", "right_wrist"),
    ("left_hip", "left_knee"), ("right_hip", "right_knee"), ("left_knee", "left_ankle"), ("right_knee", "right_ankle"),
)  # fmt: skip
#: Made of: how light it is, linear, and how much of the stone's colour it has.
_MATERIALS = {"stone": (0.30, 1.0), "plaster": (0.5, 0.35), "bronze": (0.09, 1.0)}
_SEED, _LEAST_PX, _MOST_OF_A_PHOTO, _CLEAR = 3, 100, 2, 0.5


@dataclass(frozen=True)
class Colours:
    """What the colours of one figure say. lightness: of the face, linear light, 0..1."""

    spread: float
    redness: float
    lightness: float


def colours_of(photo: Photo, people: People) -> list[Colours | None]:
    """Return each person's colours, None where they say nothing."""
    pixels = photo.pixels(_LOOK_PX)
    factor = pixels.shape[1] / photo.width
    if not _is_colourful(pixels, people.boxes_px * factor):
        return [None] * len(people)
    return [_colours(pixels, people, person, factor) for person in range(len(people))]


def _colours(pixels: RGBArray, people: People, person: int, factor: float) -> Colours | None:
    x0, y0, x1, y1 = people.boxes_px[person] * factor
    height, width = pixels.shape[:2]
    left, top, right, bottom = (
        max(0, int(x0) - 4),
        max(0, int(y0) - 4),
        min(width, int(x1) + 4),
        min(height, int(y1) + 4),
    )
    points, face_px = _points(people, person)
    if right - left < 8 or bottom - top < 8 or not face_px * factor >= _FACE_PX:
        return None
    crop = pixels[top:bottom, left:right]
    smaller = min(1.0, _BODY_PX / max(crop.shape[:2]))
    crop = _resized(crop, smaller) if smaller < 1 else crop
    light = _linear(crop)
    colour, luminance = _chroma(light), light @ _LUMINANCE
    good = (luminance > _DARK) & (crop.max(axis=-1) < _BRIGHT)
    told: dict[str, FloatArray] = {}
    lightness = 0.0
    for part, places in points.items():
        at = np.floor((places * factor - (left, top)) * smaller).astype(int)
        inside = ((at >= 0) & (at < (crop.shape[1], crop.shape[0]))).all(axis=-1)
        at = at[inside]
        if inside.mean() < 0.6 or good[at[:, 1], at[:, 0]].mean() < _TELLS:
            continue
        at = at[good[at[:, 1], at[:, 0]]]
        told[part] = colour[at[:, 1], at[:, 0]]
        if part == "face":
            lightness = float(np.median(luminance[at[:, 1], at[:, 0]]))
    if len(told) < _FEWEST_PARTS or not {"face", "torso"} <= set(told):
        return None
    everything = np.concatenate(list(told.values()))
    away = np.linalg.norm(everything - np.median(everything, axis=0), axis=-1)
    return Colours(float(np.quantile(away, 0.9)), float(np.quantile(told["face"][:, 0], 0.9)), lightness)


_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _resized(pixels: RGBArray, factor: float) -> RGBArray:
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    return np.asarray(cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=method), dtype=np.uint8)


def _linear(pixels: RGBArray) -> FloatArray:
    """Return linear light, 0..1 (sRGB's law)."""
    value = pixels.astype(float) / 255
    return np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)


def _pixels(light: FloatArray) -> RGBArray:
    light = light.clip(0, 1)
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return (255 * value).round().astype(np.uint8)


def _chroma(light: FloatArray) -> FloatArray:
    logs = np.log(light + 0.004)  # a step of 8 bits, so that darkness has no colour
    return np.stack([logs[..., 0] - logs[..., 1], logs[..., 2] - logs[..., 1]], axis=-1)


def _is_colourful(pixels: RGBArray, boxes_px: FloatArray) -> bool:
    """Return whether what is around the people has colours at all: not so in black and white, or in one light."""
    smaller = 96 / max(pixels.shape[:2])
    small = _resized(pixels, smaller)
    around = np.ones(small.shape[:2], dtype=bool)
    for x0, y0, x1, y1 in np.nan_to_num(boxes_px * smaller).clip(0):
        around[int(y0) : int(np.ceil(y1)), int(x0) : int(np.ceil(x1))] = False
    light = _linear(small)
    colour = _chroma(light)[around & (light @ _LUMINANCE > _DARK) & (small.max(axis=-1) < _BRIGHT)]
    if len(colour) < 30:
        return False
    return bool(np.quantile(np.linalg.norm(colour - np.median(colour, axis=0), axis=-1), 0.9) > _COLOURFUL)


def _points(people: People, person: int) -> tuple[dict[str, FloatArray], float]:
    """Return places on each part of the body, (n, 2) pixels of the photo, and from nose to ear in pixels."""

    def joint(name: str) -> FloatArray:
        return people.joint(name)[person]

    found: dict[str, FloatArray] = {}
    shoulders = np.stack([joint("left_shoulder"), joint("right_shoulder")])
    hips = np.stack([joint("left_hip"), joint("right_hip")])
    across, down = (v.ravel()[:, None] for v in np.meshgrid(np.linspace(0.2, 0.8, 7), np.linspace(0.1, 0.85, 9)))
    top, bottom = (ends[0] + (ends[1] - ends[0]) * across for ends in (shoulders, hips))
    found["torso"] = top + (bottom - top) * down
    tall = float(np.linalg.norm(shoulders.mean(axis=0) - hips.mean(axis=0)))
    for number, limb in enumerate(_LIMBS):
        along = [_along(joint(a), joint(b), 0.05 * tall) for a, b in pairwise(limb)]
        found[f"limb {number}"] = np.concatenate(along)
    nose, eyes = joint("nose"), (joint("left_eye") + joint("right_eye")) / 2
    widths = [np.linalg.norm(joint(ear) - nose) for ear in ("left_ear", "right_ear")]
    widths += [1.6 * np.linalg.norm(joint("left_eye") - joint("right_eye")), 1.5 * np.linalg.norm(nose - eyes)]
    face_px = float(np.nanmax(np.array([*widths, 0.0])))
    up = (eyes - nose) / max(float(np.linalg.norm(eyes - nose)), 1e-6)
    for part, middle, heights in (("face", (nose + 2 * eyes) / 3, (-0.6, 0.35, 6)), ("hair", eyes, (0.75, 1.15, 4))):
        side, high = (v.ravel()[:, None] for v in np.meshgrid(np.linspace(-0.55, 0.55, 6), np.linspace(*heights)))
        found[part] = middle + face_px * (side * np.array([-up[1], up[0]]) + high * up)
    return {part: places for part, places in found.items() if np.isfinite(places).all()}, face_px


def _along(a: FloatArray, b: FloatArray, aside_px: float) -> FloatArray:
    """Return places along a limb and to both sides of its middle line."""
    line = b - a
    aside = np.array([-line[1], line[0]]) / max(float(np.linalg.norm(line)), 1e-6) * aside_px
    return np.concatenate([a + line * np.linspace(0.2, 0.85, 8)[:, None] + off * aside for off in (-1, 0, 1)])


def figure_of(
    pixels: RGBArray, people: People, person: int, stone: RGBArray, material: str, rng: np.random.Generator
) -> RGBArray:
    """Return a photo in which one person is of stone: the person's shading, the stone's colours."""
    x0, y0, x1, y1 = people.boxes_px[person].clip(0, [pixels.shape[1], pixels.shape[0]] * 2).astype(int)
    mask = body_mask(pixels, people, person, 0.08)[..., None]
    lightness, coloured = _MATERIALS[material]
    grey = np.asarray(cv2.medianBlur(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), 5), dtype=np.uint8)
    luminance = _linear(grey)
    usual = float(np.median(luminance[y0:y1, x0:x1]))
    shading = lightness * ((luminance + 0.02) / (usual + 0.02)) ** 0.6  # dark hair and cloth are of the same stone
    scale = max((x1 - x0 + 2) / stone.shape[1], (y1 - y0 + 2) / stone.shape[0], 0.25)
    surface = _linear(_resized(stone, scale)[: y1 - y0, : x1 - x0])
    brightness = np.maximum(surface @ _LUMINANCE, 1e-3)[..., None]
    colour = np.ones((*shading.shape, 3))
    colour[y0:y1, x0:x1] = (surface / brightness) ** coloured * (brightness / np.median(brightness)) ** 0.4
    if material == "bronze":
        colour *= (1.25, 0.95, 0.6)
    warm = rng.uniform(0, 0.12)  # lit by the sun, shaded by the sky
    tint = (shading[..., None] / lightness) ** (warm * np.array([1.0, 0.0, -1.0]))
    made = _pixels(shading[..., None] * colour * tint)
    return (made * mask + pixels * (1 - mask)).round().astype(np.uint8)


def _figures(
    photo: Photo, people: People, stones: list[RGBArray], rng: np.random.Generator
) -> Iterator[tuple[str, RGBArray, FloatArray]]:
    """Yield material, picture and box of what is made of a photo's people."""
    tall = people.boxes_px[:, 3] - people.boxes_px[:, 1]
    clear = [int(row) for row in np.argsort(-tall) if people.person_scores[row] >= _CLEAR and tall[row] >= _LEAST_PX]
    for row in clear[:_MOST_OF_A_PHOTO] if stones else ():
        for material in _MATERIALS:
            stone = stones[int(rng.integers(len(stones)))]
            yield material, figure_of(photo.pixels(), people, row, stone, material, rng), people.boxes_px[row]


def measured(backend: PoseBackend, args: argparse.Namespace) -> dict[str, list[Colours | None]]:
    """Return the colours of everybody found, by kind."""
    rng = np.random.default_rng(_SEED)
    stones = [] if args.stone is None else [photo.pixels() for photo in photos_in(args.stone, args.half)]
    found: dict[str, list[Colours | None]] = defaultdict(list)
    for photo in photos_in(args.people, args.half):
        people = backend.detect(photo)
        found["real people"] += colours_of(photo, people)
        for material, pixels, box in _figures(photo, people, stones, rng):
            made = Photo.from_array(pixels)
            again = backend.detect(made)
            overlap = np.nan_to_num(pairwise_iou(again.boxes_px, box[None]))[:, 0]
            if len(overlap) and overlap.max() > 0.3:
                found[f"composed of {material}"].append(colours_of(made, again)[int(overlap.argmax())])
    if args.pictured is not None:
        for photo in photos_in(args.pictured, args.half):
            found["painted, drawn, carved"] += colours_of(photo, backend.detect(photo))
    return found


def _marked(colours: list[Colours], limits: tuple[float, float]) -> NDArray[np.bool_]:
    return np.array([c.redness < limits[0] and c.spread < limits[1] for c in colours], dtype=bool)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=Path, required=True)
    parser.add_argument("--stone", type=Path)
    parser.add_argument("--pictured", type=Path)
    parser.add_argument("--pose", default="yolox-tinypose")
    parser.add_argument("--half", choices=("choose", "report", "all"), default="all")
    add_models_option(parser)
    args = parser.parse_args()
    found = measured(backend_named(args.pose, PoseOptions()), args)
    heads = [f"redness < {r:g}, spread < {s:g}" for r, s in LIMITS]
    print(f"| people | found | counted | {' | '.join(heads)} |\n| --- | ---: | ---: |{' ---: |' * len(heads)}")
    for kind, everybody in found.items():
        counted = [c for c in everybody if c is not None]
        cells = [str(int(_marked(counted, limits).sum())) for limits in LIMITS]
        print(f"| {kind} | {len(everybody)} | {len(counted)} | {' | '.join(cells)} |")
    real = sorted((c for c in found["real people"] if c is not None), key=lambda c: c.lightness)
    for number, quarter in enumerate(np.array_split(np.arange(len(real)), 4), 1):
        of_it = [real[k] for k in quarter]
        cells = [str(int(_marked(of_it, limits).sum())) for limits in LIMITS]
        print(f"| real people, quarter {number} from dark faces to light | | {len(of_it)} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
