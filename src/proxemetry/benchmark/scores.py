"""The score of a method: protocol, labels, every photo, the whole and its groups."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import LabelsError, SettingsError
from ..files import cell_of
from . import seker2021, v1
from .image_score import ImageScore
from .labels import LabelImage, Labels, read_labels
from .metrics import Summary, summarise
from .predictions import Prediction, Predictions
from .reading import read_predictions


@dataclass(frozen=True)
class Protocol:
    """How photos are scored: on which labels, by which function, and how rates are averaged."""

    name: str
    errata: bool
    score_image: Callable[..., ImageScore]
    rates_over_images: bool
    about: str


PROTOCOLS = {
    "v1": Protocol("v1", True, v1.score_image, False, "one-to-one matching, ground distances"),
    "seker2021": Protocol("seker2021", False, seker2021.score_image, True, "as published, peculiarities included"),
}
DEFAULT_PROTOCOL = "v1"
#: Pictures whose sides' ratios differ by less are one picture resized: networks want sides of multiples of 32 pixels.
_SAME_SHAPE = 0.05


@dataclass(frozen=True, eq=False)
class Group:
    """The photos that share a focal length, a setting or a camera, as `by` names it."""

    by: str
    name: str
    summary: Summary


@dataclass(frozen=True, eq=False)
class Score:
    """What a method scores on a set of labels under a protocol.

    n_extra: answered photos that have no labels. n_unanswered: labelled photos that have no answer. n_misshapen:
    answers for a picture of another shape than the labelled one, so that points lie elsewhere in it. n_outside: answers
    with most of their points outside the picture that they are for.
    """

    protocol: str
    labels: str
    predictions: str
    images: tuple[ImageScore, ...]
    overall: Summary
    groups: tuple[Group, ...]
    n_extra: int = 0
    n_unanswered: int = 0
    n_misshapen: int = 0
    n_outside: int = 0

    @property
    def caption(self) -> str:
        """The heading of every table of this score, so that no number goes without its protocol."""
        o = self.overall
        extra = f", {_photos(self.n_unanswered)} without an answer" if self.n_unanswered else ""
        extra += f", {_photos(self.n_extra, 'answered ')} without labels ignored" if self.n_extra else ""
        return (
            f"protocol {self.protocol} ({PROTOCOLS[self.protocol].about}); labels {self.labels}; "
            f"{_photos(o.n_images)}, {o.n_pairs} of {o.n_annotated_pairs} pairs, "
            f"{_photos(o.n_unscored)} unscored{extra}"
        )

    def select(self, keep: Callable[[LabelImage], bool]) -> Summary:
        """Sum up the photos that `keep` takes."""
        return _summary(self.protocol, [image for image in self.images if keep(image.label)], bootstrap=False)

    def to_dict(self) -> dict[str, Any]:
        """Return the content of the score file."""
        return {
            "protocol": self.protocol,
            "labels": self.labels,
            "predictions": self.predictions,
            "images": [image.to_dict() for image in self.images],
            "overall": self.overall.to_dict(),
            "groups": [{"by": g.by, "name": g.name, **g.summary.to_dict()} for g in self.groups],
        }

    def to_json(self) -> str:
        """Return the score file's text."""
        return json.dumps(self.to_dict(), allow_nan=False, indent=1) + "\n"

    def to_csv(self) -> str:
        """Return one row a photo with its group."""
        output = io.StringIO()
        rows = [
            {**image.to_dict(), "filename": cell_of(image.label.filename), "setting": cell_of(image.label.setting),
             "camera": cell_of(image.label.camera),
             "focal_mm": "" if math.isnan(image.label.focal_mm) else image.label.focal_mm}
            for image in self.images
        ]  # fmt: skip
        writer = csv.DictWriter(output, list(rows[0]) if rows else ["filename"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return output.getvalue()


def score(labels: Labels, predictions: Predictions, protocol: str = DEFAULT_PROTOCOL) -> Score:
    """Score a method's answers; raises SettingsError for an unknown protocol, LabelsError where no photo is labelled.

    Every labelled photo counts, answered or not; an empty list of answers is one too. `labels` are taken as they are:
    `score_files` picks errata or none as the protocol requires.
    """
    chosen = protocol_named(protocol)
    answers = [predictions.named(image.filename) for image in labels]
    images = tuple(chosen.score_image(image, answer) for image, answer in zip(labels, answers, strict=True))
    used = {id(answer) for answer in answers}
    n_extra = sum(id(answer) not in used for answer in predictions)
    if n_extra and n_extra == len(predictions.images):
        raise LabelsError(
            f"{predictions.source}: none of its {n_extra} photos is labelled: it names "
            f"{predictions.images[0].filename}, the labels {next(iter(labels)).filename if len(labels) else 'nothing'}"
        )
    return Score(
        protocol,
        labels.description,
        predictions.source,
        images,
        _summary(protocol, images, bootstrap=True),
        tuple(_groups(protocol, images)),
        n_extra,
        sum(answer is None for answer in answers),
        sum(_is_misshapen(image, answer) for image, answer in zip(labels, answers, strict=True)),
        sum(_is_outside(image, answer) for image, answer in zip(labels, answers, strict=True)),
    )


def _is_misshapen(image: LabelImage, answer: Prediction | None) -> bool:
    """Return whether an answer's picture has another shape than the label's, rounding to whole pixels aside."""
    if answer is None or answer.width is None or answer.height is None:
        return False
    expected = answer.width * image.height / image.width
    return abs(answer.height - expected) > 1 + _SAME_SHAPE * expected


def _is_outside(image: LabelImage, answer: Prediction | None) -> bool:
    """Return whether most points lie outside the answer's picture, which then has another size than it states."""
    if answer is None:
        return False
    points = answer.points_px[np.isfinite(answer.points_px).all(axis=-1)]
    size = np.array([answer.width or image.width, answer.height or image.height])
    outside = ((points < 0) | (points > size)).any(axis=-1)
    return 2 * int(outside.sum()) > len(points)


def _photos(count: int, which: str = "") -> str:
    return f"{count} {which}photo{'' if count == 1 else 's'}"


def score_files(predictions: str | Path, labels: str | Path, protocol: str = DEFAULT_PROTOCOL) -> Score:
    """Score a prediction file or results folder against a labels folder; raises LabelsError, SettingsError."""
    chosen = protocol_named(protocol)
    return score(read_labels(labels, errata=chosen.errata), read_predictions(predictions), protocol)


def protocol_named(name: str) -> Protocol:
    """Return a protocol; raises SettingsError for a name that is not in `PROTOCOLS`."""
    if name not in PROTOCOLS:
        raise SettingsError(f"protocol {name!r} is unknown: use one of {', '.join(PROTOCOLS)}")
    return PROTOCOLS[name]


def _summary(protocol: str, images: Iterable[ImageScore], bootstrap: bool) -> Summary:
    return summarise(tuple(images), PROTOCOLS[protocol].rates_over_images, bootstrap)


def _groups(protocol: str, images: tuple[ImageScore, ...]) -> Iterable[Group]:
    """Yield the groups of each kind in the order of their names; photos of unknown focal length are in none."""
    kinds: dict[str, Callable[[LabelImage], tuple[float, str] | None]] = {
        "focal_mm": lambda i: None if math.isnan(i.focal_mm) else (i.focal_mm, f"{i.focal_mm:g}"),
        "setting": lambda i: (0.0, i.setting),
        "camera": lambda i: (0.0, f"{i.setting} {i.camera}"),
    }
    for by, key in kinds.items():
        names = sorted({found for image in images if (found := key(image.label)) is not None})
        for found in names:
            members = [image for image in images if key(image.label) == found]
            yield Group(by, found[1], _summary(protocol, members, bootstrap=False))
