"""The results of a run in numbers, from its tables: the totals, a line per photo, and why photos failed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...camera import FocalBasis, FocalSource
from ...distances import UNCERTAIN, ZONES
from ...tables import DOUBT, NO_DOUBT
from ..store.duck import attached, quoted
from ..store.folder import Folder
from ..store.queries import stored
from .focal_bases import focal_bases


@dataclass(frozen=True)
class Totals:
    """A run's counts.

    photos: of which measured, failed, no_camera, excluded. bases: what the focal lengths of the measured rest on;
    untold: of the assumed, where nothing at all was known. copies: photos whose file is another's too. people: found;
    nearest_m: the median distance to the nearest other person of the with_nearest who have one. duplicates: people who
    may be others seen a second time; doubtful: these and others who may be no people. pairs: with a distance.
    median_m: of the distances; None without any. zone_shares: expected share of the pairs in each of Hall's zones;
    empty without pairs. uncertain: pairs in no zone more likely than not. safe_distance_m: of the run, None where none
    was asked for; below_safe: pairs nearer.
    """

    photos: int
    measured: int
    failed: int
    no_camera: int
    excluded: int
    bases: Mapping[FocalBasis, int]
    untold: int
    copies: int
    people: int
    nearest_m: float | None
    with_nearest: int
    duplicates: int
    doubtful: int
    pairs: int
    median_m: float | None
    zone_shares: Mapping[str, float]
    uncertain: int
    safe_distance_m: float | None
    below_safe: int


@dataclass(frozen=True)
class PhotoLine:
    """A photo with its nearest pair; n_people and n_pairs are None where the photo could not be read or is excluded."""

    photo: str
    status: str
    reason: str | None
    n_people: int | None
    n_pairs: int | None
    nearest_m: float | None
    low_m: float | None
    high_m: float | None
    person_a: int | None
    person_b: int | None


def totals(folder: Folder) -> Totals:
    """Return a run's counts from its tables."""
    photos = _one_row(
        folder,
        "SELECT count(*) photos, count(*) FILTER (status = 'ok') measured, count(*) FILTER (status = 'failed') failed, "
        "count(*) FILTER (status = 'no_camera') no_camera, count(*) FILTER (status = 'excluded') excluded, "
        f"count(*) FILTER (status = 'ok' AND focal_kind = '{FocalSource.ASSUMED_PRIOR}') untold, "
        "count(*) - count(DISTINCT nullif(sha256, '')) "
        "- count(*) FILTER (coalesce(sha256, '') = '') copies, coalesce(sum(n_people), 0) people, "
        "any_value(safe_distance_m) safe_distance_m, coalesce(sum(n_below_safe), 0) below_safe "
        f"FROM {_table(folder, 'photos')}",
    )
    nearest = _one_row(
        folder,
        f"SELECT median(nearest_m) nearest_m, count(nearest_m) with_nearest, "
        f"count(*) FILTER (possible_duplicate) duplicates, count(*) FILTER ({DOUBT} <> '{NO_DOUBT}') doubtful "
        f"FROM {stored(folder, 'people')}",
    )
    expected = ", ".join(f"sum(p_{zone}) {zone}" for zone in ZONES)
    pairs = _one_row(
        folder,
        f"SELECT count(*) pairs, median(distance_m) median_m, count(*) FILTER (zone = '{UNCERTAIN}') uncertain, "
        f"{expected} FROM {_table(folder, 'pairs')} WHERE distance_m IS NOT NULL",
    )
    sums = {zone: pairs.pop(zone) for zone in ZONES}
    shares = {zone: total / pairs["pairs"] for zone, total in sums.items()} if pairs["pairs"] else {}
    bases = focal_bases(attached(folder), _table(folder, "photos"))
    return Totals(**photos, **nearest, **pairs, bases=bases, zone_shares=shares)


def photo_lines(folder: Folder) -> list[PhotoLine]:
    """Return every photo with its nearest pair, in the order of their names."""
    rows = attached(folder).execute(
        "SELECT photo, status, reason, n_people, n_pairs, nearest, low_m, high_m, person_a, person_b FROM "
        f"{_table(folder, 'photos')} LEFT JOIN (SELECT photo, min(distance_m) nearest, "
        "arg_min(low_m, distance_m) low_m, arg_min(high_m, distance_m) high_m, "
        "arg_min(person_a, distance_m) person_a, arg_min(person_b, distance_m) person_b "
        f"FROM {_table(folder, 'pairs')} GROUP BY photo) USING (photo) ORDER BY photo"
    )
    return [PhotoLine(*row) for row in rows.fetchall()]


def failures(folder: Folder, limit: int) -> list[tuple[str, str]]:
    """Return the first photos that failed, by name, with the reason."""
    rows = attached(folder).execute(
        f"SELECT photo, reason FROM {_table(folder, 'photos')} WHERE status = 'failed' ORDER BY photo LIMIT {limit}"
    )
    return rows.fetchall()


def _table(folder: Folder, name: str) -> str:
    return f"read_parquet({quoted(folder.path(f'{name}.parquet'))})"


def _one_row(folder: Folder, query: str) -> dict[str, Any]:
    cursor = attached(folder).execute(query)
    names = [d[0] for d in cursor.description]
    return dict(zip(names, cursor.fetchone(), strict=True))
