"""The numbers of a report on a results folder, counted in its tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ..archive.figures.focal_bases import focal_bases
from ..archive.figures.grouping import UNKNOWN, sql_of
from ..archive.figures.restriction import counted
from ..archive.figures.shoots import shoots_in_words
from ..archive.figures.summary import Share
from ..archive.store.duck import attached, quoted
from ..archive.store.folder import Folder
from ..archive.store.queries import with_columns
from ..arrays import nan_if_none
from ..camera import FocalBasis
from ..distances import ZONES
from ..people.attributes import PairsWhere
from ..people.doubts import PersonDoubt
from ..tables import DOUBT, NO_DOUBT, TABLES, reasons_in
from .distance_figures import Distances, distances_in


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
    """Everything that a report counts. Each count is a list of (what, how many), the most frequent first.

    groups: those with the most photos, of n_groups.
    """

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
    doubts: list[tuple[str, int]]
    on_ground: float
    nearest: Distances
    every: Distances
    n_groups: int
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
        nearest=distances_in(duck, "report_nearest"),
        every=distances_in(duck, "(SELECT * FROM report_pairs WHERE distance_m NOTNULL)"),
        n_groups=int(one("SELECT count(DISTINCT name) FROM report_groups")[0]),
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


#: Lines of a list of counts, and groups; the page has how many more there are.
_LINES, _GROUPS = 12, 40


def _counted(duck: Any, what: str, source: str) -> list[tuple[str, int]]:
    """Return how often each value occurs, the most frequent first, and all that are not listed as the last."""
    rows = duck.execute(
        "SELECT what, n, count(*) OVER () AS kinds, sum(n) OVER () AS every FROM "
        f"(SELECT coalesce({what}, '{UNKNOWN}') AS what, count(*) AS n FROM {source} GROUP BY ALL) "
        f"ORDER BY n DESC, what LIMIT {_LINES}"
    ).fetchall()
    listed = [(str(what), int(n)) for what, n, *_ in rows]
    if rows and rows[0][2] > len(rows):
        left = int(rows[0][3]) - sum(n for _, n in listed)
        listed.append((f"{rows[0][2] - len(rows):,} others", left))
    return listed


def _doubts(duck: Any) -> list[tuple[str, int]]:
    """Return how many people have each doubt; none of people measured before it was asked."""
    people = with_columns("report_people", TABLES["people"])
    found: Counter[str] = Counter()
    rows = duck.execute(f"SELECT {DOUBT}, count(*) FROM {people} WHERE {DOUBT} <> '{NO_DOUBT}' GROUP BY ALL")
    for text, n in rows.fetchall():
        found.update(dict.fromkeys(reasons_in(text), n))
    return [(_words_of(reason), n) for reason, n in found.most_common()]


def _words_of(reason: str) -> str:
    """Return a doubt to be read; one that only a later version knows, as the table has it."""
    try:
        return PersonDoubt(reason).words
    except ValueError:
        return reason


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
    """Return the groups with the most photos."""
    names = duck.execute(
        "SELECT name, count(*), coalesce(sum(n_people), 0) FROM report_groups JOIN report_photos USING (photo) "
        f"GROUP BY name ORDER BY count(*) DESC, name LIMIT {_GROUPS}"
    ).fetchall()
    return [
        Group(str(name), int(photos), int(people), *_group_figures(duck, str(name))) for name, photos, people in names
    ]


def _group_figures(duck: Any, name: str) -> tuple[Distances, tuple[Share, ...]]:
    """Return a group's distances to the nearest others, and the zones of all its pairs."""
    members = f"(SELECT photo FROM report_groups WHERE name = {quoted(name)})"
    pairs = f"(SELECT * FROM report_pairs SEMI JOIN {members} USING (photo) WHERE distance_m NOTNULL)"
    nearest = distances_in(duck, f"(SELECT * FROM report_nearest SEMI JOIN {members} USING (photo))")
    return nearest, distances_in(duck, pairs).zones
