"""The results of a run, printed: a line per photo for small runs, the totals for all."""

from __future__ import annotations

import math
import textwrap

from ..archive.figures.focal_bases import in_words
from ..archive.figures.totals import PhotoLine, Totals, failures, photo_lines, totals
from ..archive.store.folder import Folder
from ..archive.store.results import Results
from ..camera.published import quantile_mm
from ..distances import is_vague
from ..errors import one_line
from ..plots.pair_selection import VAGUE_MARK, metres_text
from ..text_tables import terminal_width
from .camera_options import WHAT_TO_STATE

_PHOTO_LINES, _FAILED_LINES = 40, 5
#: What was assumed, and how to do better, in one line.
_UNTOLD = (
    "ASSUMED  {} without a focal length, taken to be like published photos (9 in 10 have a 35 mm equivalent of "
    f"{quantile_mm(0.05):.0f} to {quantile_mm(0.95):.0f} mm), so their intervals are wide. If you know the lens, "
    "measure again with e.g. --focal-35mm 35 --restart (or --camera-table); --no-assume gives no distances instead"
)


def print_results(results: Results) -> int:
    """Print the tables of a results folder in short; return how many photos failed."""
    folder = results.folder
    counts = totals(folder)
    if counts.photos <= _PHOTO_LINES:
        _print_photos(photo_lines(folder))
    elif counts.failed:
        _print_failed(folder, counts.failed)
    _print_totals(counts)
    if counts.untold:
        text = _UNTOLD.format(counts.untold)
        print(textwrap.fill(text, terminal_width(), subsequent_indent=" " * 9))
    if counts.no_camera:
        print(f"\nWithout a focal length there are no distances. {WHAT_TO_STATE}")
        print("`reason` in photos.csv states what each photo lacks. Then measure again with --restart,")
        print("or into another --out.\n")
    print(f"tables in {folder.location}: photos, people and pairs as CSV and Parquet")
    return counts.failed


def _print_photos(lines: list[PhotoLine]) -> None:
    names = [one_line(line.photo) for line in lines]
    width = min(48, max(map(len, ["photo", *names])))
    print(f"{'photo':{width}}  people  pairs  nearest pair [90 % interval]")
    for line, name in zip(lines, names, strict=True):
        shown = name if len(name) <= width else "..." + name[3 - width :]
        print(f"{shown:{width}}  {_count(line.n_people):>6}  {_count(line.n_pairs):>5}  {_nearest(line)}")
    if any(map(_is_vague, lines)):
        print("?: too uncertain for one number: read the interval")
    print()


def _is_vague(line: PhotoLine) -> bool:
    return line.low_m is not None and line.high_m is not None and is_vague(line.low_m, line.high_m)


def _nearest(line: PhotoLine) -> str:
    if line.nearest_m is not None:
        ends = [math.nan if end is None else end for end in (line.low_m, line.high_m)]
        vague = f" {VAGUE_MARK}" if _is_vague(line) else ""
        return f"{line.person_a}-{line.person_b}: {metres_text(line.nearest_m, *ends)}{vague}"
    if line.status == "ok":
        return line.reason or ("no person could be placed" if (line.n_people or 0) > 1 else "one person")
    return "no focal length" if line.status == "no_camera" else one_line(f"{line.status}: {line.reason}")


def _count(number: int | None) -> str:
    return "-" if number is None else str(number)


def _print_failed(folder: Folder, count: int) -> None:
    """Print why photos failed: the first few of them."""
    first = failures(folder, _FAILED_LINES)
    for photo, reason in first:
        print(f"failed   {one_line(f'{photo}: {reason}')}")
    if count > len(first):
        print(f"         and {count - len(first)} more: status and reason in photos.csv")


def _print_totals(counts: Totals) -> None:
    rest = [
        f"{count} {text}"
        for count, text in (
            (counts.no_camera, "without a focal length (their people have no distances)"),
            (counts.failed, "failed"),
            (counts.excluded, "excluded in review"),
            (counts.copies, "the same file as another (summary --distinct counts such files once)"),
        )
        if count
    ]
    print(f"photos   {counts.photos}: {counts.measured} measured{''.join(', ' + r for r in rest)}")
    if counts.measured:
        print(f"         focal lengths: {in_words(counts.bases)}")
    if counts.nearest_m is None:
        print(f"people   {counts.people}")
    else:
        nearest = f"median distance to the nearest other person {metres_text(counts.nearest_m)}"
        print(f"people   {counts.people}: {nearest} ({counts.with_nearest} people)")
    doubts = [f"{counts.duplicates} may be counted twice"] if counts.duplicates else []
    if others := counts.doubtful - counts.duplicates:
        doubts.append(f"{others} may not be {'a person' if others == 1 else 'people'} (animals, posters, legs alone)")
    if doubts:
        print(f"         in doubt: {', '.join(doubts)}; see doubt in people.csv")
    if not counts.pairs:
        print("pairs    0")
        return
    zones = ", ".join(f"{zone} {share:.0%}" for zone, share in counts.zone_shares.items())
    print(f"pairs    {counts.pairs}: {zones} (by their probabilities)")
    print(
        f"         median of all pairs {metres_text(counts.median_m or math.nan)}, which mostly reflects the size of "
        "crowds"
    )
    if counts.uncertain:
        print(f"         {counts.uncertain} of uncertain zone: read their intervals and probabilities")
    if counts.safe_distance_m is not None:
        print(f"         {counts.below_safe} nearer than {counts.safe_distance_m:g} m")
