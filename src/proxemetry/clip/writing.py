"""The files of a clip's folder: tables as CSV and Parquet, codebook, maps, summary, exports for other programs.

Rows are written as they come, so that hours of many people need no more memory than minutes.
"""

from __future__ import annotations

import csv
import math
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from typing import Any, TextIO

import numpy as np

from ..archive.store import parts
from ..archive.store.duck import attached, named, quoted
from ..archive.store.folder import Folder
from ..arrays import FloatArray
from ..files import FORMULA, cell_of
from ..people.attributes import keys_of
from ..people.doubts import PersonDoubt
from ..tables import MOST_COLUMNS, Column, csv_about, doubts_in_text
from .analysis import Analysis, Person, places_by_frame
from .columns import OF_TRACKS, TABLES, codebook, columns
from .density import Maps, Region, classic_density, personal_space_m2
from .events import events_of
from .exposure import PairOverTime, TotalExposure, same_group
from .summary import Sums

MAPS, CODEBOOK = "maps.npz", "codebook.csv"
#: A cell of an aggregate that fewer people make is left empty with --aggregate-only.
FEWEST_PEOPLE = 5


def _cell(value: Any) -> Any:
    if value is None:
        return ""
    if isinstance(value, bool | np.bool_):
        return "true" if value else "false"
    if isinstance(value, float | np.floating):
        return f"{value:.7g}" if math.isfinite(value) else ""
    return value


class _Table:
    """One table being written: CSV row by row, Parquet from it at the end."""

    def __init__(self, folder: Folder, name: str, columns: tuple[Column, ...], stack: ExitStack) -> None:
        self._folder, self._name, self._columns = folder, name, columns
        self._path = stack.enter_context(folder.writing(f"{name}.csv"))
        self._file: TextIO = stack.enter_context(open(self._path, "w", newline="", encoding="utf-8"))  # noqa: SIM115
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._writer.writerow(c.name for c in columns)

    def row(self, *values: Any) -> None:
        """Write one row."""
        self._writer.writerow([_cell(v) for v in values])

    def finish(self) -> None:
        """Write the Parquet file."""
        self._file.flush()
        kinds = ", ".join(f"{quoted(c.name)}: {quoted(c.kind)}" for c in self._columns)
        texts = ", ".join(_uncelled(c) for c in self._columns)
        with self._folder.writing(f"{self._name}.parquet") as temporary:
            attached(self._folder).execute(
                f"COPY (SELECT {texts} FROM read_csv({quoted(self._path)}, header = true, columns = {{{kinds}}})) "
                f"TO {quoted(temporary)} (FORMAT parquet, COMPRESSION zstd)"
            )


def _uncelled(column: Column) -> str:
    """Return the SQL of a column without the apostrophe that CSV has before what looks like a formula."""
    name = named(column.name)
    if column.kind != "VARCHAR":
        return name
    marked = f"starts_with({name}, chr(39)) AND regexp_matches({name}, {quoted(FORMULA)})"
    return f"CASE WHEN {marked} THEN {name}[2:] ELSE {name} END AS {name}"


def write_results(found: Analysis, folder: Folder, *, aggregate_only: bool = False, shown: int = 6) -> Sums:
    """Write every table and the maps; return the sums for summary and page, with `shown` pairs for curves."""
    limits = found.wanted.within_m
    nothing = np.where(found.followed[:, None], np.zeros((1, len(limits))), np.nan)
    sums = Sums(nothing, nothing.copy())
    seconds = (found.measured.times_s[-1] if found.measured.times_s else 0.0) + 1e-9
    sums.maps = None if found.region is None else Maps.over(found.region, seconds, limits)
    for name in TABLES:
        for form in ("csv", "parquet"):
            folder.remove(f"{name}.{form}")
    wanted = ("frames",) if aggregate_only else TABLES
    keys = () if aggregate_only else attributes_of(found)
    with ExitStack() as stack:
        tables = {name: _Table(folder, name, columns(name, limits, keys), stack) for name in wanted}
        _pairs(found, tables, sums, shown)
        _people(found, tables, sums)
        _frames(found, tables["frames"], sums)
        for table in tables.values():
            table.finish()
    folder.write(CODEBOOK, csv_about(codebook(limits, keys)).encode())
    if sums.maps is not None:
        _write_maps(found, folder, sums.maps, aggregate_only)
    return sums


def attributes_of(found: Analysis) -> tuple[str, ...]:
    """Return the attributes of people that the table of people has columns of: of very many the first by name."""
    return keys_of([p.attributes for p in found.people])[:MOST_COLUMNS]


def _pairs(found: Analysis, tables: Mapping[str, _Table], sums: Sums, shown: int) -> None:
    limits = found.wanted.within_m
    total = TotalExposure(len(limits))
    member = {p.track.number: p.group for p in found.people}
    tracks = {p.track.number: p for p in found.people}
    main = found.main_camera
    for pair in found.pairs():
        p_same = same_group(found.probability, pair.a, pair.b)
        together = member[pair.a] == member[pair.b]
        total.add(pair, p_same)
        sums.n_pairs += 1
        sums.within[pair.frames] += pair.near.p_within
        sums.within_apart[pair.frames] += (1 - p_same) * pair.near.p_within
        for one in (pair.a, pair.b):
            sums.of_person[one] = sums.of_person.get(one, 0.0) + pair.seconds
            sums.of_person_apart[one] = sums.of_person_apart.get(one, 0.0) + (1 - p_same) * pair.seconds
            if sums.maps is not None and found.frames[pair.frames[0]].camera == main:
                track = tracks[one].track
                places = track.positions_m[pair.frames - track.frames[0]]
                sums.maps.add_exposure(places, pair.near.p_within * pair.weight_s[:, None])
        facing = [found.facing.get((int(f), pair.a, pair.b), 0.0) for f in pair.frames]
        if "pairs_over_time" in tables:
            _pair_rows(pair, facing, tables["pairs_over_time"])
            _exposure_row(pair, facing, p_same, together, tables["exposure"])
        for event in events_of(pair, limits, found.wanted.shortest_event_s):
            sums.events.append((event, p_same))
            if "events" in tables:
                tables["events"].row(
                    event.a, event.b, event.within_m, event.begin_s, event.end_s, event.seconds, event.closest_m,
                    event.closest_s, event.p_within, p_same, together,
                )  # fmt: skip
        sums.shown = sorted([*sums.shown, pair], key=lambda p: -p.seconds.sum())[:shown]
    sums.totals = total.totals()


def _pair_rows(pair: PairOverTime, facing: list[float], table: _Table) -> None:
    near = pair.near
    for k, frame in enumerate(pair.frames):
        table.row(
            pair.a, pair.b, int(frame), float(pair.t_s[k]), near.distance_m[k], near.low_m[k], near.high_m[k],
            *near.p_within[k], facing[k] if pair.seen[k] else None, pair.seen[k],
        )  # fmt: skip


def _exposure_row(pair: PairOverTime, facing: list[float], p_same: float, together: bool, table: _Table) -> None:
    low, high = pair.interval_s()
    per_limit = [v for k in range(len(low)) for v in (pair.seconds[k], low[k], high[k])]
    table.row(
        pair.a, pair.b, pair.seconds_together, *per_limit, pair.closest_m, pair.closest_low_m, pair.closest_high_m,
        float(pair.t_s[int(pair.near.distance_m.argmin())]), float(pair.weight_s @ np.array(facing)), p_same, together,
    )  # fmt: skip


def _people(found: Analysis, tables: Mapping[str, _Table], sums: Sums) -> None:
    size: dict[int, int] = defaultdict(int)
    for person in found.people:
        size[person.group] += 1
    nothing = np.zeros(len(found.wanted.within_m))
    main, keys = found.main_camera, attributes_of(found)
    for person in found.people:
        track = person.track
        if sums.maps is not None and found.measured.shots[person.shot].camera == main:
            sums.maps.add_presence(track.positions_m, track.t_s, found.weight_s[track.frames])
        if "people" not in tables:
            continue
        step = np.linalg.norm(np.diff(track.positions_m, axis=0), axis=1)
        speed = np.linalg.norm(track.states[:, 2:], axis=1)
        tables["people"].row(
            track.number, person.shot, track.t_s[0], track.t_s[-1], int(track.seen.sum()), int((~track.seen).sum()),
            person.stature_m, person.stature_sd_m, person.group, size[person.group], step.sum(), np.median(speed),
            *sums.of_person.get(track.number, nothing), *sums.of_person_apart.get(track.number, nothing),
            _doubt(person.doubt), *(cell_of(person.attributes.get(key, "")) for key in keys),
        )  # fmt: skip
        _track_rows(found, person, tables["tracks"])


def _track_rows(found: Analysis, person: Person, table: _Table) -> None:
    track = person.track
    shift = found.sensitivity(found.measured.shots[person.shot].camera)(track.positions_m)
    variance = track.place_covariance_m2 + shift @ shift.transpose(0, 2, 1)
    sd = np.sqrt(np.stack([variance[:, 0, 0], variance[:, 1, 1]], axis=1))
    heading = np.degrees(person.heading_rad)
    for k, frame in enumerate(track.frames):
        x, y, vx, vy = track.states[k]
        table.row(
            track.number, int(frame), track.t_s[k], x, y, sd[k, 0], sd[k, 1], vx, vy, heading[k],
            "seen" if track.seen[k] else "bridged", _doubt(person.doubts[k]),
        )  # fmt: skip


def _doubt(reasons: Sequence[PersonDoubt] | None) -> str | None:
    return None if reasons is None else doubts_in_text(reasons)


def _frames(found: Analysis, table: _Table, sums: Sums) -> None:
    places = places_by_frame(found)
    main = found.main_camera
    for number, (state, where) in enumerate(zip(found.frames, places, strict=True)):
        counted = density = voronoi = None
        if found.region is not None and state.camera == main and state.status == "ok" and found.followed[number]:
            inside = found.region.holds(where)
            counted, density = int(inside.sum()), classic_density(where, found.region)
            voronoi = _voronoi(where, found.region)
        known = found.cameras[state.camera]
        table.row(
            number, state.t_s, state.status, state.reason, state.shot, state.camera, known.mount is not None,
            state.n_people, state.n_detected, counted, density, voronoi, *sums.within[number],
            *sums.within_apart[number],
        )  # fmt: skip


def _voronoi(places: FloatArray, region: Region) -> float:
    areas = personal_space_m2(places, region)
    areas = areas[np.isfinite(areas)]
    return float((1 / areas).mean()) if len(areas) else 0.0


def _write_maps(found: Analysis, folder: Folder, maps: Maps, aggregate_only: bool) -> None:
    arrays = maps.arrays()
    if aggregate_only:
        few = _visitors(found, maps) < FEWEST_PEOPLE
        for name in ("density_persons_m2", "risk_s_m2"):
            arrays[name] = np.where(few, np.nan, arrays[name])
    with folder.writing(MAPS) as temporary, open(temporary, "wb") as file:
        np.savez_compressed(file, **arrays)


def _visitors(found: Analysis, maps: Maps) -> FloatArray:
    """Return how many different tracks were in each cell of the maps."""
    count = np.zeros(maps.presence_s.shape[1:])
    for person in found.people:
        if found.measured.shots[person.shot].camera == found.main_camera:
            index = np.unique(np.floor((person.track.positions_m - maps.origin_m) / maps.cell_m).astype(int), axis=0)
            inside = (index >= 0).all(axis=1) & (index < count.shape[::-1]).all(axis=1)
            count[index[inside, 1], index[inside, 0]] += 1
    return count


#: Files of a clip's folder, besides its tables, in which single people can be followed or seen.
_OF_PEOPLE = ("trajectories.txt", "mot.txt", "coco_keypoints.json", "annotated.mp4", "results.xlsx")


def remove_tracks(folder: Folder) -> None:
    """Remove every file that names tracks, an earlier run's and an export's too, and what they were made of."""
    tables = "|".join(OF_TRACKS)
    for name in folder.names():
        if name in _OF_PEOPLE or re.fullmatch(rf"({tables})(_\d+)?\.(csv|parquet|sav|sps)", name):
            folder.remove(name)
    for name in folder.names(parts.FOLDER, ".parquet"):
        folder.remove(f"{parts.FOLDER}/{name}")


def rows_of(people: Iterable[Person]) -> Iterator[tuple[int, int, float, float]]:
    """Yield frame, track, x and y of all people, frame by frame."""
    rows = [
        (int(f), p.track.number, float(x), float(y))
        for p in people
        for f, (x, y) in zip(p.track.frames, p.track.positions_m, strict=True)
    ]
    yield from sorted(rows)
