"""A clip's page: one HTML file that opens from disk, with nothing to fetch and no picture of a person in it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from html import escape
from importlib.resources import files
from typing import Any

from ..archive.store.folder import Folder
from .analysis import Analysis
from .columns import limit_name
from .page_data import page_data
from .summary import Sums

PAGE = "report.html"
_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'"

_METHOD = (
    "People are found and placed in every frame as in a photo, by one fit of people, floor and camera; then "
    "they are followed on the floor, in metres, and their paths are smoothed with all frames before and after. Seconds "
    "within a distance are the sum over time of the probability of being that near: counting noisy frames would find "
    "too few. Every interval holds 90 % and comes from draws of the whole clip, one camera, one floor and one path "
    "a person in each."
)
_LIMITS = (
    "A track is not a person: a person who leaves and comes back is counted again, and two people who pass each "
    "other may be swapped.",
    "Distances are between body centres; the gap between two bodies is about 0.25 m less.",
    "The floor is taken to be level. On stairs and slopes distances are wrong.",
    "Whether people belong together is a probability, estimated from how they move; nobody was asked.",
    "Where the camera's place was found from the people, all distances may be wrong the same way, by up to a tenth.",
    "It is for the study of behaviour, not for judging or enforcing anything on single people.",
)


def write_page(
    found: Analysis, sums: Sums, numbers: Mapping[str, Any], run: Mapping[str, Any], folder: Folder, *,
    aggregate_only: bool = False, groups: str = "apart",
) -> None:  # fmt: skip
    """Write the page. groups: "apart" begins with pairs that do not belong together, "ignore" with all."""
    text = page(found, sums, numbers, run, aggregate_only=aggregate_only, groups=groups)
    folder.write(PAGE, text.encode())


def page(
    found: Analysis, sums: Sums, numbers: Mapping[str, Any], run: Mapping[str, Any], *, aggregate_only: bool,
    groups: str,
) -> str:  # fmt: skip
    """Return the page as HTML."""
    data = page_data(found, sums, aggregate_only)
    sections = [
        _head(numbers, run), _floor(found, data), _timeline(found, groups), _contacts(numbers), _pairs(data),
        _heat(data), _critical(numbers), _notes(numbers), _method(run),
    ]  # fmt: skip
    own = files(__package__ or "")
    style, script = (own.joinpath(n).read_text(encoding="utf-8") for n in ("page.css", "page.js"))
    inside = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    title = escape(str(numbers["clip"]))
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{title}</title>'
        f"<style>{style}</style></head><body><main>{''.join(sections)}</main>"
        f'<script type="application/json" id="data">{inside}</script><script>{script}</script></body></html>'
    )


def _range(value: float | None, low: float | None, high: float | None, unit: str = "", digits: int = 1) -> str:
    if value is None:
        return "–"
    if low is None or high is None:
        return f"{value:.{digits}f}{unit}"
    return f"{value:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]{unit}"


def _count(number: int | None) -> str:
    return "–" if number is None else f"{number:,}"


def _head(numbers: Mapping[str, Any], run: Mapping[str, Any]) -> str:
    density = numbers["density_persons_m2"]
    facts = [
        ("length", f"{numbers['seconds']:.0f} s"),
        ("frames measured", f"{numbers['n_frames']:,}"),
        ("people, at least and at most", f"{numbers['people_at_least']} – {numbers['people_at_most']}"),
        ("groups of two and more", _count(numbers["n_groups"])),
    ]
    if density is not None and density["value"] is not None:
        facts.append(("persons per m²", _range(density["value"], density["low"], density["high"], digits=3)))
    tiles = "".join(f"<div><strong>{escape(v)}</strong><span>{escape(k)}</span></div>" for k, v in facts)
    return (
        f"<header><p class='brand'>proxemetry</p><h1>{escape(str(numbers['clip']))}</h1><p>Who was near whom, how "
        f"near, and for how long: proxemetry {escape(str(run.get('version', '')))}, people found by "
        f"{escape(str(run.get('pose', '')))}.</p>{_not_followed(numbers)}<div class='tiles'>{tiles}</div></header>"
    )


def _not_followed(numbers: Mapping[str, Any]) -> str:
    lost = numbers["seconds_not_followed"]
    return "" if not lost else (
        f"<p><strong>For {lost:.1f} of {numbers['seconds']:.1f} s the camera moves, its pictures cannot be compared, "
        "or people cannot be placed: nobody is followed then, and who was near whom is unknown, not zero."
        f"{'' if numbers['n_groups'] is None else ' The numbers are of the rest.'}</strong></p>"
    )  # fmt: skip


def _floor(found: Analysis, data: Mapping[str, Any]) -> str:
    if not data["tracks"]:
        return ""
    first, last = data["t"][0], data["t"][-1]
    limit = limit_name(found.wanted.within_m[-1])
    return (
        "<section><h2>From above</h2><div class='controls'><button id='play' type='button'>Play</button>"
        f"<input id='when' type='range' min='{first}' max='{last}' step='0.05' value='{first}' aria-label='time'>"
        "<output id='clock'></output><label>speed <select id='speed'><option>1</option><option>4</option>"
        "<option>16</option></select></label></div><figure><canvas id='floor' role='img' aria-label='people on the "
        f"floor'></canvas><figcaption>Metres. Full dots are seen, rings are bridged, short lines say where people "
        f"face; red lines join people nearer than {limit} m, grey ones companions; circles that touch are {limit} m "
        "apart."
        "</figcaption></figure></section>"
    )


def _timeline(found: Analysis, groups: str) -> str:
    options = "".join(
        f"<option value='{k}'{' selected' if k == len(found.wanted.within_m) - 1 else ''}>{limit_name(v)} m</option>"
        for k, v in enumerate(found.wanted.within_m)
    )
    checked = " checked" if groups == "apart" else ""
    density = "<p class='quiet'>persons per m²</p><canvas id='density'></canvas>" if found.region is not None else ""
    return (
        "<section><h2>Over time</h2><p class='quiet'>people there</p><canvas id='people'></canvas>"
        f"<div class='controls'><span class='quiet'>pairs within <select id='limit'>{options}</select></span>"
        f"<label><input id='apart' type='checkbox'{checked}> without pairs of one group</label></div>"
        f"<canvas id='near'></canvas>{density}</section>"
    )


def _contacts(numbers: Mapping[str, Any]) -> str:
    rows = ""
    for limit, found in numbers["within_m"].items():
        every, apart = found["pair_seconds"], found["pair_seconds_apart"]
        per = found["seconds_per_person_minute_apart"]
        rows += (
            f"<tr><td>{limit} m</td><td>{_range(every['seconds'], every['low_s'], every['high_s'])}</td>"
            f"<td>{_range(apart['seconds'], apart['low_s'], apart['high_s'])}</td><td>{_count(found['events'])}</td>"
            f"<td>{_count(found['events_apart'])}</td><td>{_range(per['value'], per['low'], per['high'])}</td></tr>"
        )
    return (
        "<section><h2>Nearness</h2><div class='wide'><table><thead><tr><th>within</th><th>pair-seconds, all</th>"
        "<th>not of one group</th><th>encounters, all</th><th>not of one group</th><th>seconds a person-minute, not of "
        "one group"
        f"</th></tr></thead><tbody>{rows}</tbody></table></div><p class='note'>In brackets 90 %. An encounter lasts a "
        "second or more. The last column's interval is over stretches of 10 s, since frames are not independent; a "
        "clip "
        "shorter than a minute has none.</p></section>"
    )


def _pairs(data: Mapping[str, Any]) -> str:
    if not data["pairs"]:
        return ""
    options = "".join(f"<option value='{k}'>{p['a']} and {p['b']}</option>" for k, p in enumerate(data["pairs"]))
    return (
        "<section><h2>Distance of two people</h2><div class='controls'><label>tracks <select id='pair'>"
        f"{options}</select></label></div><figure><canvas id='curve'></canvas><figcaption>Metres over time; the band "
        "holds 90 %. These are the pairs who were near each other longest.</figcaption></figure></section>"
    )


def _heat(data: Mapping[str, Any]) -> str:
    if not data["maps"]:
        return ""
    limit = limit_name(data["limits"][-1])
    return (
        "<section><h2>Where</h2><div class='controls'><label>map of <select id='map'><option value='density'>people"
        f"</option><option value='risk'>time within {limit} m of others</option></select></label><span class='quiet'>"
        "darkest: <output id='most'></output></span></div><figure><canvas id='heat'></canvas><figcaption>The floor "
        "from above, in metres, summed over the clip.</figcaption></figure></section>"
    )


def _critical(numbers: Mapping[str, Any]) -> str:
    told = {k: v for k, v in numbers["critical_density"].items() if isinstance(v, Mapping)}
    if not told:
        return ""
    about = (
        "<section><h2>Critical density</h2><p>The density at which, by linear regression, no one would be too near "
        "(Yang et al. 2020), in persons per m², with an interval over stretches of time.</p>"
    )
    reasons = {v["reason"] for v in told.values()}
    if len(reasons) == 1 and None not in reasons:
        return f"{about}<p>None: {escape(str(reasons.pop()))}.</p></section>"
    rows = ""
    for limit, found in told.items():
        name = f"{limit.removesuffix('_apart')} m" + (", not of one group" if limit.endswith("_apart") else "")
        value = (
            _range(found["intercept"], found["low"], found["high"], digits=3)
            if found["reason"] is None else f"none: {found['reason']}"
        )  # fmt: skip
        rows += f"<tr><td>{escape(name)}</td><td>{escape(value)}</td></tr>"
    return f"{about}<div class='wide'><table class='text'><tbody>{rows}</tbody></table></div></section>"


def _notes(numbers: Mapping[str, Any]) -> str:
    notes = [f"Camera {k}: {v}." for k, v in numbers["cameras"].items() if v]
    notes += [str(n) for n in numbers["notes"]]
    for shot in numbers["shots"][1:]:
        share = f" by {100 * shot['shift_share']:.1f} % of the picture's width" if shot["shift_share"] else ""
        notes.append(f"Frame {shot['first']}: {shot['began']}{share}; camera {shot['camera']} from here on.")
    if numbers["n_frames_failed"]:
        notes.append(f"{numbers['n_frames_failed']} frames could not be measured; see the table frames.")
    listed = "".join(f"<li>{escape(n)}</li>" for n in notes)
    return f"<section><h2>The camera and the clip</h2><ul>{listed}</ul></section>"


def _method(run: Mapping[str, Any]) -> str:
    limits = "".join(f"<li>{escape(text)}</li>" for text in _LIMITS)
    shown = {k: run[k] for k in ("version", "pose", "models", "fps", "clip_sha256", "settings") if k in run}
    return (
        f"<section><h2>Method</h2><p>{escape(_METHOD)}</p><h2>Limits</h2><ul>{limits}</ul><details><summary>"
        f"What was run</summary><pre>{escape(json.dumps(shown, indent=1))}</pre></details></section>"
    )
