"""An archive's figures by group: how many, the median distance, the share of each zone, with sampling intervals.

Pairs of one photo are not independent, so photos are what is sampled: intervals are those of a ratio over clusters
(linearised variance), Wilson's for shares with the sample size that has this variance, Woodruff's for medians.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..distances import ZONE_LIMITS_M, ZONES
from ..errors import OutputError, SettingsError
from ..tables import TABLES
from .parts import attached, quoted
from .results import Results

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

#: Intervals are the central 90 %, as everywhere.
_Z = 1.6448536269514722

#: What photos can be grouped by besides the columns of the photos table, as SQL.
GROUPINGS = {
    "year": "regexp_extract(date, '^[0-9]{4}')",
    "month": "regexp_extract(date, '^[0-9]{4}-[0-9]{2}')",
    "folder": "coalesce(nullif(regexp_extract(photo, '^(.*)/[^/]*$', 1), ''), '.')",
}


@dataclass(frozen=True)
class Share:
    """A share and the central 90 % of where it may lie, given how many photos there are; NaN where unknown."""

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


def summarise(results: Results, by: Sequence[str] = (), *, distinct: bool = False) -> Summary:
    """Return the figures of a finished results folder by year, month, folder or any column of the photos table.

    Photos that a reviewer excluded do not count. distinct: copies of one file count once a group. Raises
    SettingsError for an unknown column, OutputError where the tables are not there yet.
    """
    folder = results.folder
    if folder.read("photos.parquet") is None:
        raise OutputError(f"{folder.location}: no tables there yet; finish the run, then try again")
    keys = [_key(name) for name in by]
    duck = attached(folder, threads=None)
    photos, pairs = (f"read_parquet({quoted(folder.path(f'{t}.parquet'))})" for t in ("photos", "pairs"))
    selected = "".join(f", {key}::VARCHAR AS k{i}" for i, key in enumerate(keys))
    once = ", ".join(["sha256 || CASE WHEN sha256 = '' THEN photo ELSE '' END", *(f"k{i}" for i in range(len(keys)))])
    duck.execute(
        "CREATE OR REPLACE TEMP TABLE counted AS SELECT *, (row_number() OVER () - 1)::BIGINT AS row FROM "
        f"(SELECT photo, sha256, n_people{selected} FROM {photos} WHERE status <> 'excluded')"
        + (f" QUALIFY row_number() OVER (PARTITION BY {once} ORDER BY photo) = 1" if distinct else "")
    )
    names = [f"k{i}" for i in range(len(keys))]
    grouped = f" GROUP BY {', '.join(names)} ORDER BY {', '.join(f'{n} NULLS LAST' for n in names)}" if names else ""
    listed = duck.execute(f"SELECT {', '.join([*names, 'count(*)', 'sum(n_people)'])} FROM counted{grouped}").fetchall()
    found = {tuple(row[: len(keys)]): i for i, row in enumerate(listed)}
    columns = _pairs(duck, pairs, len(keys), found)
    groups = tuple(_group(tuple(row[: len(keys)]), row[-2], row[-1], _of(columns, i)) for i, row in enumerate(listed))
    return Summary(tuple(by), groups, columns["distance_m"], columns["group"])


def _key(name: str) -> str:
    if name in GROUPINGS:
        return f"nullif({GROUPINGS[name]}, '')"
    if name in {column.name for column in TABLES["photos"]}:
        return f'"{name}"'
    raise SettingsError(f"--by {name}: use {', '.join(GROUPINGS)} or a column of the photos table")


def _pairs(duck: Any, pairs: str, n_keys: int, found: dict[tuple[Any, ...], int]) -> dict[str, Any]:
    """Return columns of all measured pairs, in the order of their groups."""
    keys = [f"k{i}" for i in range(n_keys)]
    duck.execute(f"CREATE OR REPLACE TEMP TABLE named ({', '.join(f'{k} VARCHAR' for k in [*keys, 'x'])}, g BIGINT)")
    duck.executemany(
        f"INSERT INTO named VALUES ({', '.join('?' * (n_keys + 2))})", [(*key, None, g) for key, g in found.items()]
    )
    match = " AND ".join(f"counted.{k} IS NOT DISTINCT FROM named.{k}" for k in keys) or "true"
    duck.execute(f"CREATE OR REPLACE TEMP TABLE placed AS SELECT photo, row, g FROM counted JOIN named ON {match}")
    probabilities = ", ".join(f"p_{zone}" for zone in ZONES)
    answer = duck.execute(
        f'SELECT g AS "group", row, distance_m, {probabilities} FROM {pairs} JOIN placed USING (photo) '
        "WHERE distance_m IS NOT NULL"
    ).fetchnumpy()
    order = np.lexsort((answer["distance_m"], answer["group"]))
    return {name: np.asarray(np.ma.filled(values, np.nan))[order] for name, values in answer.items()}


def _of(columns: dict[str, Any], group: int) -> dict[str, Any]:
    start, end = np.searchsorted(columns["group"], [group, group + 1])
    return {name: values[start:end] for name, values in columns.items()}


def _group(key: tuple[Any, ...], n_photos: int, n_people: int | None, pairs: dict[str, Any]) -> Group:
    distance = pairs["distance_m"]
    photo, count = np.unique(pairs["row"], return_inverse=True)
    expected = tuple(float(pairs[f"p_{zone}"].mean()) if len(distance) else math.nan for zone in ZONES)
    edges = [0.0, *ZONE_LIMITS_M, math.inf]
    zones = tuple(
        _share((distance >= low) & (distance < high), count, len(photo)) for low, high in itertools.pairwise(edges)
    )
    return Group(
        key,
        n_photos,
        len(photo),
        int(n_people or 0),
        len(distance),
        _median(distance, count, len(photo)),
        zones,
        expected,
    )


def _ratio_sd(hits: NDArray[np.bool_], cluster: IntArray, n_clusters: int) -> tuple[float, float]:
    """Return the share of hits and its standard deviation, whole clusters (photos) being sampled."""
    share = float(hits.mean())
    if n_clusters < 2:
        return share, math.nan
    residuals = np.bincount(cluster, weights=hits - share, minlength=n_clusters)
    return share, math.sqrt(n_clusters / (n_clusters - 1) * float(residuals @ residuals)) / len(hits)


def _share(hits: NDArray[np.bool_], cluster: IntArray, n_clusters: int) -> Share:
    if not len(hits):
        return Share(math.nan, math.nan, math.nan)
    share, sd = _ratio_sd(hits, cluster, n_clusters)
    if math.isnan(sd):
        return Share(share, math.nan, math.nan)
    # Nobody or everybody: no variance to see, so no more is claimed than as many photos can tell.
    size = share * (1 - share) / sd**2 if sd > 0 else n_clusters
    middle = (share + _Z**2 / (2 * size)) / (1 + _Z**2 / size)
    half = _Z / (1 + _Z**2 / size) * math.sqrt(share * (1 - share) / size + _Z**2 / (4 * size**2))
    return Share(share, max(0.0, middle - half), min(1.0, middle + half))


def _median(ordered: FloatArray, cluster: IntArray, n_clusters: int) -> Share:
    """Return the median of ordered distances, its interval read off where the distribution's own share is certain."""
    if not len(ordered):
        return Share(math.nan, math.nan, math.nan)
    median = float(np.quantile(ordered, 0.5))
    _, sd = _ratio_sd(ordered <= median, cluster, n_clusters)
    if math.isnan(sd):
        return Share(median, math.nan, math.nan)
    low, high = np.quantile(ordered, np.clip([0.5 - _Z * sd, 0.5 + _Z * sd], 0, 1))
    return Share(median, float(low), float(high))
