"""A methods paragraph with a run's own figures, ready to paste into a paper."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...camera import FocalBasis
from ...intervals import LEVEL
from ...people.attributes import PairsWhere
from ..store.duck import attached
from ..store.folder import Folder
from .focal_bases import focal_bases
from .restriction import counted, nearest_of

_WHAT_METHODS_DO = {
    "scene": (
        "A joint fit per photo then placed all people at once: bodies of plausible proportions (ANSUR II and CDC body "
        "measurements) on a shared floor before one camera, each keypoint weighted by its own uncertainty."
    ),
    "combined": (
        "Each person was then placed by the pinhole camera from the one of three body lengths (pupils, shoulders, "
        "torso) that puts them nearest (Seker et al. 2021, combined)."
    ),
}
_ONE_LENGTH = (
    "Each person was then placed by the pinhole camera from one body length taken as parallel to the sensor "
    "(Seker et al. 2021, {method})."
)


def methods_paragraph(run: Mapping[str, Any], tables: Folder, where: PairsWhere | None = None) -> str:
    """Return what was done, with which software and how much of it could be measured, in plain sentences.

    run: of `run.json`. tables: the folder that holds the Parquet tables. where: whose pairs count.
    """
    every, of_those = counted(tables, None), counted(tables, where)
    photos, people, pairs = every.photos, every.people, of_those.pairs
    duck = attached(tables)
    counts = _one(
        duck,
        "SELECT count(*) photos, count(*) FILTER (status = 'ok') measured, count(*) FILTER (status = 'failed') failed, "
        "count(*) FILTER (status = 'no_camera') no_camera, count(*) FILTER (status = 'excluded') excluded, "
        "count(*) FILTER (corrections > 0) corrected "
        f"FROM {photos}",
    )
    found = _one(duck, f"SELECT count(*) people, count(x_m) placed, median(nearest_m) nearest FROM {people}")
    measured = _one(
        duck,
        "SELECT count(*) pairs, median((high_m - low_m) / distance_m) width, avg(on_ground::DOUBLE) ground "
        f"FROM {pairs} WHERE distance_m IS NOT NULL",
    )
    if where is not None:
        nearest = f"SELECT median(nearest_m) nearest FROM {nearest_of(pairs)}"
        found |= _one(duck, nearest)
    method = str((run.get("settings") or {}).get("method") or "scene")
    sentences = [
        f"Interpersonal distances were measured in {_many(counts['photos'], 'photograph')} with proxemetry "
        f"{run.get('version')}. People were found by the pose back end {run.get('pose')}. "
        f"{_WHAT_METHODS_DO.get(method, _ONE_LENGTH.format(method=method))}",
        _focal_sentence(focal_bases(duck, photos)),
        _left_out(counts),
        f"In all, {_many(found['people'], 'person', 'people')} were found, of whom {found['placed']:,} could be "
        f"placed, which gave {_many(measured['pairs'], 'pair')}{_whose(where)}.",
    ]
    if measured["pairs"]:
        kind = "along the ground" if (measured["ground"] or 0) > 0.5 else "in space"
        sentences.append(
            f"Distances are between body centres, {kind}, each with a {LEVEL:.0%} interval whose median width is "
            f"{measured['width']:.0%} of the distance; the median distance to the nearest other person was "
            f"{found['nearest']:.2f} m. Pairs were counted in Hall's (1966) zones by their probabilities."
        )
    if counts["corrected"]:
        sentences.append(f"{_many(counts['corrected'], 'photograph')} had corrections made by hand in review.")
    return " ".join(filter(None, sentences))


def _whose(where: PairsWhere | None) -> str:
    return "" if where is None else f" of two people who both were recorded as {where}"


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
        "hold that uncertainty."
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
    return f"Of the photographs, {'; '.join(said)}." if said else ""


def _many(count: int, one: str, many: str | None = None) -> str:
    return f"{count:,} {one if count == 1 else many or one + 's'}"


def _one(duck: Any, query: str) -> dict[str, Any]:
    cursor = duck.execute(query)
    names = [d[0] for d in cursor.description]
    return dict(zip(names, cursor.fetchone(), strict=True))
