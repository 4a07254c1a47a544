"""The content of a keypoint file on one photo, and how its numbers become People."""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...camera import Camera
from ...errors import KeypointsError, ProxemetryError
from ...people import People
from ...people.attributes import Attributes, attributes_of
from ...people.skeleton import COCO_17, HALPE_26, Skeleton
from ...photo import LARGEST_PX
from ..bare_arrays import BY_COUNT, WHOLE_BODIES, are_fractions, skeleton_of
from .beside import EXTRA_JOINTS, TAKEN, Beside

#: The source of recorded people, for weighing joints: a detector that was not measured.
SOURCE = "recorded"

#: Other names of the same joints, as the common files spell them.
_ALIASES = {
    "hip": "mid_hip", "root": "mid_hip", "pelvis": "mid_hip", "head": "head_top", "left_bigtoe": "left_big_toe",
    "right_bigtoe": "right_big_toe", "left_smalltoe": "left_small_toe", "right_smalltoe": "right_small_toe",
}  # fmt: skip


#: What lies further out than ten of the largest photos is no coordinate.
_FURTHEST_PX = 10 * LARGEST_PX
#: What no instrument measures a person's depth at, metres.
_FURTHEST_M = 1e5


def shortened(value: object) -> str:
    """Return a value of a file as a message may quote it."""
    text = str(value)
    return text if len(text) <= 80 else f"{text[:60]}..."


@dataclass(frozen=True, eq=False)
class RecordedPhoto:
    """The people of one photo as a file gives them.

    photo: its name, without its ending where the file does not state it. people: in pixels of a photo of width x
    height, or of the full-size photo where these are None; 1 x 1 where coordinates are fractions. camera: in pixels of
    width x height, or None. number: COCO's image id, where the file has nothing else. beside: what else the file has.
    """

    photo: str
    people: People
    width: float | None = None
    height: float | None = None
    camera: Camera | None = None
    number: int | None = None
    beside: Beside = field(default_factory=Beside)


@dataclass(frozen=True, eq=False)
class Person:
    """One person's numbers: keypoints (K, 2), scores (K,), and a box x0, y0, x1, y1 and a score where given.

    depth_m, depth_sd_m, attributes: as `People` has them; NaN and none where the file has none. beside: what else the
    file has of the person, see `Beside`.
    """

    keypoints: FloatArray
    scores: FloatArray
    box: Sequence[float] | None = None
    score: float | None = None
    depth_m: float = math.nan
    depth_sd_m: float = math.nan
    attributes: Attributes = field(default_factory=dict[str, str])
    beside: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def stating(self, entry: Mapping[str, Any]) -> Person:
        """Return the person with what an entry of any JSON format may add: depth_m, depth_sd_m, attributes.

        Raises KeypointsError where a depth lacks its standard deviation or is impossible, and for attributes that no
        table can hold.
        """
        depth, sd = entry.get("depth_m"), entry.get("depth_sd_m")
        if (depth is None) != (sd is None):
            name = "depth_sd_m" if sd is None else "depth_m"
            raise KeypointsError(f"{name} is missing: a depth in metres and its standard deviation go together")
        return replace(
            self,
            depth_m=math.nan if depth is None else _metres("depth_m", depth),
            depth_sd_m=math.nan if sd is None else _metres("depth_sd_m", sd),
            attributes=attributes_of(entry.get("attributes")),
            beside={**self.beside, **{name: value for name, value in entry.items() if name not in TAKEN}},
        )


def _metres(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < _FURTHEST_M:
        raise KeypointsError(f"{name} is {shortened(value)}: it must be metres above 0, or left out where unknown")
    return float(value)


@contextmanager
def naming(where: str) -> Generator[None, None, None]:
    """Turn whatever goes wrong with a file's values inside into one KeypointsError that names the place."""
    try:
        yield
    except ProxemetryError as error:
        text = str(error)
        raise KeypointsError(text if text.startswith(where.split(",")[0]) else f"{where}: {text}") from error
    except KeyError as error:
        raise KeypointsError(f"{where}: {error.args[0]!r} is missing") from error
    except (TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        raise KeypointsError(f"{where}: malformed ({shortened(str(error))})") from error


def person_of(triples: Any, score: Any = None, box: Any = None) -> Person:
    """Return a person from K rows of x, y, score, or from the same numbers in one row.

    (0, 0) and score 0 are how files mark a joint that was not seen.
    """
    values = np.asarray(triples, dtype=float)
    if values.ndim == 1:
        if values.size % 3:
            raise KeypointsError(f"{values.size} keypoint numbers are not a multiple of three (x, y, score)")
        values = values.reshape(-1, 3)
    if values.ndim != 2 or values.shape[1] not in (2, 3):
        raise KeypointsError(f"keypoints must be rows of x, y, score, not of shape {values.shape}")
    scores = values[:, 2] if values.shape[1] == 3 else np.ones(len(values))
    return checked(Person(values[:, :2], scores, box, None if score is None else float(score)))


def box_person(box: Sequence[float], score: float | None = None) -> Person:
    """Return a person known only by the box x0, y0, x1, y1, for the skeleton `BOX`."""
    x0, y0, x1, y1 = map(float, box)
    if not (x0 < x1 and y0 < y1):
        raise KeypointsError(f"the box {x0:g}, {y0:g}, {x1:g}, {y1:g} has no area")
    middle = (x0 + x1) / 2
    return checked(Person(np.array([(middle, y0), (middle, y1)]), np.ones(2), (x0, y0, x1, y1), score))


def checked(person: Person) -> Person:
    """Return a person with what is missing marked as missing; raises KeypointsError where numbers cannot be right."""
    keypoints, scores = np.asarray(person.keypoints, dtype=float), np.asarray(person.scores, dtype=float)
    if keypoints.shape != (len(scores), 2):
        raise KeypointsError(f"keypoints of shape {keypoints.shape} do not fit scores of shape {scores.shape}")
    missing = (keypoints == 0).all(axis=1) | ~(np.abs(keypoints) < _FURTHEST_PX).all(axis=1) | ~(scores > 0)
    if person.box is not None and len(person.box) < 4:
        raise KeypointsError(f"a box has four numbers, not {len(person.box)}")
    box = None if person.box is None else [float(v) for v in person.box[:4]]
    return replace(
        person,
        keypoints=np.where(missing[:, None], np.nan, keypoints),
        scores=np.where(missing, 0.0, np.clip(scores, 0.0, 1.0)),
        box=box if box is not None and all(abs(v) < _FURTHEST_PX for v in box) else None,
    )


def people_of(skeleton: Skeleton, persons: Sequence[Person]) -> People:
    """Return People; a person whose number of joints does not fit the skeleton is an error."""
    if not persons:
        return People.none(skeleton)
    for number, person in enumerate(persons):
        if len(person.scores) != len(skeleton):
            raise KeypointsError(
                f"person {number} has {len(person.scores)} keypoints, but skeleton {skeleton.name} has {len(skeleton)}"
            )
    people = People(skeleton, np.stack([p.keypoints for p in persons]), np.stack([p.scores for p in persons]))
    boxes, scores = people.boxes_px.copy(), people.person_scores.copy()
    for row, person in enumerate(persons):
        boxes[row] = boxes[row] if person.box is None else person.box
        # a score of another scale (a sum over joints) is no probability; the keypoints' mean is kept
        scores[row] = person.score if person.score is not None and 0 <= person.score <= 1 else scores[row]
    return People(
        skeleton, people.keypoints_px, people.scores, boxes, scores,
        depth_m=np.array([p.depth_m for p in persons]), depth_sd_m=np.array([p.depth_sd_m for p in persons]),
        attributes=[p.attributes for p in persons], source=SOURCE,
    )  # fmt: skip


def has_shoulders(names: Sequence[str]) -> bool:
    """Whether named joints are those of a person."""
    return {"left_shoulder", "right_shoulder"} <= set(canonical_names(names))


def canonical_names(names: Sequence[str]) -> list[str]:
    """Return joints' names as the project spells them, where it knows them."""
    plain = [n.lower().replace(" ", "_").replace("-", "_") for n in names]
    return [_ALIASES.get(n, n) for n in plain]


def renamed(names: Sequence[str], persons: Sequence[Person]) -> tuple[Skeleton, list[Person]]:
    """Return the known skeleton that named joints fit into, and the people in its order; what it lacks is dropped."""
    plain = canonical_names(names)
    has_middles = "neck" in plain and "mid_hip" in plain
    skeleton = HALPE_26 if has_middles else COCO_17
    if not has_shoulders(names):
        raise KeypointsError(f"no joints called left_shoulder and right_shoulder among {', '.join(plain[:6])}, ...")
    rows = [plain.index(joint) if joint in plain else -1 for joint in skeleton.joints]
    order = np.array(rows)
    left = {name: row for row, name in enumerate(plain) if row not in rows}
    answer: list[Person] = []
    for person in persons:
        if len(person.scores) != len(plain):
            raise KeypointsError(f"{len(person.scores)} keypoints for {len(plain)} named joints")
        keypoints = np.where(order[:, None] < 0, np.nan, person.keypoints[order])
        scores = np.where(order < 0, 0.0, person.scores[order])
        answer.append(replace(_with_extra(person, left), keypoints=keypoints, scores=scores))
    return skeleton, answer


def _with_extra(person: Person, rows: Mapping[str, int]) -> Person:
    """Return a person with what was seen of these joints, by name their rows, beside the others."""
    extra = {
        name: [*person.keypoints[row].tolist(), float(person.scores[row])]
        for name, row in rows.items()
        if np.isfinite(person.keypoints[row]).all()
    }
    return replace(person, beside={**person.beside, EXTRA_JOINTS: extra}) if extra else person


def by_count(persons: Sequence[Person]) -> tuple[Skeleton, list[Person]]:
    """Return the skeleton that people's number of keypoints stands for, and the people; of a whole body the body."""
    if not persons:
        return COCO_17, []
    count = len(persons[0].scores)
    skeleton = skeleton_of(count)
    if skeleton is None:
        known = ", ".join(str(n) for n in sorted({*BY_COUNT, *WHOLE_BODIES}))
        raise KeypointsError(f"{count} keypoints fit no known skeleton ({known} joints do)")
    body, left = slice(len(skeleton)), {f"joint_{row + 1}": row for row in range(len(skeleton), count)}
    return skeleton, [
        replace(_with_extra(p, left), keypoints=p.keypoints[body], scores=p.scores[body])
        if len(p.scores) == count
        else p
        for p in persons
    ]


def refuse_fractions(recording: RecordedPhoto) -> None:
    """Raise KeypointsError where pixels are fractions of a size that is not stated, as many tools can write them."""
    if recording.width == 1:
        return
    if are_fractions(recording.people.keypoints_px):
        raise KeypointsError(
            f"photo {recording.photo}: coordinates are fractions, not pixels: have them written in pixels"
        )


def size_of(entry: Mapping[str, Any]) -> tuple[float | None, float | None]:
    """Return width and height of an entry, both or neither; raises KeypointsError where they are no sizes."""
    width, height = entry.get("width"), entry.get("height")
    if width is None and height is None:
        return None, None
    if width is None or height is None or not all(0 < float(side) <= LARGEST_PX for side in (width, height)):
        raise KeypointsError(f"width {shortened(width)} and height {shortened(height)} are not the size of a photo")
    return float(width), float(height)
