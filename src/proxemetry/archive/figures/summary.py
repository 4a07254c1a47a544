"""An archive's figures by group: counts, the nearest other person, the share of each zone, with sampling intervals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray, IntArray
from ...camera import FocalBasis
from ...distances import ZONES
from ...errors import OutputError
from ...people.attributes import PairsWhere
from ..store.damage import require_columns
from ..store.duck import attached
from ..store.folder import Folder
from ..store.results import Results
from .grouping import sql_of
from .restriction import Counted, counted, nearest_of
from .sampling import Estimates, Sample


@dataclass(frozen=True)
class Share:
    """A figure and the central 90 % of where it may lie, given how many photos there are; NaN where unknown."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Group:
    """One group. key: its values, None where a photo's is unknown.

    bases: what the focal lengths of its measured photos rest on, how many of each. nearest_m: the median over people of
    the distance to the nearest other person. zones: the shares of all pairs in each of `ZONES`, every pair counted by
    its probabilities, which takes account of how uncertain single distances are. pairs_m: the median distance of all
    pairs, which in photos of crowds mostly reflects the size of the crowd.
    """

    key: tuple[str | None, ...]
    n_photos: int
    n_photos_with_pairs: int
    n_people: int
    n_pairs: int
    bases: Mapping[FocalBasis, int]
    nearest_m: Share
    zones: tuple[Share, ...]
    pairs_m: Share


@dataclass(frozen=True, eq=False)
class Summary:
    """Groups in the order of their keys, and for figures every person's nearest other and group (row of `groups`)."""

    by: tuple[str, ...]
    groups: tuple[Group, ...]
    nearest_m: FloatArray
    group_of_person: IntArray

    def rows(self) -> list[dict[str, Any]]:
        """Return one flat row a group: what is printed and written."""
        return [
            {
                **dict(zip(self.by, group.key, strict=True)),
                "n_photos": group.n_photos,
                "n_photos_with_pairs": group.n_photos_with_pairs,
                "n_people": group.n_people,
                "n_pairs": group.n_pairs,
                **{f"n_focal_{basis}": group.bases[basis] for basis in FocalBasis},
                **_columns("nearest_median", group.nearest_m),
                **{
                    f"{zone}{ending}": getattr(share, name)
                    for zone, share in zip(ZONES, group.zones, strict=True)
                    for ending, name in (("", "value"), ("_low", "low"), ("_high", "high"))
                },
                **_columns("pairs_median", group.pairs_m),
            }
            for group in self.groups
        ]


def _columns(name: str, share: Share) -> dict[str, float]:
    """Return a length with its interval as columns."""
    return {f"{name}_m": share.value, f"{name}_low_m": share.low, f"{name}_high_m": share.high}


#: What is read of the tables, besides the columns of `by`.
_NEEDED = {
    "photos": ("photo", "sha256", "status", "n_people", "n_pairs", "focal_basis"),
    "people": ("photo", "nearest_m"),
    "pairs": ("photo", "distance_m", *(f"p_{zone}" for zone in ZONES)),
}


def summarise(
    results: Results, by: Sequence[str] = (), *, distinct: bool = False, where: PairsWhere | None = None,
    tables: Folder | None = None,
) -> Summary:  # fmt: skip
    """Return the figures of a finished results folder by year, month, folder or any column of the photos table.

    Photos that a reviewer excluded do not count. distinct: copies of one file count once a group. where: only people
    with these attributes count, and pairs of two such people. tables: the folder that holds the tables, that of the
    results where None. Raises SettingsError for an unknown column and where no one matches `where`, OutputError
    where the tables are not there yet.
    """
    folder = tables or results.folder
    if not all(folder.exists(f"{table}.parquet") for table in ("photos", "people", "pairs")):
        raise OutputError(f"{folder.location}: no tables there yet; finish the run, then try again")
    keys = [sql_of(name) for name in by]
    duck = attached(folder, threads=None)
    require_columns(folder, duck, _NEEDED)
    names = [f"k{i}" for i in range(len(keys))]
    rows = counted(folder, where)
    with ThreadPoolExecutor(1) as reader:  # pairs and people are read while photos are counted
        reading = reader.submit(_pairs, results.tables_belong_together(folder), rows, duck.cursor())
        nearest = reader.submit(_nearest, rows, duck.cursor())
        _count_photos(duck, rows, keys, distinct)
        query = f"SELECT {', '.join([*names, *FocalBasis, 'n_photos', 'n_people'])} FROM grouped ORDER BY g"
        listed = duck.execute(query).fetchall()
        group_of_row = _group_of_row(duck, names)
        pairs = _grouped(reading.result(), group_of_row, len(listed))
        people = _grouped(nearest.result(), group_of_row, len(listed))
    return Summary(tuple(by), _groups(listed, pairs, people), people["nearest_m"], people["group"])


def _count_photos(duck: Any, tables: Counted, keys: Sequence[str], distinct: bool) -> None:
    """Make the table `counted` of the photos that count, by their place in the file, and `grouped` of their groups."""
    selected = "".join(f", {key}::VARCHAR AS k{i}" for i, key in enumerate(keys))
    names = [f"k{i}" for i in range(len(keys))]
    once = ", ".join(["CASE WHEN coalesce(sha256, '') = '' THEN photo ELSE sha256 END", *names])
    duck.execute(
        "CREATE OR REPLACE TEMP TABLE counted AS "
        f"SELECT file_row_number AS row, n_people, status, focal_basis{selected} "
        f"FROM {_by_row(tables)} WHERE status <> 'excluded'"
        + (f" QUALIFY row_number() OVER (PARTITION BY {once} ORDER BY photo) = 1" if distinct else "")
    )
    grouped = f" GROUP BY {', '.join(names)}" if names else ""
    order = f"ORDER BY {', '.join(f'{n} NULLS LAST' for n in names)}" if names else ""
    bases = [f"count(*) FILTER (status = 'ok' AND focal_basis = '{basis}') AS {basis}" for basis in FocalBasis]
    figures = ", ".join([*names, *bases, "count(*) AS n_photos", "sum(n_people) AS n_people"])
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


def _by_row(tables: Counted) -> str:
    """Return the photos with their rows' numbers in the file, `file_row_number`."""
    return tables.photos if tables.restricted else tables.photos.removesuffix(")") + ", file_row_number = true)"


def _pairs(belong_together: bool, tables: Counted, duck: Any) -> dict[str, Any]:
    """Return columns of all measured pairs: their photo's row in the photos table, distance and probabilities.

    Both tables are in the order of names, and the photos' rows have the number of pairs: where both were written
    together, that gives each pair's photo without comparing names. Otherwise the names are joined.
    """
    columns = ", ".join(["distance_m", *(f"p_{zone}" for zone in ZONES)])
    if not tables.restricted and belong_together:
        found = duck.execute(f"SELECT {columns} FROM {tables.pairs} WHERE distance_m IS NOT NULL").fetchnumpy()
        each = np.ma.filled(duck.execute(f"SELECT n_pairs FROM {tables.photos}").fetchnumpy()["n_pairs"], 0)
        if int(each.sum()) == len(found["distance_m"]):
            return {**found, "row": np.repeat(np.arange(len(each)), each)}
    return duck.execute(
        f"SELECT {columns}, row FROM {tables.pairs} JOIN (SELECT photo, file_row_number AS row FROM "
        f"{_by_row(tables)}) USING (photo) WHERE distance_m IS NOT NULL ORDER BY row"
    ).fetchnumpy()


def _nearest(tables: Counted, duck: Any) -> dict[str, Any]:
    """Return each person's distance to the nearest other one, where there is any, and their photo's row."""
    people = nearest_of(tables.pairs) if tables.restricted else tables.people
    return duck.execute(
        f"SELECT nearest_m, row FROM {people} JOIN (SELECT photo, file_row_number AS row FROM {_by_row(tables)}) "
        "USING (photo) WHERE nearest_m IS NOT NULL ORDER BY row"
    ).fetchnumpy()


def _grouped(found: dict[str, Any], group_of_row: IntArray, n_groups: int) -> dict[str, Any]:
    """Return the columns of the rows that count, group after group, a photo's rows together in each."""
    rows = np.asarray(found["row"])
    inside = np.append(group_of_row, -1)[np.minimum(rows, len(group_of_row))]
    if n_groups == 1 and bool((inside == 0).all()):  # everything in one group: as it stands
        chosen: Any = slice(None)
    else:
        # Sixteen bits are sorted without comparing: a tenth of the time.
        small = inside.astype(np.int16) if n_groups < 2**15 else inside
        chosen = np.argsort(small, kind="stable")[int((inside < 0).sum()) :]
    columns = {name: np.ma.filled(values, np.nan)[chosen] for name, values in found.items() if name != "row"}
    return {**columns, "group": inside[chosen], "row": rows[chosen]}


def _sample(found: dict[str, Any], n_groups: int) -> Sample:
    return Sample(found["group"], found["row"], n_groups)


def _groups(listed: Sequence[tuple[Any, ...]], pairs: dict[str, Any], people: dict[str, Any]) -> tuple[Group, ...]:
    """Return the groups as listed: their keys, numbers by focal length's basis, numbers of photos and of people."""
    sample = _sample(pairs, len(listed))
    zones = [sample.shares(pairs[f"p_{zone}"]) for zone in ZONES]
    medians = sample.medians(pairs["distance_m"])
    nearest = _sample(people, len(listed)).medians(people["nearest_m"])
    return tuple(
        Group(
            key=tuple(row[: -2 - len(FocalBasis)]),
            bases=dict(zip(FocalBasis, row[-2 - len(FocalBasis) : -2], strict=True)),
            n_photos=row[-2],
            n_photos_with_pairs=int(sample.n_photos[i]),
            n_people=int(row[-1] or 0),
            n_pairs=int(sample.size[i]),
            nearest_m=_share(nearest, i),
            zones=tuple(_share(zone, i) for zone in zones),
            pairs_m=_share(medians, i),
        )
        for i, row in enumerate(listed)
    )


def _share(estimates: Estimates, group: int) -> Share:
    return Share(*(float(values[group]) for values in (estimates.value, estimates.low, estimates.high)))
