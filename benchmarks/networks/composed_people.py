"""Doubtful people composed from photos of real ones: legs behind a wall, posters, statues, the same person twice.

They show whether a rule works on the kind of picture that it was made for. They are not photos of such things: a real
poster is printed, lit and seen from the side, and a real statue does not have the folds of real clothes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFilter

from proxemetry.arrays import FloatArray
from proxemetry.people import People
from proxemetry.photo import RGBArray


class Kind(StrEnum):
    """What is made of a person."""

    LEGS = "legs behind a wall"
    HEAD = "head above a wall"
    POSTER = "poster"
    STATUE = "grey as stone"
    MIRRORED = "mirror image beside"
    TWICE_10 = "twice, 10 % of the width aside"
    TWICE_20 = "twice, 20 % aside"
    TWICE_30 = "twice, 30 % aside"
    TWICE_SMALLER = "twice, 30 % aside and 10 % smaller"


#: Of the kinds that show one person twice, how far aside, in widths of the box, and how large.
TWICE = {
    Kind.TWICE_10: (0.1, 1.0),
    Kind.TWICE_20: (0.2, 1.0),
    Kind.TWICE_30: (0.3, 1.0),
    Kind.TWICE_SMALLER: (0.3, 0.9),
}
#: Smaller people are not made into anything, pixels high.
_LEAST_PX = 120


@dataclass(frozen=True, eq=False)
class Composed:
    """A picture, and where in it the doubtful ones are: boxes of shape (N, 4)."""

    kind: Kind
    pixels: RGBArray
    boxes_px: FloatArray


def composed(
    pixels: RGBArray, people: People, person: int, background: RGBArray, rng: np.random.Generator
) -> Iterator[Composed]:
    """Yield what can be made of one person of a photo; background: the picture of a place for a poster to hang in."""
    image = Image.fromarray(pixels)
    box = people.boxes_px[person].clip(0, np.tile(image.size, 2))
    if box[3] - box[1] < _LEAST_PX:
        return
    yield from _behind_walls(image, people, person, box, rng)
    poster = _poster(image, box, background, rng)
    if poster is not None:
        yield poster
    yield _statue(image, people, person, box)
    mirrored = _mirrored(image, box)
    if mirrored is not None:
        yield mirrored
    for kind, (aside, factor) in TWICE.items():
        yield _twice(image, box, kind, aside, factor)


def _behind_walls(
    image: Image.Image, people: People, person: int, box: FloatArray, rng: np.random.Generator
) -> Iterator[Composed]:
    shoulders = people.joint("neck")[person, 1]
    hips = people.joint("mid_hip")[person, 1]
    width, height = image.size
    left, right = max(0.0, box[0] - 0.6 * (box[2] - box[0])), min(width, box[2] + 0.6 * (box[2] - box[0]))
    legs_seen = (
        np.isfinite(people.joint("left_knee")[person]).all() or np.isfinite(people.joint("right_knee")[person]).all()
    )
    if np.isfinite([shoulders, hips]).all() and legs_seen and box[3] - hips > _LEAST_PX / 2:
        wall = np.array([left, 0, right, hips])
        yield Composed(Kind.LEGS, _walled(image, wall, rng), box[None])
    if np.isfinite(shoulders) and shoulders - box[1] > _LEAST_PX / 4:
        wall = np.array([left, shoulders - 0.03 * (box[3] - box[1]), right, height])
        yield Composed(Kind.HEAD, _walled(image, wall, rng), box[None])


def _walled(image: Image.Image, wall: FloatArray, rng: np.random.Generator) -> RGBArray:
    """Return the picture with a rough, unevenly lit surface over a rectangle."""
    x0, y0, x1, y1 = wall.round().astype(int)
    pixels, shape = np.array(image), (y1 - y0, x1 - x0, 1)
    colour, light = rng.integers(90, 200, 3), np.linspace(-12, 12, x1 - x0)[None, :, None]
    pixels[y0:y1, x0:x1] = (colour + rng.normal(0, 7, shape) + light).clip(0, 255).astype(np.uint8)
    return pixels


def _poster(image: Image.Image, box: FloatArray, background: RGBArray, rng: np.random.Generator) -> Composed | None:
    """Hang the person, from the hips up or whole, in a dark frame somewhere in a picture of a place."""
    wide, tall = box[2] - box[0], box[3] - box[1]
    lower = box[1] + tall * (0.62 if rng.random() < 0.5 else 1.0)
    shown = np.array([box[0] - 0.25 * wide, box[1] - 0.1 * tall, box[2] + 0.25 * wide, lower])
    cut = image.crop(tuple(shown.clip(0, np.tile(image.size, 2)).round().astype(int).tolist()))
    place = Image.fromarray(background)
    place = place.resize((1200, round(1200 * place.height / place.width)))
    height = round(place.height * rng.uniform(0.35, 0.6))
    width = round(height * cut.width / cut.height)
    border = max(4, height // 25)
    if min(width, height) < 40 or width + 2 * border > place.width or height + 2 * border > place.height:
        return None
    frame = Image.new("RGB", (width + 2 * border, height + 2 * border), tuple(rng.integers(0, 90, 3).tolist()))
    frame.paste(cut.resize((width, height)), (border, border))
    x, y = (int(rng.integers(0, free + 1)) for free in (place.width - frame.width, place.height - frame.height))
    place.paste(frame, (x, y))
    return Composed(Kind.POSTER, np.array(place), np.array([[x, y, x + frame.width, y + frame.height]], dtype=float))


def _statue(image: Image.Image, people: People, person: int, box: FloatArray) -> Composed:
    """Take the colour and the fine detail of the person away."""
    mask = _body_mask(image.size, people, person, box, 0.12)
    grey = np.asarray(image.convert("L").filter(ImageFilter.MedianFilter(5)), float)
    stone = (0.55 * grey + 85)[..., None] * np.array([1.0, 0.985, 0.94])
    made = Image.composite(Image.fromarray(stone.clip(0, 255).astype(np.uint8)), image, mask)
    return Composed(Kind.STATUE, np.array(made), box[None])


def body_mask(pixels: RGBArray, people: People, person: int, soft: float) -> FloatArray:
    """Return where a person's body is, shape (H, W), 0..1: limbs as thick as bodies are, and a disc for the head.

    soft: how far its edge is blurred, in thicknesses of a limb.
    """
    size = pixels.shape[1], pixels.shape[0]
    box = people.boxes_px[person].clip(0, np.tile(size, 2))
    return np.asarray(_body_mask(size, people, person, box, soft), dtype=float) / 255


def _body_mask(size: tuple[int, int], people: People, person: int, box: FloatArray, soft: float) -> Image.Image:
    mask = Image.new("L", size, 0)
    draw = ImageDraw.Draw(mask)
    thick = max(6, round(0.3 * min(box[2] - box[0], box[3] - box[1])))
    for a, b in people.skeleton.bones:
        ends = np.stack([people.joint(a)[person], people.joint(b)[person]])
        if np.isfinite(ends).all():
            draw.line([tuple(end) for end in ends.tolist()], fill=255, width=thick)
    head, radius = people.part("Head")[person], 0.09 * (box[3] - box[1])
    if np.isfinite(head).all():
        draw.ellipse([*(head - (radius, 1.2 * radius)), *(head + (radius, radius))], fill=255)
    return mask.filter(ImageFilter.GaussianBlur(max(2.0, soft * thick)))


def _mirrored(image: Image.Image, box: FloatArray) -> Composed | None:
    """Put the person's mirror image beside the person, on the side where there is room."""
    x0, y0, x1, y1 = box.round().astype(int).tolist()
    gap = round(0.05 * (x1 - x0))
    x = x1 + gap if 2 * x1 - x0 + gap <= image.width else 2 * x0 - x1 - gap
    if x < 0:
        return None
    made = image.copy()
    made.paste(image.crop((x0, y0, x1, y1)).transpose(Image.Transpose.FLIP_LEFT_RIGHT), (x, y0))
    beside = np.array([x, y0, x + x1 - x0, y1], dtype=float)
    return Composed(Kind.MIRRORED, np.array(made), np.stack([box, beside]))


def _twice(image: Image.Image, box: FloatArray, kind: Kind, aside: float, factor: float) -> Composed:
    """Lay the person half transparently beside the person, as in a double exposure."""
    shift = round(aside * (box[2] - box[0]))
    shift = shift if box[2] + shift < image.width else -shift
    middle = (box[:2] + box[2:]) / 2
    size = (round(image.width * factor), round(image.height * factor))
    offset = np.round(middle - factor * middle).astype(int).tolist()
    other = image.copy()
    other.paste(image.resize(size), tuple(offset))
    shown = np.concatenate([middle + factor * (box[:2] - middle), middle + factor * (box[2:] - middle)])
    mask = Image.new("L", image.size, 0)
    ImageDraw.Draw(mask).rectangle(shown.tolist(), fill=128)
    mask = mask.filter(ImageFilter.GaussianBlur(max(2.0, 0.03 * float(box[2] - box[0]))))
    made = Image.composite(ImageChops.offset(other, shift, 0), image, ImageChops.offset(mask, shift, 0))
    return Composed(kind, np.array(made), np.stack([box, shown + np.array([shift, 0, shift, 0])]))
