"""A methods paragraph with a run's own figures, ready to paste into a paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...anthropometry import CHILD_WEIGHT
from ...camera import FocalBasis
from ...intervals import LEVEL
from ...people.attributes import PairsWhere
from ..store.damage import require_columns
from ..store.duck import attached
from ..store.folder import Folder
from .focal_bases import focal_bases
from .restriction import counted, nearest_of

_COMBINED = (
    "Each person was then placed by the pinhole camera from the one of three body lengths (pupils, shoulders, "
    "torso) that puts them nearest (Seker et al. 2021, combined)"
)
_ONE_LENGTH = (
    "Each person was then placed by the pinhole camera from one body length taken as parallel to the sensor "
    "(Seker et al. 2021, {method})"
)
#: The bodies that the scene fit expects, by `LocateSettings.body_size`.
_BODIES = {
    "adults": "bodies of the proportions of adults (ANSUR II body measurements, women and men alike)",
    "women": "bodies of the proportions of women (ANSUR II body measurements)",
    "men": "bodies of the proportions of men (ANSUR II body measurements)",
    "mixed": (
        "bodies of the proportions of adults and, as {share:.0%} of all, children (ANSUR II and CDC body measurements)"
    ),
    "children": "bodies of the proportions of children aged 2 to 14 (CDC body measurements)",
}
#: Options that change numbers, by their names in `run.json`, where they are not as they are by default.
_TURNED = {
    "undistort": "lens distortion was not corrected",
    "lines": "straight lines in the pictures were not used",
    "other_photos": "each photograph was measured by itself, without evidence from others of the same camera model",
    "drone": "the height and gimbal angles in drones' files were not used",
}


#: A share that is 100 % when it is rounded.
_NEARLY_ALL = 0.995

#: What is read of the tables.
_NEEDED = {
    "photos": ("status", "corrections", "focal_basis", "mount_source", "sha256"),
    "people": ("x_m",),
    "pairs": ("photo", "person_a", "person_b", "distance_m", "low_m", "high_m", "on_ground"),
}


def methods_paragraph(run: Mapping[str, Any], tables: Folder, where: PairsWhere | None = None) -> str:
    """Return what was done, with which software and how much of it could be measured, in plain sentences.

    run: of `run.json`. tables: the folder that holds the Parquet tables. where: whose pairs count.
    """
    every, of_those = counted(tables, None), counted(tables, where)
    photos, people, pairs = every.photos, every.people, of_those.pairs
    duck = attached(tables)
    require_columns(tables, duck, _NEEDED)
    counts = _one(
        duck,
        "SELECT count(*) photos, count(*) FILTER (status = 'ok') measured, count(*) FILTER (status = 'failed') failed, "
        "count(*) FILTER (status = 'no_camera') no_camera, count(*) FILTER (status = 'excluded') excluded, "
        "count(*) FILTER (corrections > 0) corrected, "
        "count(*) FILTER (sha256 <> '') - count(DISTINCT sha256) FILTER (sha256 <> '') copies "
        f"FROM {photos}",
    )
    found = _one(duck, f"SELECT count(*) people, count(x_m) placed FROM {people}")
    nearest = _one(duck, f"SELECT median(nearest_m) metres FROM {nearest_of(pairs)}")
    measured = _one(
        duck,
        "SELECT count(*) pairs, median((high_m - low_m) / distance_m) width, avg(on_ground::DOUBLE) ground "
        f"FROM {pairs} WHERE distance_m IS NOT NULL",
    )
    settings = run.get("settings") or {}
    sentences = [
        f"Interpersonal distances were measured in {_many(counts['photos'], 'photograph')} with proxemetry "
        f"{run.get('version')}. People were found by the pose back end {run.get('pose')}. {_placing(settings)}",
        _turned(settings),
        _focal_sentence(focal_bases(duck, photos)),
        _place_sentence(duck, photos),
        _left_out(counts),
        f"In all, {_many(found['people'], 'person', 'people')} were found, of whom {found['placed']:,} could be "
        f"placed, which gave {_many(measured['pairs'], 'pair')}{_whose(where)}.",
    ]
    if measured["pairs"]:
        along = ground_in_words(measured["ground"] or 0.0)
        sentences.append(
            f"Distances are between body centres, {along}, each with a {LEVEL:.0%} interval whose median width is "
            f"{measured['width']:.0%} of the distance; the median distance to the nearest other person was "
            f"{nearest['metres']:.2f} m. Pairs were counted in Hall's (1966) zones by their probabilities."
        )
    if counts["corrected"]:
        sentences.append(f"{_many(counts['corrected'], 'photograph')} had corrections made by hand in review.")
    return " ".join(filter(None, sentences))


def ground_in_words(share: float) -> str:
    """Return what distances are along; share: of the pairs, of those that are along the ground."""
    if share > _NEARLY_ALL:
        return "along the ground"
    if share < 1 - _NEARLY_ALL:
        return "in space, since gravity is unknown"
    return f"along the ground for {100 * share:.0f} % of the pairs, in space for the rest"


def _placing(settings: Mapping[str, Any]) -> str:
    """Return the sentence on how people were placed, as the settings of `run.json` have it."""
    method, locate = str(settings.get("method") or "scene"), settings.get("locate") or {}
    if method != "scene":
        quirks = ", ".join(locate.get("quirks") or ())
        peculiarities = f", with the published code's peculiarities {quirks}" if quirks else ""
        return (_COMBINED if method == "combined" else _ONE_LENGTH.format(method=method)) + peculiarities + "."
    expected = str(locate.get("body_size") or "mixed")
    bodies = _BODIES[expected].format(share=locate.get("child_weight", CHILD_WEIGHT))
    floor = "each independently, without a shared floor," if locate.get("floor") == "none" else "on a shared floor"
    return (
        f"A joint fit per photo then placed all people at once: {bodies}, {floor} before one camera, each keypoint "
        "weighted by its own uncertainty."
    )


def _turned(settings: Mapping[str, Any]) -> str:
    said = [text for name, text in _TURNED.items() if settings.get(name) is False]
    if settings.get("same_camera"):
        said.append("photographs that state no focal length were taken to be of one camera and lens, size by size")
    return f"{'; '.join(said).capitalize()}." if said else ""


def _place_sentence(duck: Any, photos: str) -> str:
    """Return in how many photographs the camera's place was known without the people, and from what."""
    cursor = duck.execute(
        f"SELECT mount_source, count(*) FROM {photos} WHERE mount_source IS NOT NULL AND status = 'ok' "
        "GROUP BY 1 ORDER BY 2 DESC, 1"
    )
    rows = cursor.fetchall()
    if not rows:
        return ""
    named = ", ".join(f"{source} ({count:,})" for source, count in rows[:_MOST_NAMED])
    rest = sum(count for _, count in rows[_MOST_NAMED:])
    total = sum(count for _, count in rows)
    return (
        f"How the camera was tilted or placed was known independently of the people in {_many(total, 'photograph')}: "
        f"{named}"
        f"{f', others ({rest:,})' if rest else ''}."
    )


#: So many sources of a camera's place are named.
_MOST_NAMED = 4


def _whose(where: PairsWhere | None) -> str:
    return "" if where is None else f" of two people both with {where}"


def _focal_sentence(counts: Mapping[FocalBasis, int]) -> str:
    measured = sum(counts.values())
    if not measured:
        return ""
    guessed = [
        f"{verb} in {counts[basis]:,} ({counts[basis] / measured:.0%})"
        for basis, verb in _GUESSED.items()
        if counts[basis]
    ]
    if not guessed:
        return "Focal lengths came from the files' metadata or were stated."
    return (
        f"Of the {measured:,} measured photographs, the focal length was {' and '.join(guessed)}; the intervals there "
        "include that uncertainty."
    )


#: What is neither the files' nor the user's word.
_GUESSED = {
    FocalBasis.ESTIMATED: "estimated from the picture (straight lines, people, other photos of the same camera)",
    FocalBasis.ASSUMED: "assumed",
}


def _left_out(counts: dict[str, Any]) -> str:
    kinds = (
        ("no_camera", "had no usable focal length"), ("failed", "could not be read"),
        ("excluded", "were excluded in review"),
    )  # fmt: skip
    said = [f"{counts[key]:,} {text}" for key, text in kinds if counts[key]]
    if counts["copies"]:
        said.append(f"{counts['copies']:,} {'is' if counts['copies'] == 1 else 'are'} the same file as another")
    return f"Of the photographs, {'; '.join(said)}." if said else ""


def _many(count: int, one: str, many: str | None = None) -> str:
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def _one(duck: Any, query: str) -> dict[str, Any]:
    cursor = duck.execute(query)
    names = [d[0] for d in cursor.description]
    return dict(zip(names, cursor.fetchone(), strict=True))
