"""What was annotated, as values: people and their points on each photo, shoots with what was measured in them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from .places import Places, Spot, Tape, solve


def number_of(tag: str) -> int:
    """Return the number of a tag as "P3" or "C0" is one."""
    return int(tag[1:])


def in_order(tags: Iterable[str]) -> list[str]:
    """Return tags with cameras first, each kind by number."""
    return sorted(tags, key=lambda tag: (tag[0], number_of(tag)))


@dataclass(frozen=True)
class Person:
    """A person on a photo. key: distinguishes the people on a photo. tag: who it is ("P3"), None while unnamed.

    points: part -> whole pixel of the upright full-size photo, only the parts that are annotated. by: who set the
    points first, a back end's name or "" for a person. read: what else a file of another tool says of them, as JSON
    values: joints, box, score, attributes, and under `beside` what is not used.
    """

    key: int
    tag: str | None = None
    points: Mapping[str, tuple[int, int]] = field(default_factory=dict[str, tuple[int, int]])
    by: str = ""
    read: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Lens:
    """A focal length and the sensor's long and short side, millimetres; equivalent: it is a 35 mm equivalent."""

    focal_mm: float
    sensor_mm: tuple[float, float]
    equivalent: bool = False


@dataclass(frozen=True)
class PhotoNotes:
    """What is annotated on one photo. shoot, camera: where it belongs. lens: as stated, None for the file's own.

    proposed: the back end whose people were taken in, None before. done: its annotator is content. skipped: it is left
    out of the benchmark. read: what a file of another tool has of the photo beside its people, as JSON values.
    """

    people: tuple[Person, ...] = ()
    shoot: int = 0
    camera: str = "C0"
    lens: Lens | None = None
    proposed: str | None = None
    done: bool = False
    skipped: bool = False
    read: Mapping[str, Any] | None = None

    def person(self, key: int) -> Person | None:
        """Return the person of that key."""
        return next((person for person in self.people if person.key == key), None)

    @property
    def named(self) -> tuple[Person, ...]:
        """The people who count: with a name and a point, by number."""
        return tuple(sorted((p for p in self.people if p.tag and p.points), key=lambda p: number_of(p.tag or "")))


@dataclass(frozen=True)
class Shoot:
    """Photos during which everyone stayed in place. name: as results call it, "" for its number.

    camera_names: camera tag -> what the annotator calls that place. sd of a tape or spot: as `places` has it.
    """

    name: str = ""
    spots: Mapping[str, Spot] = field(default_factory=dict[str, Spot])
    tapes: Mapping[frozenset[str], Tape] = field(default_factory=dict[frozenset[str], Tape])
    camera_names: Mapping[str, str] = field(default_factory=dict[str, str])


@dataclass(frozen=True)
class Annotations:
    """Everything: photos by the file's hash, shoots by number, and what the annotator calls people (tag -> name)."""

    photos: Mapping[str, PhotoNotes] = field(default_factory=dict[str, PhotoNotes])
    shoots: Mapping[int, Shoot] = field(default_factory=dict[int, Shoot])
    names: Mapping[str, str] = field(default_factory=dict[str, str])

    def photo(self, sha256: str) -> PhotoNotes:
        """Return what is annotated on a photo."""
        return self.photos.get(sha256, PhotoNotes())

    def shoot(self, number: int) -> Shoot:
        """Return a shoot, a fresh one where nothing is known of it."""
        return self.shoots.get(number, Shoot())

    def counted(self, files: Iterable[str]) -> Iterator[tuple[str, PhotoNotes]]:
        """Yield the photos, of these hashes, that go into the label files."""
        for sha256 in files:
            notes = self.photo(sha256)
            if notes.named and not notes.skipped:
                yield sha256, notes

    def shoot_numbers(self, files: Iterable[str]) -> list[int]:
        """Return the shoots that photos of these hashes belong to, or of which something is known."""
        return sorted({*self.shoots, *(self.photo(sha256).shoot for sha256 in files)})

    def tags_seen(self, shoot: int, files: Iterable[str]) -> list[str]:
        """Return the people and cameras that the photos of a shoot show, in order."""
        seen: set[str] = set()
        for _, notes in self.counted(files):
            if notes.shoot == shoot:
                seen |= {notes.camera, *(p.tag for p in notes.named if p.tag)}
        return in_order(seen)

    def places(self, shoot: int, files: Iterable[str]) -> Places:
        """Return where the people and cameras of a shoot were; raises SettingsError, see `solve`."""
        known = self.shoot(shoot)
        measured = {*known.spots, *(tag for ends in known.tapes for tag in ends)}
        tags = in_order({*self.tags_seen(shoot, files), *measured})
        return _solved(tuple(tags), tuple(known.tapes.values()), tuple(known.spots.values()))


@lru_cache(maxsize=64)
def _solved(tags: tuple[str, ...], tapes: tuple[Tape, ...], spots: tuple[Spot, ...]) -> Places:
    """Solve once what every change of a point asks for again."""
    return solve(tags, tapes, spots)
