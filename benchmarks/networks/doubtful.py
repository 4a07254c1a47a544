"""How many doubtful people and how many real people are marked: on your photos and on pictures composed from them.

    python -m benchmarks.networks.doubtful --people DIR --things DIR [--pictured DIR] [--pose NAME]... [--half report]

--people: photos in which everyone found is a person (where labels say who is not, see `backends.py`). Doubtful people
are also composed from them (`composed_people`): legs behind a wall, posters, grey statues, the same person twice.
--things: pictures without people, real or pictured, some of them backgrounds for posters. --pictured:
paintings, drawings, statues, dolls. --half: photos go to the halves "choose" and "report" by their files' hashes;
thresholds are looked at on the first and counted on the second.

Per kind it prints how many people were found and the share of them that is marked, by each reason; of those who are
there twice, in how many pictures both were found and one of the two is marked.
"""

from __future__ import annotations

import argparse
import hashlib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.composed_people import TWICE, Composed, Kind, composed
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.camera.choice import PictureLines
from proxemetry.errors import PhotoError
from proxemetry.overlap import areas_of, pairwise_iou, shared_areas
from proxemetry.people import People, PoseBackend
from proxemetry.people.doubts import OF_PHOTOS, PersonDoubt, doubts_of
from proxemetry.photo import Photo, RGBArray
from proxemetry.pose import PoseOptions, backend_named

_ENDINGS = (".jpg", ".jpeg", ".png", ".webp", ".tif", ".tiff")
_SEED, _MOST_OF_A_PHOTO = 1, 1
#: A person found is the composed one where boxes overlap by this much; in a frame, or partly hidden, by this part of
#: the found one's box.
_OVERLAP, _INSIDE = 0.3, 0.6
#: People who score as much are made into something.
_CLEAR = 0.5


@dataclass
class Tally:
    """How many people of a kind were looked for, found and marked, in all and by each reason."""

    pictures: int = 0
    found: int = 0
    marked: int = 0
    reasons: Counter[PersonDoubt] = field(default_factory=Counter[PersonDoubt])

    def add(self, doubts: list[tuple[PersonDoubt, ...]]) -> None:
        """Count one picture's people of this kind."""
        self.pictures += 1
        self.found += len(doubts)
        self.marked += sum(map(bool, doubts))
        self.reasons.update(reason for reasons in doubts for reason in reasons)

    def add_twice(self, doubts: list[tuple[PersonDoubt, ...]]) -> None:
        """Count one picture of a person who is there twice: found where both were."""
        self.pictures += 1
        if len(doubts) >= 2:
            self.found += 1
            reasons = {reason for each in doubts for reason in each}
            self.marked += bool(reasons)
            self.reasons.update(reasons)


def in_half(path: Path, half: str) -> bool:
    """Whether a photo belongs to "choose" or "report", by its content; "all" takes both."""
    if half == "all":
        return True
    odd = hashlib.sha256(path.read_bytes()).digest()[0] % 2 == 1
    return odd == (half == "report")


def photos_in(folder: Path, half: str) -> Iterator[Photo]:
    """Yield the photos below a folder that can be read, in the order of their names."""
    for path in sorted(folder.rglob("*")):
        if path.suffix.lower() in _ENDINGS and path.is_file() and in_half(path, half):
            try:
                yield Photo.open(path)
            except PhotoError as error:
                print(error)


def seen_in(photo: Photo, backend: PoseBackend) -> People:
    """Return the people whom a back end sees, with who is in a frame of straight edges, as `measure` looks for it."""
    people = backend.detect(photo)
    return replace(people, framed=PictureLines(photo, people).people_in_frames()) if len(people) else people


def those_of(found: People, made: Composed) -> NDArray[np.intp]:
    """Return the rows of the people found that are the composed ones."""
    if made.kind in (Kind.POSTER, Kind.LEGS, Kind.HEAD):
        area = shared_areas(found.boxes_px, made.boxes_px[:1])[:, 0]
        return np.flatnonzero(area / np.maximum(areas_of(found.boxes_px), 1e-9) > _INSIDE)
    boxes = made.boxes_px[-1:] if made.kind is Kind.MIRRORED else made.boxes_px
    overlap = np.nan_to_num(pairwise_iou(found.boxes_px, boxes))
    return np.flatnonzero((overlap > (0.5 if made.kind in TWICE else _OVERLAP)).any(axis=1))


def measured(backend: PoseBackend, args: argparse.Namespace) -> dict[str, Tally]:
    """Return the tallies of all kinds for one back end."""
    rng = np.random.default_rng(_SEED)
    tallies = {"real people": Tally(), "things and places": Tally(), "painted, drawn, carved": Tally()}
    tallies |= {kind.value: Tally() for kind in Kind}
    places: list[RGBArray] = []
    for photo in photos_in(args.things, args.half):
        tallies["things and places"].add(list(doubts_of(seen_in(photo, backend))))
        if len(places) < 20 and min(photo.width, photo.height) >= 400:
            places.append(photo.pixels(1200))
    if args.pictured is not None:
        for photo in photos_in(args.pictured, args.half):
            tallies["painted, drawn, carved"].add(list(doubts_of(seen_in(photo, backend))))
    for photo in photos_in(args.people, args.half):
        people = seen_in(photo, backend)
        tallies["real people"].add(list(doubts_of(people)))
        heights = people.boxes_px[:, 3] - people.boxes_px[:, 1]
        clear = [int(row) for row in np.argsort(-heights) if people.person_scores[row] >= _CLEAR][:_MOST_OF_A_PHOTO]
        for row in clear if places else ():
            background = places[int(rng.integers(len(places)))]
            for made in composed(photo.pixels(), people, row, background, rng):
                if made.kind.value in args.kind or not args.kind:
                    _count(tallies[made.kind.value], backend, made)
    return tallies


def _count(tally: Tally, backend: PoseBackend, made: Composed) -> None:
    found = seen_in(Photo.from_array(made.pixels), backend)
    doubts = doubts_of(found)
    of_these = [doubts[row] for row in those_of(found, made)]
    if made.kind in TWICE:
        tally.add_twice(of_these)
    else:
        tally.add(of_these)


def table(name: str, tallies: dict[str, Tally]) -> str:
    """Return the figures of one back end as rows of a Markdown table."""
    rows: list[str] = []
    for kind, tally in tallies.items():
        if tally.pictures:
            share = f"{tally.marked} ({100 * tally.marked / tally.found:.1f} %)" if tally.found else "-"
            each = " | ".join(str(tally.reasons[reason]) for reason in OF_PHOTOS)
            rows.append(f"| `{name}` | {kind} | {tally.pictures} | {tally.found} | {share} | {each} |")
    return "\n".join(rows)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--people", type=Path, required=True)
    parser.add_argument("--things", type=Path, required=True)
    parser.add_argument("--pictured", type=Path)
    parser.add_argument("--pose", action="append", help="default: yolox-tinypose")
    parser.add_argument("--half", choices=("choose", "report", "all"), default="all")
    parser.add_argument("--kind", action="append", default=[], choices=[kind.value for kind in Kind])
    add_models_option(parser)
    args = parser.parse_args()
    print(f"| back end | kind | pictures | found | marked | {' | '.join(OF_PHOTOS)} |")
    print(f"| --- | --- | ---: | ---: | ---: |{' ---: |' * len(OF_PHOTOS)}")
    for name in args.pose or ["yolox-tinypose"]:
        print(table(name, measured(backend_named(name, PoseOptions()), args)), flush=True)


if __name__ == "__main__":
    main()
