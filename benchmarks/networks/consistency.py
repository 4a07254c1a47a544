"""Do intervals hold where the same photo is measured twice? Real photos; no truth is needed.

    python -m benchmarks.networks.consistency [--photos DIR ...] [--models DIR] [--pose A,B] \\
        [--write docs/backends_measured.md]

A second look shows the photo's mirror image, its mirror image at 0.7 of the size, half the size, 0.7 of the size, moved
by a few pixels, or without a margin; or another back end is used. Both looks are placed with the same camera (the
assumed one where the photo states none), and their people are paired. The table gives the share of near pairs (nearer
than 3.66 m, the end of Hall's social zone) whose second distance lies in the first's 90 % interval, and the reverse;
how wide the intervals are; and the share of headings that agree within 1.645 of the larger of their standard
deviations.

Errors that both looks share do not show: a share of 90 % is necessary, not sufficient. Two looks that differ by at most
half of what each states (the other half is the uncertainty about bodies) lie in each other's interval more often than
90 %.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.camera import Camera
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.distances import Distances, measure_distances
from proxemetry.locate import LocateSettings, method_named
from proxemetry.people import People, PoseBackend
from proxemetry.photo import EXTENSIONS, Photo, RGBArray
from proxemetry.pose import PoseOptions, available, backend_named
from proxemetry.pose.confirmation import closeness

FloatArray = NDArray[np.float64]

PHOTOS = (Path("../shared/data/photos"), Path("../shared/data/labelled_people"))
START, END = "<!-- consistency -->", "<!-- end of consistency -->"
#: The end of Hall's social zone.
NEAR_M = 3.66
#: The field of view that is assumed where a photo says nothing: a 28 mm lens's.
ASSUMED = FocalRequest(assume_fov_deg=65.5)
_TO_90 = 1.645
#: Two skeletons are of one person where they agree this well, of 1.
_SAME = 0.5
_MARGIN = (0.08, 0.06, 0.04, 0.03)
_MOVED_PX = (7, 3)


@dataclass(frozen=True, eq=False)
class Look:
    """People as seen in a photo shown in one way, and the camera of what was shown.

    scale, corner_px: the photo's pixels are those of the people over `scale`, plus `corner_px`.
    """

    kind: str
    people: People
    camera: Camera
    scale: float = 1.0
    corner_px: tuple[int, int] = (0, 0)

    def in_photo(self) -> People:
        """Return the people in pixels of the photo."""
        people = self.people.scaled(1 / self.scale, 1 / self.scale)
        shift = np.array(self.corner_px, dtype=float)
        return replace(people, keypoints_px=people.keypoints_px + shift, boxes_px=people.boxes_px + np.tile(shift, 2))


def looks_at(photo: Photo, backend: PoseBackend) -> Iterator[Look]:
    """Yield the first look at a photo and then the others."""
    pixels = photo.pixels()
    camera = estimate_camera(photo, ASSUMED).camera
    assert camera is not None
    height, width = pixels.shape[:2]
    yield Look("first", _seen(backend, pixels), camera)
    yield Look("mirrored", _mirrored(backend, pixels), camera)
    for kind, scale, mirrored in (("mirrored, 0.7", 0.7, True), ("0.7", 0.7, False), ("half size", 0.5, False)):
        size = round(scale * width), round(scale * height)
        small = np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
        people = (_mirrored if mirrored else _seen)(backend, small)
        yield Look(kind, people, camera.resized(*size), size[0] / width)
    x, y = _MOVED_PX
    yield _cut("moved", backend, pixels, camera, (x, y, width, height))
    left, top, right, bottom = (round(m * side) for m, side in zip(_MARGIN, (width, height) * 2, strict=True))
    yield _cut("cropped", backend, pixels, camera, (left, top, width - right, height - bottom))


def _seen(backend: PoseBackend, pixels: RGBArray) -> People:
    return backend.detect(Photo.from_array(np.ascontiguousarray(pixels)))


def _mirrored(backend: PoseBackend, pixels: RGBArray) -> People:
    return _seen(backend, pixels[:, ::-1]).mirrored(pixels.shape[1])


def _cut(kind: str, backend: PoseBackend, pixels: RGBArray, camera: Camera, box: tuple[int, int, int, int]) -> Look:
    x0, y0, x1, y1 = box
    return Look(kind, _seen(backend, pixels[y0:y1, x0:x1]), camera.cropped(*box), corner_px=(x0, y0))


@dataclass(frozen=True, eq=False)
class Agreement:
    """What two looks say of the same pairs and people.

    there, back: for each near pair whether the second's distance lies in the first's interval, and the reverse. width:
    the first's interval, over its distance. headings: for each person whether the headings agree within 90 %. depth:
    for each person the second's depth over the first's.
    """

    there: NDArray[np.bool_]
    back: NDArray[np.bool_]
    width: FloatArray
    headings: NDArray[np.bool_]
    depth: FloatArray

    @classmethod
    def of_all(cls, several: Sequence[Agreement]) -> Agreement:
        """Return all pairs and people of several photos."""
        return cls(*(
            np.concatenate([np.zeros(0, dtype), *(getattr(one, name) for one in several)])
            for name, dtype in (("there", bool), ("back", bool), ("width", float), ("headings", bool), ("depth", float))
        ))  # fmt: skip

    def cells(self) -> list[str]:
        """Return a row of the table: pairs, shares in percent, width in percent, people, headings, depth's ratio."""
        if not len(self.there):
            return ["0", *["–"] * 6]
        shares = (f"{100 * part.mean():.0f}" for part in (self.there, self.back))
        width = f"{100 * np.median(self.width):.0f}"
        depth = np.log(self.depth)
        return [
            str(len(self.there)), *shares, width, str(len(self.headings)), f"{100 * self.headings.mean():.0f}",
            f"{np.exp(np.median(depth)):.2f} ({100 * 1.4826 * np.median(np.abs(depth - np.median(depth))):.0f} %)",
        ]  # fmt: skip


def compared(first: Look, second: Look) -> Agreement:
    """Return how far two looks agree on the people whom both see."""
    pairs = np.array(same_people(first.in_photo(), second.in_photo()), dtype=np.intp).reshape(-1, 2)
    bodies = [method_named("scene")(look.people, look.camera, LocateSettings()) for look in (first, second)]
    known = bodies[0].placed[pairs[:, 0]] & bodies[1].placed[pairs[:, 1]]
    ours, theirs = pairs[known].T
    distances = [measure_distances(b) for b in bodies]
    there, back, width = _pairs(distances, ours, theirs)
    turn = bodies[1].heading_rad[theirs] - bodies[0].heading_rad[ours]
    apart = np.abs(np.angle(np.exp(1j * turn)))
    sd = np.maximum(bodies[0].heading_sd_rad[ours], bodies[1].heading_sd_rad[theirs])
    depth = bodies[1].positions_m[theirs, 2] / bodies[0].positions_m[ours, 2]
    return Agreement(there, back, width, apart <= _TO_90 * sd, depth)


def _pairs(
    distances: Sequence[Distances], ours: NDArray[np.intp], theirs: NDArray[np.intp]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_], FloatArray]:
    a, b = np.triu_indices(len(ours), 1)
    at = (ours[a], ours[b]), (theirs[a], theirs[b])
    found = [d.distance_m[index] for d, index in zip(distances, at, strict=True)]
    low = [d.low_m[index] for d, index in zip(distances, at, strict=True)]
    high = [d.high_m[index] for d, index in zip(distances, at, strict=True)]
    near = found[0] < NEAR_M
    there = (found[1] >= low[0]) & (found[1] <= high[0])
    back = (found[0] >= low[1]) & (found[0] <= high[1])
    return there[near], back[near], ((high[0] - low[0]) / found[0])[near]


def same_people(first: People, second: People) -> list[tuple[int, int]]:
    """Return rows of the same person in two looks, each other's nearest."""
    if not len(first) or not len(second):
        return []
    near = closeness(first, second)
    best = near.argmax(axis=1)
    return [
        (row, int(column))
        for row, column in enumerate(best)
        if near[row, column] >= _SAME and near[:, column].argmax() == row
    ]


def photos_below(folders: Sequence[Path]) -> list[Path]:
    """Return the photos of folders and of the folders in them."""
    return [p for folder in folders for p in sorted(folder.rglob("*")) if p.suffix.lower() in EXTENSIONS]


def table(photos: Sequence[Path], backends: Sequence[PoseBackend]) -> list[list[str]]:
    """Return the rows of the table, back end by back end and kind by kind."""
    found: dict[tuple[str, str], list[Agreement]] = {}
    for path in photos:
        photo = Photo.open(path)
        for key, agreement in agreements({b.name: list(looks_at(photo, b)) for b in backends}):
            found.setdefault(key, []).append(agreement)
    return table_rows(found)


def agreements(looks: Mapping[str, Sequence[Look]]) -> Iterator[tuple[tuple[str, str], Agreement]]:
    """Yield back end, kind and agreement of one photo's looks, the first one's with every other look."""
    for name, (first, *others) in looks.items():
        for other in others:
            yield (name, other.kind), compared(first, other)
        for second, (seen, *_) in looks.items():
            if second != name:
                yield (name, f"`{second}`"), compared(first, seen)


def table_rows(found: Mapping[tuple[str, str], Sequence[Agreement]]) -> list[list[str]]:
    """Return the rows of the table: each back end's kinds, and all looks of its own together."""
    rows: list[list[str]] = []
    for backend in dict.fromkeys(name for name, _ in found):
        kinds = {kind: all_ for (name, kind), all_ in found.items() if name == backend}
        own = [one for kind, all_ in kinds.items() if not kind.startswith("`") for one in all_]
        for kind, all_ in (*kinds.items(), ("**all of its own**", own)):
            rows.append([f"`{backend}`", kind, *Agreement.of_all(all_).cells()])
    return rows


HEAD = [
    "back end", "second look", "near pairs", "second in first's, %", "first in second's, %", "width, %", "people",
    "headings, %", "depth's ratio (spread)",
]  # fmt: skip


def markdown(rows: Sequence[Sequence[str]]) -> str:
    """Return the table as Markdown."""
    lines = [HEAD, ["---", "---", *["---:"] * (len(HEAD) - 2)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def written(page: str, text: str) -> str:
    """Return a page with the text between its marks; raises ValueError where it has none."""
    before, start, rest = page.partition(START)
    _, end, after = rest.partition(END)
    if not (start and end):
        raise ValueError(f"the page lacks the marks {START} and {END}")
    return f"{before}{START}\n{text}\n{END}{after}"


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, nargs="+", default=PHOTOS)
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    parser.add_argument("--effort", default="normal")
    parser.add_argument("--write", type=Path, metavar="PAGE", help=f"put the table between {START} and {END}")
    args = parser.parse_args()
    names = args.pose.split(",") if args.pose else available()
    backends = [backend_named(name, PoseOptions(effort=args.effort)) for name in names]
    text = markdown(table(photos_below(args.photos), backends))
    print(text)
    if args.write:
        args.write.write_text(written(args.write.read_text(encoding="utf-8"), text), encoding="utf-8")


if __name__ == "__main__":
    main()
