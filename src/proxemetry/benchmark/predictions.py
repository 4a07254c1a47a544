"""What a method answers, as values: a photo's answer, and all answers found by the photos' names."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..arrays import FloatArray
from ..errors import LabelsError
from ..people.skeleton import PARTS


@dataclass(frozen=True, eq=False)
class Prediction:
    """One photo's answer for P people.

    width, height: of the image that the points are in, None for the label's own size. points_px: shape (P, 4, 2) in
    the order of `skeleton.PARTS`, NaN where not given. positions_mm: shape (P, 3), NaN rows where not given.
    distances_mm: shape (P, P), NaN where not given, or None where the image gives positions alone. low_mm, high_mm:
    shape (P, P), NaN where not given. up: unit vector, None where the camera's own (0, -1, 0) is meant.
    """

    filename: str
    width: float | None
    height: float | None
    points_px: FloatArray
    positions_mm: FloatArray
    distances_mm: FloatArray | None
    low_mm: FloatArray
    high_mm: FloatArray
    up: FloatArray | None = None

    @classmethod
    def nobody(cls, filename: str) -> Prediction:
        """Return the prediction that the photo has no people."""
        none = np.zeros((0, 0))
        return cls(filename, None, None, np.zeros((0, len(PARTS), 2)), np.zeros((0, 3)), None, none, none)

    def __len__(self) -> int:
        return len(self.points_px)

    @property
    def has_positions(self) -> bool:
        """Whether any person has a position."""
        return bool(np.isfinite(self.positions_mm).all(axis=1).any())

    def by_distances(self) -> Prediction:
        """Return the answer with its stated distances in place of positions, of the people who have a position.

        The published protocol (Seker et al. 2021, section 3.3) takes one or the other. An answer without stated
        distances between all of two or more people stays as it is.
        """
        kept = np.flatnonzero(np.isfinite(self.positions_mm).all(axis=1))
        if self.distances_mm is None or len(kept) < 2:
            return self
        stated = self.distances_mm[np.ix_(kept, kept)]
        if not np.isfinite(stated[np.triu_indices(len(kept), 1)]).all():
            return self
        pairs = np.ix_(kept, kept)
        return replace(
            self, points_px=self.points_px[kept], positions_mm=np.full((len(kept), 3), np.nan), distances_mm=stated,
            low_mm=self.low_mm[pairs], high_mm=self.high_mm[pairs],
        )  # fmt: skip

    def points_at(self, width: int, height: int) -> FloatArray:
        """Return the points in pixels of the same photo at another size."""
        return self.points_px * (width / (self.width or width), height / (self.height or height))

    def ground_distances_mm(self) -> FloatArray:
        """Shape (P, P): distances along the ground: those given, else between positions with `up` taken out."""
        if self.distances_mm is not None:
            return self.distances_mm
        up = np.array([0.0, -1.0, 0.0]) if self.up is None else self.up
        flat = self.positions_mm - np.outer(self.positions_mm @ up, up)
        return np.linalg.norm(flat[:, None] - flat[None], axis=-1)

    def spatial_distances_mm(self) -> FloatArray:
        """Shape (P, P): distances in space between positions; those given where there are no positions."""
        if self.distances_mm is not None and not self.has_positions:
            return self.distances_mm
        return np.linalg.norm(self.positions_mm[:, None] - self.positions_mm[None], axis=-1)


@dataclass(frozen=True, eq=False)
class Predictions:
    """All answers of a method. Photos are found by their name, however a path or its case is spelled."""

    images: tuple[Prediction, ...]
    source: str
    _by_key: dict[str, list[Prediction]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        index: dict[str, list[Prediction]] = {}
        for image in self.images:
            for key in _keys(image.filename):
                index.setdefault(key, []).append(image)
        names = [image.filename for image in self.images]
        if len(set(names)) < len(names):
            twice = next(name for k, name in enumerate(names) if name in names[:k])
            raise LabelsError(f"{self.source}: photo {twice} is answered twice: give one answer a photo")
        object.__setattr__(self, "_by_key", index)

    def __iter__(self) -> Iterator[Prediction]:
        return iter(self.images)

    @property
    def states_distances(self) -> bool:
        """Whether any answer states distances as well as positions."""
        return any(image.distances_mm is not None and image.has_positions for image in self)

    def by_distances(self) -> Predictions:
        """Return the same answers with stated distances in place of positions (see `Prediction.by_distances`)."""
        return Predictions(tuple(image.by_distances() for image in self), f"{self.source}, by stated distances")

    def named(self, filename: str) -> Prediction | None:
        """Return the answer for a photo, None where there is none; raises LabelsError where two names would fit."""
        for key in _keys(filename):
            found = {id(image): image for image in self._by_key.get(key, ())}
            exact = [image for image in found.values() if image.filename == filename]
            if exact:
                return exact[0]
            if len(found) > 1:
                names = " and ".join(sorted(image.filename for image in found.values()))
                raise LabelsError(f"{self.source}: both {names} could be {filename}: name one of them exactly so")
            if found:
                return next(iter(found.values()))
        return None


def _keys(filename: str) -> tuple[str, ...]:
    """The spellings under which a photo is looked for, the strictest first."""
    base = filename.replace("\\", "/").rsplit("/", 1)[-1]
    return tuple(dict.fromkeys((filename, base, base.lower())))


def by_stated_distances(answers: Mapping[str, Predictions]) -> dict[str, Predictions]:
    """Return methods that state distances by those, as the published protocol allows, and by positions too."""
    both: dict[str, Predictions] = {}
    for method, given in answers.items():
        both[method] = given.by_distances() if given.states_distances else given
        if given.states_distances:
            both[f"{method}-positions"] = given
    return both
