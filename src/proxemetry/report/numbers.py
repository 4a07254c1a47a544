"""The numbers of a report on a results folder, counted in its tables."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..archive.figures.focal_bases import focal_bases
from ..archive.figures.grouping import UNKNOWN, sql_of
from ..archive.figures.restriction import counted
from ..archive.figures.sampling import median_levels, share_interval
from ..archive.figures.shoots import shoots_in_words
from ..archive.figures.summary import Share
from ..archive.store.duck import attached, quoted
from ..archive.store.folder import Folder
from ..archive.store.queries import with_columns
from ..arrays import FloatArray, nan_if_none
from ..camera import FocalBasis
from ..distances import ZONE_LIMITS_M, ZONES
from ..people.attributes import PairsWhere
from ..people.doubts import PersonDoubt
from ..tables import DOUBT, NO_DOUBT, TABLES, reasons_in

#: Histogram: edges in metres, each about a quarter above the one before, so that Hall's limits are among them; what
#: lies before the first or beyond the last is a bar of its own.
EDGES_M = (
    *(round(ZONE_LIMITS_M[0] * 1.3**k, 3) for k in range(-5, 0)),
    *(round(low * (high / low) ** (k / 4), 3) for low, high in itertools.pairwise(ZONE_LIMITS_M) for k in range(4)),
    *(round(ZONE_LIMITS_M[-1] * 1.3**k, 3) for k in range(10)),
)


@dataclass(frozen=True)
class Distances:
    """Distances of one kind in some photos.

    n: how many. median_m with low_m, high_m: its central 90 % interval over photos. quartiles_m: lower and upper.
    zones: for each of Hall's zones the share of the distances, each counted by its probability of lying there.
    counts: the histogram, one more than `EDGES_M`.
    """

    n: int
    n_photos: int
    median_m: float
    low_m: float
    high_m: float
    quartiles_m: tuple[float, float]
    zones: tuple[Share, ...]
    counts: tuple[int, ...]


@dataclass(frozen=True)
class Group:
    """One group of photos: distances to the nearest other person, and the zones of all its pairs."""

    name: str
    photos: int
    people: int
    nearest: Distances
    zones: tuple[Share, ...]


@dataclass(frozen=True)
class Pair:
    """One pair, for the lists of the nearest and the least certain. p_zones: its probabilities, as `ZONES`."""

    photo: str
    person_a: int
    person_b: int
    distance_m: float
    low_m: float
    high_m: float
    zone: str
    p_zones: tuple[float, ...]


@dataclass(frozen=True)
class Numbers:
    """Everything that a report counts. Each count is a list of (what, how many), the most frequent first."""

    photos: int
    people: int
    pairs: int
    corrected: int
    statuses: list[tuple[str, int]]
    measured: int
    bases: Mapping[FocalBasis, int]
    refusals: list[tuple[str, int]]
    unplaced: list[tuple[str, int]]
    focal_sources: list[tuple[str, int]]
    shoots: list[str]
    flags: list[tuple[str, int]]
    doubts: list[tuple[PersonDoubt, int]]
    on_ground: float
    nearest: Distances
    every: Distances
    groups: list[Group]
    nearest_pairs: list[Pair]
    uncertain_pairs: list[Pair]
    sample: list[str]


def count(folder: Folder, group_by: str, n_sample: int, n_listed: int, where: PairsWhere | None = None) -> Numbers:
    """Return the numbers of a results folder whose tables are up to date, of those who are as `where` has them.

    Raises SettingsError for `group_by`, and where there is no such person.
    """
    key = sql_of(group_by)
    tables = counted(folder, where)
    duck = attached(folder)
    for table, rows in (("photos", tables.photos), ("people", tables.people), ("pairs", tables.pairs)):
        duck.execute(f"CREATE OR REPLACE TEMP VIEW report_{table} AS SELECT * FROM {rows}")
    duck.execute(
        f"CREATE OR REPLACE TEMP TABLE report_groups AS SELECT photo, coalesce({key}::VARCHAR, '{UNKNOWN}') AS name "
        "FROM report_photos WHERE status != 'excluded'"
    )
    duck.execute(_NEAREST)

    def one(query: str) -> Any:
        return duck.execute(query).fetchone()

    photos, corrected = one("SELECT count(*), coalesce(sum(CAST(corrections > 0 AS INTEGER)), 0) FROM report_photos")
    (measured,) = one("SELECT count(*) FROM report_photos WHERE status = 'ok'")
    (people,) = one("SELECT count(*) FROM report_people")
    pairs, on_ground = one(
        "SELECT count(*), coalesce(avg(CAST(on_ground AS DOUBLE)), 0) FROM report_pairs WHERE distance_m NOTNULL"
    )
    return Numbers(
        photos=int(photos),
        people=int(people),
        pairs=int(pairs),
        corrected=int(corrected),
        statuses=_counted(duck, "status", "report_photos"),
        measured=int(measured),
        bases=focal_bases(duck, "report_photos"),
        refusals=_counted(duck, _WHY, "report_photos WHERE status != 'ok'"),
        unplaced=_counted(duck, "reason", "report_people WHERE x_m IS NULL AND reason IS NOT NULL"),
        focal_sources=_counted(duck, "coalesce(focal_source, 'unknown')", "report_photos WHERE status != 'failed'"),
        shoots=shoots_in_words(folder),
        flags=_counted(
            duck,
            _DOUBT_OF_ANY_SIZE,
            "(SELECT unnest(string_split(camera_flags, '; ')) flag FROM report_photos) WHERE flag != ''",
        ),
        doubts=_doubts(duck),
        on_ground=float(on_ground),
        nearest=_distances(duck, "report_nearest"),
        every=_distances(duck, "(SELECT * FROM report_pairs WHERE distance_m NOTNULL)"),
        groups=_groups(duck),
        nearest_pairs=_listed(duck, "distance_m", n_listed),
        uncertain_pairs=_listed(duck, "(high_m - low_m) / distance_m DESC", n_listed),
        sample=[r[0] for r in duck.execute(_SAMPLE, {"n": n_sample}).fetchall()],
    )


# Each person's nearest other: the distance that proxemics is about; all pairs of a crowd are mostly its size.
_NEAREST = """
CREATE OR REPLACE TEMP TABLE report_nearest AS
SELECT photo, person, best.* FROM (
    SELECT photo, person,
        arg_min(struct_pack(distance_m, p_intimate, p_personal, p_social, p_public), distance_m) AS best
    FROM (SELECT photo, person_a AS person, * EXCLUDE (photo) FROM report_pairs
          UNION ALL SELECT photo, person_b AS person, * EXCLUDE (photo) FROM report_pairs)
    WHERE distance_m IS NOT NULL GROUP BY photo, person)
"""

# Without the photo's name, and without what to do about it and what else was tried, like reasons are counted together.
_WHY = (
    r"regexp_replace(CASE status WHEN 'no_camera' THEN split_part(reason, '; ', 1) ELSE reason END, "
    r"'^.*?' || regexp_escape(parse_filename(photo)) || ':?\s*', '')"
)

# Without the photo's size, with which some begin, like doubts are counted together.
_DOUBT_OF_ANY_SIZE = r"regexp_replace(flag, '^\d+ x \d+: ', '')"

# The same photos whenever the report is written, and not the first of the alphabet.
_SAMPLE = "SELECT photo FROM report_photos WHERE n_pairs > 0 AND status = 'ok' ORDER BY md5(photo) LIMIT $n"


def _counted(duck: Any, what: str, source: str) -> list[tuple[str, int]]:
    rows = duck.execute(
        f"SELECT {what} AS what, count(*) AS n FROM {source} GROUP BY what ORDER BY n DESC, what LIMIT 12"
    ).fetchall()
    return [(str(what), int(n)) for what, n in rows]


def _doubts(duck: Any) -> list[tuple[PersonDoubt, int]]:
    """Return how many people have each doubt; none of people measured before it was asked."""
    people = with_columns("report_people", TABLES["people"])
    found: Counter[str] = Counter()
    for text, n in _counted(duck, DOUBT, f"{people} WHERE {DOUBT} <> '{NO_DOUBT}'"):
        found.update(dict.fromkeys(reasons_in(text), n))
    return [(PersonDoubt(reason), n) for reason, n in found.most_common()]


def _listed(duck: Any, order: str, count: int) -> list[Pair]:
    rows = duck.execute(
        f"SELECT photo, person_a, person_b, distance_m, low_m, high_m, zone, {', '.join(f'p_{z}' for z in ZONES)} "
        f"FROM report_pairs WHERE distance_m > 0 ORDER BY {order}, photo, person_a, person_b LIMIT {int(count)}"
    ).fetchall()
    return [
        Pair(
            str(p),
            int(a),
            int(b),
            float(d),
            nan_if_none(low),
            nan_if_none(high),
            str(zone or ""),
            tuple(map(nan_if_none, shares)),
        )
        for p, a, b, d, low, high, zone, *shares in rows
    ]


def _groups(duck: Any) -> list[Group]:
    names = duck.execute(
        "SELECT name, count(*), coalesce(sum(n_people), 0) FROM report_groups JOIN report_photos USING (photo) "
        "GROUP BY name ORDER BY count(*) DESC, name LIMIT 40"
    ).fetchall()
    return [
        Group(str(name), int(photos), int(people), *_group_figures(duck, str(name))) for name, photos, people in names
    ]


def _group_figures(duck: Any, name: str) -> tuple[Distances, tuple[Share, ...]]:
    """Return a group's distances to the nearest others, and the zones of all its pairs."""
    members = f"(SELECT photo FROM report_groups WHERE name = {quoted(name)})"
    pairs = f"(SELECT * FROM report_pairs SEMI JOIN {members} USING (photo) WHERE distance_m NOTNULL)"
    nearest = _distances(duck, f"(SELECT * FROM report_nearest SEMI JOIN {members} USING (photo))")
    return nearest, _distances(duck, pairs).zones


def _distances(duck: Any, source: str) -> Distances:
    n, median, lower, upper = duck.execute(
        f"SELECT count(*), quantile_cont(distance_m, 0.5), quantile_cont(distance_m, 0.25), "
        f"quantile_cont(distance_m, 0.75) FROM {source}"
    ).fetchone()
    if not n:
        nothing = Share(math.nan, math.nan, math.nan)
        return Distances(
            0, 0, math.nan, math.nan, math.nan, (math.nan, math.nan), (nothing,) * len(ZONES), (0,) * (len(EDGES_M) + 1)
        )
    sums = ", ".join(f"sum(p_{zone})" for zone in ZONES)
    table = np.array(
        duck.execute(
            f"SELECT count(*), sum(CAST(distance_m <= {median!r} AS INTEGER)), {sums} FROM {source} GROUP BY photo"
        ).fetchall(),
        dtype=float,
    )
    zones = [ratio_over_photos(table[:, k], table[:, 0]) for k in range(2, table.shape[1])]
    low, high = _median_interval(duck, source, _ratio(table[:, 1], table[:, 0])[1], len(table))
    bars = dict(
        duck.execute(
            f"SELECT {' + '.join(f'CAST(distance_m >= {edge} AS INTEGER)' for edge in EDGES_M)} AS bar, count(*) "
            f"FROM {source} GROUP BY bar"
        ).fetchall()
    )
    return Distances(
        int(n), len(table), float(median), low, high, (float(lower), float(upper)), tuple(zones),
        tuple(int(bars.get(k, 0)) for k in range(len(EDGES_M) + 1)),
    )  # fmt: skip


def _median_interval(duck: Any, source: str, below_sd: float, n_photos: int) -> tuple[float, float]:
    """Return the median's interval (Woodruff 1952); below_sd: of the share of distances up to the median."""
    levels = [float(level[0]) for level in median_levels(np.array([below_sd]), np.array([n_photos]))]
    if not all(map(math.isfinite, levels)):
        return math.nan, math.nan
    low, high = duck.execute(
        f"SELECT quantile_cont(distance_m, {levels[0]!r}), quantile_cont(distance_m, {levels[1]!r}) FROM {source}"
    ).fetchone()
    return float(low), float(high)


def ratio_over_photos(parts: FloatArray, totals: FloatArray) -> Share:
    """Return the sum of `parts` over that of `totals`, one of each a photo, with its central 90 % interval.

    The interval is that of `sampling.share_interval`, as in a summary; NaN with a single photo.
    """
    value, sd = _ratio(parts, totals)
    low, high = share_interval(np.array([value]), np.array([sd]), np.array([len(parts)]))
    return Share(value, float(low[0]), float(high[0]))


def _ratio(parts: FloatArray, totals: FloatArray) -> tuple[float, float]:
    """Return a ratio over photos and its standard deviation, a ratio estimator's (Cochran 1977, section 6.4).

    NaN for that of a single photo.
    """
    parts, totals, n = np.asarray(parts, dtype=float), np.asarray(totals, dtype=float), len(parts)
    value = float(parts.sum() / totals.sum())
    if n < 2:
        return value, math.nan
    return value, math.sqrt(float(((parts - value * totals) ** 2).sum()) * n / (n - 1)) / float(totals.sum())


def names_of(shares: Sequence[Share]) -> list[tuple[str, Share]]:
    """Return Hall's zones with their shares."""
    return list(zip(ZONES, shares, strict=True))
