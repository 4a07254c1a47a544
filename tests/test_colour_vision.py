"""The zones' colours stay apart for people who lack one kind of cone."""

import itertools

import numpy as np
import pytest

from proxemetry.arrays import FloatArray
from proxemetry.plots.pair_selection import PERSON_COLOURS
from proxemetry.plots.zone_colours import ZONE_COLOURS

#: Machado, Oliveira and Fernandes 2009, severity 1.0, for linear RGB.
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array([
        (0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998),
    ]),
    "deuteranopia": np.array([
        (0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881),
    ]),
    "tritanopia": np.array([
        (1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900),
    ]),
}  # fmt: skip
#: Linear sRGB to XYZ, and its white (IEC 61966-2-1, D65).
XYZ = np.array([
    (0.4124564, 0.3575761, 0.1804375), (0.2126729, 0.7151522, 0.0721750), (0.0193339, 0.1191920, 0.9503041),
])  # fmt: skip
WHITE = XYZ.sum(axis=1)
#: A difference of 2.3 is just noticed side by side; lines in a photo are thin, and far from the legend.
CLEARLY_APART = 18


def linear(colour: str) -> FloatArray:
    values = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def lab(colour: str, vision: FloatArray) -> FloatArray:
    relative = XYZ @ np.clip(vision @ linear(colour), 0, 1) / WHITE
    root = np.where(relative > 216 / 24389, np.cbrt(relative), (24389 / 27 * relative + 16) / 116)
    return np.array([116 * root[1] - 16, 500 * (root[0] - root[1]), 200 * (root[1] - root[2])])


def ciede2000(one: FloatArray, other: FloatArray) -> float:
    """Return the difference of two colours (Sharma, Wu and Dalal 2005)."""
    lightness, a, b = np.array([one, other]).T
    chroma = np.hypot(a, b).mean()
    a = a * (1.5 - 0.5 * np.sqrt(chroma**7 / (chroma**7 + 25**7)))
    chromas, hues = np.hypot(a, b), np.degrees(np.arctan2(b, a))
    turn = (hues[1] - hues[0] + 180) % 360 - 180
    d_lightness, d_chroma = np.diff(lightness)[0], np.diff(chromas)[0]
    d_hue = 2 * np.sqrt(chromas.prod()) * np.sin(np.radians(turn) / 2)
    mean, chroma, hue = lightness.mean(), chromas.mean(), (hues[0] + turn / 2) % 360
    weight = 1 + sum(k * np.cos(np.radians(n * hue + p))
                     for k, n, p in ((-0.17, 1, -30), (0.24, 2, 0), (0.32, 3, 6), (-0.2, 4, -63)))  # fmt: skip
    lightness_part = d_lightness / (1 + 0.015 * (mean - 50) ** 2 / np.sqrt(20 + (mean - 50) ** 2))
    chroma_part, hue_part = d_chroma / (1 + 0.045 * chroma), d_hue / (1 + 0.015 * chroma * weight)
    rotation = -2 * np.sqrt(chroma**7 / (chroma**7 + 25**7)) * np.sin(
        np.radians(60 * np.exp(-(((hue - 275) / 25) ** 2)))
    )  # fmt: skip
    return float(np.sqrt(lightness_part**2 + chroma_part**2 + hue_part**2 + rotation * chroma_part * hue_part))


@pytest.mark.parametrize(("one", "other", "difference"), [
    ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425), ((50, 2.5, 0), (73, 25, -18), 27.1492),
    ((50, 2.5, 0), (50, 0, -2.5), 4.3065), ((2.0776, 0.0795, -1.1350), (0.9033, -0.0636, -0.5514), 0.9082),
])  # fmt: skip
def test_the_difference_is_the_published_one(one, other, difference):
    """Rows of Sharma, Wu and Dalal 2005, table 1."""
    assert ciede2000(np.array(one, float), np.array(other, float)) == pytest.approx(difference, abs=1e-4)


@pytest.mark.parametrize("vision", VISION)
def test_zones_are_told_apart(vision):
    seen = {zone: lab(colour, VISION[vision]) for zone, colour in ZONE_COLOURS.items()}
    differences = {pair: ciede2000(*(seen[zone] for zone in pair)) for pair in itertools.combinations(seen, 2)}
    assert min(differences.values()) > CLEARLY_APART, sorted(differences.items(), key=lambda item: item[1])[0]


def test_no_person_has_the_colour_of_a_zone():
    zones = [lab(colour, VISION["normal"]) for colour in ZONE_COLOURS.values()]
    assert min(ciede2000(lab(c, VISION["normal"]), zone) for c in PERSON_COLOURS for zone in zones) > CLEARLY_APART
