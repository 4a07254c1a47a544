"""An archive's figures by group: how many, the median distance, the share of each zone, with sampling intervals."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray, IntArray
from ...distances import ZONE_LIMITS_M, ZONES
from ...errors import OutputError
from ..store.parts import attached, quoted
from ..store.results import Results
from .grouping import sql_of
from .sampling import Estimates, Sample


@dataclass(frozen=True)
class Share:
    """A figure and the central 90 % of where it may lie, given how many photos there are; NaN where unknown."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Group:
    """One group. key: its values, None where a photo's is unknown. median_m: of all its pairs; zones: as `ZONES`.

    expected_zones: the shares where each pair counts by its probabilities, which takes account of how uncertain the
    single distances are.
    """

    key: tuple[str | None, ...]
    n_photos: int
    n_photos_with_pairs: int
    n_people: int
    n_pairs: int
    median_m: Share
    zones: tuple[Share, ...]
    expected_zones: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Summary:
    """Groups in the order of their keys, and every pair's distance and group (row of `groups`) for figures."""

    by: tuple[str, ...]
    groups: tuple[Group, ...]
    distance_m: FloatArray
    group_of_pair: IntArray

    def rows(self) -> list[dict[str, Any]]:
        """Return one flat row a group: what is printed and written."""
        return [
            {
                **dict(zip(self.by, group.key, strict=True)),
                "n_photos": group.n_photos,
                "n_photos_with_pairs": group.n_photos_with_pairs,
                "n_people": group.n_people,
                "n_pairs": group.n_pairs,
                "median_m": group.median_m.value,
                "median_low_m": group.median_m.low,
                "median_high_m": group.median_m.high,
                **{
                    f"{zone}{ending}": getattr(share, name)
                    for zone, share in zip(ZONES, group.zones, strict=True)
                    for ending, name in (("", "value"), ("_low", "low"), ("_high", "high"))
                },
                **{f"{zone}_expected": value for zone, value in zip(ZONES, group.expected_zones, strict=True)},
            }
            for group in self.groups
        ]


def summarise(results: Results, by: Sequence[str] = (), *, distinct: bool = False, expected: bool = True) -> Summary:
    """Return the figures of a finished results folder by year, month, folder or any column of the photos table.

    Photos that a reviewer excluded do not count. distinct: copies of one file count once a group. expected: tell the
    shares where each pair counts by its probabilities, too; without it they are NaN, and a third is read. Raises
    SettingsError for an unknown column, OutputError where the tables are not there yet.
    """
    folder = results.folder
    if not folder.exists("photos.parquet"):
        raise OutputError(f"{folder.location}: no tables there yet; finish the run, then try again")
    keys = [sql_of(name) for name in by]
    duck = attached(folder, threads=None)
    names = [f"k{i}" for i in range(len(keys))]
    with ThreadPoolExecutor(1) as beside:  # pairs are read while photos are counted
        reading = beside.submit(_pairs, results, duck.cursor(), expected)
        _count_photos(duck, folder.path("photos.parquet"), keys, distinct)
        query = f"SELECT {', '.join([*names, 'n_photos', 'n_people'])} FROM grouped ORDER BY g"
        listed = duck.execute(query).fetchall()
        group_of_row = _group_of_row(duck, names)
        pairs = _grouped_pairs(reading.result(), group_of_row, len(listed))
    return Summary(tuple(by), _groups(listed, pairs), pairs["distance_m"], pairs["group"])


def _count_photos(duck: Any, photos: str, keys: Sequence[str], distinct: bool) -> None:
    """Make the table `counted` of the photos that count, by their place in the file, and `grouped` of their groups."""
    selected = "".join(f", {key}::VARCHAR AS k{i}" for i, key in enumerate(keys))
    names = [f"k{i}" for i in range(len(keys))]
    once = ", ".join(["CASE WHEN coalesce(sha256, '') = '' THEN photo ELSE sha256 END", *names])
    duck.execute(
        f"CREATE OR REPLACE TEMP TABLE counted AS SELECT file_row_number AS row, n_people{selected} "
        f"FROM read_parquet({quoted(photos)}, file_row_number = true) WHERE status <> 'excluded'"
        + (f" QUALIFY row_number() OVER (PARTITION BY {once} ORDER BY photo) = 1" if distinct else "")
    )
    grouped = f" GROUP BY {', '.join(names)}" if names else ""
    order = f"ORDER BY {', '.join(f'{n} NULLS LAST' for n in names)}" if names else ""
    figures = ", ".join([*names, "count(*) AS n_photos", "sum(n_people) AS n_people"])
    duck.execute(
        f"CREATE OR REPLACE TEMP TABLE grouped AS SELECT *, row_number() OVER ({order}) - 1 AS g FROM "
        f"(SELECT {figures} FROM counted{grouped})"
    )


def _group_of_row(duck: Any, names: Sequence[str]) -> IntArray:
    """Return the group of each row of the photos table, -1 for those that do not count."""
    match = " AND ".join(f"counted.{k} IS NOT DISTINCT FROM grouped.{k}" for k in names) or "true"
    placed = duck.execute(f"SELECT row, g FROM counted JOIN grouped ON {match}").fetchnumpy()
    rows = np.asarray(placed["row"])
    group = np.full(int(rows.max(initial=-1)) + 1, -1, dtype=np.int64)
    group[rows] = placed["g"]
    return group


def _pairs(results: Results, duck: Any, expected: bool) -> dict[str, Any]:
    """Return columns of all measured pairs: their photo's row in the photos table, distance and probabilities.

    Both tables are in the order of names, and the photos say how many pairs they have: where both were written
    together, that tells each pair's photo without comparing a name. Otherwise the names are joined.
    """
    photos, pairs = (f"read_parquet({quoted(results.folder.path(f'{t}.parquet'))}" for t in ("photos", "pairs"))
    columns = ", ".join(["distance_m", *(f"p_{zone}" for zone in ZONES if expected)])
    if results.tables_belong_together():
        found = duck.execute(f"SELECT {columns} FROM {pairs}) WHERE distance_m IS NOT NULL").fetchnumpy()
        each = np.ma.filled(duck.execute(f"SELECT n_pairs FROM {photos})").fetchnumpy()["n_pairs"], 0)
        if int(each.sum()) == len(found["distance_m"]):
            return {**found, "row": np.repeat(np.arange(len(each)), each)}
    return duck.execute(
        f"SELECT {columns}, row FROM {pairs}) JOIN (SELECT photo, file_row_number AS row FROM {photos}, "
        "file_row_number = true)) USING (photo) WHERE distance_m IS NOT NULL ORDER BY row"
    ).fetchnumpy()


def _grouped_pairs(pairs: dict[str, Any], group_of_row: IntArray, n_groups: int) -> dict[str, Any]:
    """Return the columns of the pairs that count, group after group, a photo's pairs together in each.

    Of the probabilities only each group's mean is kept, shape (G,).
    """
    rows = np.asarray(pairs["row"])
    inside = np.append(group_of_row, -1)[np.minimum(rows, len(group_of_row))]
    size = np.bincount(inside + 1, minlength=n_groups + 1)[1:]
    columns: dict[str, Any] = {}
    for zone in ZONES:
        if f"p_{zone}" not in pairs:
            columns[f"p_{zone}"] = np.full(n_groups, np.nan)
            continue
        probability = np.ma.filled(pairs[f"p_{zone}"], np.nan)
        with np.errstate(invalid="ignore"):
            sums = np.bincount(inside + 1, weights=probability, minlength=n_groups + 1)[1:]
            columns[f"p_{zone}"] = sums / size
    if n_groups == 1 and bool((inside == 0).all()):  # everything in one group: as it stands
        chosen: Any = slice(None)
    else:
        # Sixteen bits are sorted without comparing: a tenth of the time.
        small = inside.astype(np.int16) if n_groups < 2**15 else inside
        chosen = np.argsort(small, kind="stable")[len(inside) - int(size.sum()) :]
    distance = np.ma.filled(pairs["distance_m"], np.nan)
    return {**columns, "distance_m": distance[chosen], "group": inside[chosen], "row": rows[chosen]}


def _figures(pairs: dict[str, Any], n_groups: int) -> tuple[Sample, Estimates, list[Estimates]]:
    """Return the sample, the groups' medians, and for each zone their shares."""
    sample, distance = Sample(pairs["group"], pairs["row"], n_groups), pairs["distance_m"]
    edges = [0.0, *ZONE_LIMITS_M, math.inf]
    zones = [sample.shares((distance >= low) & (distance < high)) for low, high in itertools.pairwise(edges)]
    return sample, sample.medians(distance), zones


def _groups(listed: Sequence[tuple[Any, ...]], pairs: dict[str, Any]) -> tuple[Group, ...]:
    """Return the groups as listed: their keys, numbers of photos and of people."""
    sample, medians, zones = _figures(pairs, len(listed))
    return tuple(
        Group(
            key=tuple(row[:-2]),
            n_photos=row[-2],
            n_photos_with_pairs=int(sample.n_photos[i]),
            n_people=int(row[-1] or 0),
            n_pairs=int(sample.size[i]),
            median_m=_share(medians, i),
            zones=tuple(_share(zone, i) for zone in zones),
            expected_zones=tuple(float(pairs[f"p_{zone}"][i]) for zone in ZONES),
        )
        for i, row in enumerate(listed)
    )


def _share(estimates: Estimates, group: int) -> Share:
    return Share(*(float(values[group]) for values in (estimates.value, estimates.low, estimates.high)))
