"""The columns of a clip's tables, with units and meanings: what the files and the codebook are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ..people.doubts import OF_PHOTOS, PersonDoubt
from ..tables import DOUBT, Column, attribute_columns, codebook_markdown, markdown_table

#: The tables of a clip's folder; the last four name tracks, and stay away with --aggregate-only.
TABLES = ("frames", "tracks", "people", "pairs_over_time", "exposure", "events")
OF_TRACKS = TABLES[1:]

_N, _I, _T, _B = "DOUBLE", "INTEGER", "VARCHAR", "BOOLEAN"
_WHY = f"why this may not be a person, or may be one found twice ({', '.join(OF_PHOTOS)}, with + between them),"


def limit_name(limit_m: float | str) -> str:
    """Return how columns call a limit: 2, 1.5."""
    return limit_m if isinstance(limit_m, str) else f"{limit_m:g}"


def columns(table: str, limits: Sequence[float | str], attributes: Sequence[str] = ()) -> tuple[Column, ...]:
    """Return a table's columns for these limits in metres, or for "X" in the codebook, and of people's attributes."""
    names = [limit_name(v) for v in limits]
    found = {
        "frames": _frames, "tracks": _tracks, "people": _people, "pairs_over_time": _pairs_over_time,
        "exposure": _exposure, "events": _events,
    }[table](names)  # fmt: skip
    of_track = attribute_columns("people", attributes) if table == "people" else ()
    return (*found, *(replace(c, meaning=f"{c.meaning}, in most sightings") for c in of_track))


def _frames(limits: Sequence[str]) -> tuple[Column, ...]:
    return (
        Column("frame", _I, "", "number of the frame among those measured, from 0", identifies=True),
        Column("t_s", _N, "s", "when, from the clip's beginning"),
        Column("status", _T, "", "ok, no_camera or failed", levels=("ok", "no_camera", "failed")),
        Column("reason", _T, "", "why nothing was measured"),
        Column("shot", _I, "", "stretch without a cut, from 0", identifies=True),
        Column("camera", _I, "", "camera position; the same number is the same place", identifies=True),
        Column("camera_ok", _B, "", "false: the camera moved, or its place is unknown; every frame is on its own"),
        Column("n_people", _I, "", "tracks that were there, seen or bridged (where nobody is followed: people found)"),
        Column("n_detected", _I, "", "people found in the picture, false ones included"),
        Column("n_region", _I, "", "of n_people, those in the region of densities"),
        Column("density", _N, "1/m2", "classic density: people in the region by its area"),
        Column("density_voronoi", _N, "1/m2", "mean over the people in the region of one by the floor nearest to each"),
        *(
            Column(f"n_within_{x}", _N, "", f"expected number of pairs within {x} m; empty where nobody is followed")
            for x in limits
        ),
        *(Column(f"n_within_{x}_apart", _N, "", f"the same without pairs of one group, {x} m") for x in limits),
    )


def _tracks(limits: Sequence[str]) -> tuple[Column, ...]:
    return (
        Column("track", _I, "", "number of the track, from 1, new in every clip", identifies=True),
        Column("frame", _I, "", "number of the frame", identifies=True),
        Column("t_s", _N, "s", "when"),
        Column(
            "x_m", _N, "m", "place on the floor; of the user's coordinates where the mount has them, else to the right"
        ),
        Column("y_m", _N, "m", "place on the floor; else ahead of the camera"),
        Column("x_sd_m", _N, "m", "standard deviation of x_m, the errors of camera and floor included"),
        Column("y_sd_m", _N, "m", "standard deviation of y_m, the errors of camera and floor included"),
        Column("vx_m_s", _N, "m/s", "velocity along x"),
        Column("vy_m_s", _N, "m/s", "velocity along y"),
        Column("heading_deg", _N, "deg", "where the body faces, from x towards y; empty where unknown"),
        Column("seen", _T, "", "seen, or bridged: a gap filled from both sides", levels=("seen", "bridged")),
        Column(DOUBT, _T, "", f"{_WHY} by this frame; none: no doubt; empty: bridged, or only boxes are known"),
    )


def _people(limits: Sequence[str]) -> tuple[Column, ...]:
    return (
        Column("track", _I, "", "number of the track; a person who comes back later is another track", identifies=True),
        Column("shot", _I, "", "stretch without a cut", identifies=True),
        Column("from_s", _N, "s", "first sighting"),
        Column("to_s", _N, "s", "last sighting"),
        Column("n_seen", _I, "", "frames in which the person was seen"),
        Column("n_bridged", _I, "", "frames that were bridged"),
        Column("stature_m", _N, "m", "one stature for the whole track; a by-product of the fit, wide"),
        Column("stature_sd_m", _N, "m", "its standard deviation"),
        Column("group", _I, "", "number of the group; alone: a group of one", identifies=True),
        Column("group_size", _I, "", "how many tracks are in it"),
        Column("length_m", _N, "m", "how far the person went"),
        Column("speed_m_s", _N, "m/s", "median speed"),
        *(
            Column(f"person_seconds_within_{x}", _N, "s", f"summed over all others, seconds within {x} m")
            for x in limits
        ),
        *(Column(f"person_seconds_within_{x}_apart", _N, "s", f"the same without companions, {x} m") for x in limits),
        Column(
            DOUBT,
            _T,
            "",
            f"{_WHY} by most sightings; {PersonDoubt.MOTIONLESS}: did not move for three minutes or "
            "more; none: no doubt; empty: only boxes are known",
        ),
    )


def _pairs_over_time(limits: Sequence[str]) -> tuple[Column, ...]:
    return (
        Column("track_a", _I, "", "one of the two", identifies=True),
        Column("track_b", _I, "", "the other", identifies=True),
        Column("frame", _I, "", "number of the frame", identifies=True),
        Column("t_s", _N, "s", "when"),
        Column("distance_m", _N, "m", "distance between body centres on the floor, from the smoothed paths"),
        Column("low_m", _N, "m", "lower end of the 90 % interval"),
        Column("high_m", _N, "m", "upper end of the 90 % interval"),
        *(Column(f"p_within_{x}", _N, "", f"probability of being within {x} m") for x in limits),
        Column("p_facing", _N, "", "probability that the two face each other (F-formation) in this frame"),
        Column("seen", _B, "", "false: at least one of the two is bridged here"),
    )


def _exposure(limits: Sequence[str]) -> tuple[Column, ...]:
    per_limit: list[Column] = []
    for x in limits:
        per_limit += [
            Column(f"seconds_within_{x}", _N, "s", f"expected seconds within {x} m of each other"),
            Column(f"low_s_{x}", _N, "s", f"lower end of its 90 % interval, {x} m"),
            Column(f"high_s_{x}", _N, "s", f"upper end of its 90 % interval, {x} m"),
        ]
    return (
        Column("track_a", _I, "", "one of the two", identifies=True),
        Column("track_b", _I, "", "the other", identifies=True),
        Column("seconds_together", _N, "s", "how long both were there"),
        *per_limit,
        Column("closest_m", _N, "m", "smallest distance"),
        Column("closest_low_m", _N, "m", "lower end of its 90 % interval"),
        Column("closest_high_m", _N, "m", "upper end of its 90 % interval"),
        Column("closest_s", _N, "s", "when"),
        Column("facing_s", _N, "s", "expected seconds of facing each other (F-formation), where both were seen"),
        Column("p_same_group", _N, "", "probability that the two belong together"),
        Column("same_group", _B, "", "whether they are in one group of the table people"),
    )


def _events(limits: Sequence[str]) -> tuple[Column, ...]:
    return (
        Column("track_a", _I, "", "one of the two", identifies=True),
        Column("track_b", _I, "", "the other", identifies=True),
        Column("within_m", _N, "m", "the limit"),
        Column("begin_s", _N, "s", "from when the two were nearer"),
        Column("end_s", _N, "s", "until they were further apart than 1.15 times the limit"),
        Column("seconds", _N, "s", "how long it lasted"),
        Column("closest_m", _N, "m", "smallest distance in it"),
        Column("closest_s", _N, "s", "when that was"),
        Column("p_within", _N, "", "mean probability of being within the limit"),
        Column("p_same_group", _N, "", "probability that the two belong together"),
        Column("same_group", _B, "", "whether they are in one group"),
    )


#: What a row of each table is, and what its numbers come from.
SOURCES = {
    "frames": "One row per frame that was measured. People are counted on their smoothed paths; pairs are sums of "
    "probabilities; `status` and `n_detected` are of the frame by itself.",
    "tracks": "One row per person and frame. Places and velocities are the smoothed path (Rauch-Tung-Striebel) "
    "through the scene fit's places, all frames before and after known; headings are the fit's own, frame by frame.",
    "people": "One row per track. Statures are pooled over its frames; groups are a logistic regression on how two "
    "paths lie to each other.",
    "pairs_over_time": "One row per pair and frame in which both were there, from the two smoothed paths with their "
    "joint covariance, the errors of camera and floor shared.",
    "exposure": "One row per pair of tracks that were there at one time. Seconds are the integral of the probability "
    "over time; their intervals come from 200 draws of the whole clip.",
    "events": "One row per encounter: it begins below a limit, ends above 1.15 times it, and lasts `--min-event` or "
    "more.",
}


def codebook_page() -> str:
    """Return the whole codebook as a page: tables of photos, then those of clips."""
    about = (
        "The tables in a folder of `proxemetry video`. X is each limit of `--within`, in metres; intervals hold 90 %."
    )
    lines = [codebook_markdown(), "# Clips", "", about, ""]
    for table, of_table in codebook().items():
        lines += [f"## Clips: {table}", "", SOURCES[table], "", *markdown_table(of_table), ""]
    return "\n".join(lines)


def codebook(limits: Sequence[float | str] = ("X",), attributes: Sequence[str] = ()) -> dict[str, tuple[Column, ...]]:
    """Return every table of a clip with its columns."""
    return {table: columns(table, limits, attributes) for table in TABLES}
