"""What a run came to, printed: a line a photo for a few, the totals for all."""

from __future__ import annotations

from typing import Any

from ..archive.store.parts import attached, quoted
from ..archive.store.results import Results
from ..camera import FocalSource
from ..camera.published import quantile_mm
from ..distances import UNCERTAIN, ZONES, is_vague
from ..tables import TABLES
from .camera_options import WHAT_TO_STATE

_PHOTO_LINES, _FAILED_LINES = 40, 5
_ESTIMATED = " OR ".join(
    f"starts_with(focal_source, '{kind.words}')" for kind in (FocalSource.PEOPLE, FocalSource.LINES)
)
#: What was assumed, and how to do better, in one line.
_UNTOLD = (
    "ASSUMED  {} without a focal length: taken as published photos are (9 in 10 have a 35 mm equivalent of "
    f"{quantile_mm(0.05):.0f} to {quantile_mm(0.95):.0f} mm), so intervals are wide; if you know better, measure "
    "again with e.g. --focal-35mm 35 --restart (or --camera-table); --no-assume refuses"
)


def print_results(results: Results) -> int:
    """Print the tables of a results folder in short; return how many photos failed."""
    folder = results.folder
    duck = attached(folder)
    photos, people, pairs = (f"read_parquet({quoted(folder.path(f'{t}.parquet'))})" for t in TABLES)
    totals = _one_row(
        duck,
        "SELECT count(*) photos, count(*) FILTER (status = 'ok') measured, count(*) FILTER (status = 'failed') failed, "
        "count(*) FILTER (status = 'no_camera') no_camera, count(*) FILTER (status = 'excluded') excluded, "
        "count(*) FILTER (status = 'ok' AND focal_assumed) assumed, "
        f"count(*) FILTER (status = 'ok' AND focal_source = '{FocalSource.ASSUMED_PRIOR.words}') untold, "
        f"count(*) FILTER (status = 'ok' AND ({_ESTIMATED})) estimated, "
        "count(*) - count(DISTINCT nullif(sha256, '')) "
        "- count(*) FILTER (coalesce(sha256, '') = '') copies, sum(n_people) people, sum(n_pairs) pairs, "
        f"any_value(safe_distance_m) safe_m, sum(n_below_safe) below FROM {photos}",
    )
    if totals["photos"] <= _PHOTO_LINES:
        _print_photos(duck, photos, pairs)
    elif totals["failed"]:
        _print_failed(duck, photos, totals["failed"])
    _print_totals(duck, totals, people, pairs)
    if totals["untold"]:
        print(_UNTOLD.format(totals["untold"]))
    if totals["no_camera"]:
        print(f"\n{WHAT_TO_STATE}\n`reason` in photos.csv says what each photo lacks. With another statement, measure")
        print("again with --restart or another --out.\n")
    print(f"tables in {folder.location}: photos, people and pairs as CSV and Parquet")
    return totals["failed"]


def _one_row(duck: Any, query: str) -> dict[str, Any]:
    cursor = duck.execute(query)
    names = [d[0] for d in cursor.description]
    return dict(zip(names, cursor.fetchone(), strict=True))


def _print_photos(duck: Any, photos: str, pairs: str) -> None:
    rows = duck.execute(
        "SELECT photo, status, reason, n_people, n_pairs, nearest, low_m, high_m, person_a, person_b FROM "
        f"{photos} LEFT JOIN (SELECT photo, min(distance_m) nearest, arg_min(low_m, distance_m) low_m, "
        "arg_min(high_m, distance_m) high_m, arg_min(person_a, distance_m) person_a, "
        f"arg_min(person_b, distance_m) person_b FROM {pairs} GROUP BY photo) USING (photo) ORDER BY photo"
    ).fetchall()
    width = min(48, max(len("photo"), *(len(row[0]) for row in rows)))
    print(f"{'photo':{width}}  people  pairs  nearest pair [90 % interval]")
    for photo, status, reason, people, n_pairs, nearest, low, high, a, b in rows:
        if nearest is not None:
            said = f"{a}-{b}: {nearest:.2f} m [{low:.2f}, {high:.2f}]{' ?' if is_vague(low, high) else ''}"
        elif status == "ok":
            said = reason or ("nobody could be placed" if people > 1 else "one person")
        else:
            said = "no focal length" if status == "no_camera" else f"{status}: {reason}"
        shown = photo if len(photo) <= width else "..." + photo[3 - width :]
        print(f"{shown:{width}}  {_count(people):>6}  {_count(n_pairs):>5}  {said}")
    if any(low is not None and is_vague(low, high) for *_, low, high, _, _ in rows):
        print("?: too uncertain for one number: read the interval")
    print()


def _count(number: int | None) -> str:
    return "-" if number is None else str(number)


def _print_failed(duck: Any, photos: str, count: int) -> None:
    """Print why photos failed: the first few of them."""
    rows = duck.execute(
        f"SELECT photo, reason FROM {photos} WHERE status = 'failed' ORDER BY photo LIMIT {_FAILED_LINES}"
    ).fetchall()
    for photo, reason in rows:
        print(f"failed   {photo}: {reason}")
    if count > len(rows):
        print(f"         and {count - len(rows)} more: status and reason in photos.csv")


def _nearest(duck: Any, people: str) -> str:
    """Return the headline: the median distance to the nearest other person."""
    found = _one_row(duck, f"SELECT median(nearest_m) m, count(nearest_m) n FROM {people}")
    return (
        f": median distance to the nearest other person {found['m']:.2f} m ({found['n']} people)" if found["n"] else ""
    )


def _print_totals(duck: Any, totals: dict[str, Any], people: str, pairs: str) -> None:
    rest = [
        f"{totals[key]} {text}"
        for key, text in (
            ("no_camera", "without a focal length (their people have no distances)"),
            ("failed", "failed"),
            ("excluded", "excluded in review"),
            ("copies", "the same file as another"),
        )
        if totals[key]
    ]
    marked = [
        f"{totals[key]} with an {word} focal length"
        for key, word in (("assumed", "ASSUMED"), ("estimated", "estimated"))
        if totals[key]
    ]
    assumed = f" ({', '.join(marked)})" if marked else ""
    print(f"photos   {totals['photos']}: {totals['measured']} measured{assumed}{''.join(', ' + r for r in rest)}")
    print(f"people   {totals['people'] or 0}{_nearest(duck, people)}")
    counts = ", ".join(f"sum(p_{zone}) {zone}" for zone in ZONES)
    found = _one_row(
        duck,
        f"SELECT count(*) n, median(distance_m) median, count(*) FILTER (zone = '{UNCERTAIN}') uncertain, {counts} "
        f"FROM {pairs} WHERE distance_m IS NOT NULL",
    )
    if not found["n"]:
        print("pairs    0")
        return
    zones = ", ".join(f"{zone} {found[zone] / found['n']:.0%}" for zone in ZONES)
    print(f"pairs    {found['n']}: {zones} (by their probabilities); median of all pairs {found['median']:.2f} m")
    if found["uncertain"]:
        print(f"         {found['uncertain']} of uncertain zone: read their intervals and probabilities")
    if totals["safe_m"] is not None:
        print(f"         {totals['below']} nearer than {totals['safe_m']:g} m")
