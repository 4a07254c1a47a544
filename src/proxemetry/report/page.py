"""The report as one HTML file that needs nothing else."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from ..archive.figures.focal_bases import WORDS
from ..archive.figures.methods import ground_in_words
from ..camera import FocalBasis
from ..distances import UNCERTAIN, ZONES
from ..people.attributes import PairsWhere
from ..plots.pair_selection import metres_text
from .charts import histogram, legend, zone_bar
from .distance_figures import Distances, Share, names_of
from .links import Links, figure_id
from .numbers import Numbers, Pair
from .wording import CITE, LIMITS, METHODS, STYLE

#: A zone less probable is not named with an uncertain one.
_WORTH_SAYING = 0.1
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def page(
    run: Mapping[str, Any],
    numbers: Numbers,
    figures: Sequence[tuple[str, str]],
    links: Mapping[str, Links],
    methods: str,
    *,
    title: str,
    faces: str,
    group_by: str,
    where: PairsWhere | None = None,
) -> str:
    """Return the page.

    figures: (photo, data URL). links: of the listed pairs' photos. methods: a paragraph to paste.
    faces: how heads are shown, for the words next to them. where: whose pairs the numbers are of.
    """
    sections = [
        _head(title, run, numbers, where),
        _distances(numbers),
        _by_group(numbers, group_by),
        _refusals(numbers),
        _cameras(numbers),
        _figures(figures, faces),
        _pairs(
            "The nearest pairs",
            numbers.nearest_pairs,
            links,
            "A distance near zero is more often a person found twice.",
        ),
        _pairs(
            "The least certain pairs", numbers.uncertain_pairs, links, "Where checking the photo is most worthwhile."
        ),
        _method(run, methods),
    ]
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body><main>{''.join(sections)}</main></body></html>"
    )


def _many(count: int, one: str, many: str) -> str:
    return f"{count:,} {one if count == 1 else many}"


def _median(distances: Distances) -> str:
    return metres_text(distances.median_m, distances.low_m, distances.high_m) if distances.n else "–"


def _percent(share: Share) -> str:
    if not math.isfinite(share.value):
        return "–"
    if not math.isfinite(share.low):
        return f"{100 * share.value:.1f} %"
    return f"{100 * share.value:.1f} % [{100 * share.low:.1f}, {100 * share.high:.1f}]"


def _head(title: str, run: Mapping[str, Any], numbers: Numbers, where: PairsWhere | None) -> str:
    settings = run.get("settings") or {}
    facts = (
        ("photos", f"{numbers.photos:,}"),
        ("people", f"{numbers.people:,}"),
        ("pairs with a distance", f"{numbers.pairs:,}"),
        ("median distance to the nearest other person", _median(numbers.nearest)),
    )
    tiles = "".join(f"<div><strong>{escape(v)}</strong><span>{escape(k)}</span></div>" for k, v in facts)
    by_hand = f" {_many(numbers.corrected, 'photo was', 'photos were')} corrected by hand." if numbers.corrected else ""
    only = "" if where is None else (
        f"<p><strong>Only people with {escape(str(where))} count, and pairs of two such people.</strong></p>"
    )  # fmt: skip
    return (
        f"<header><p class='brand'>proxemetry</p><h1>{escape(title)}</h1><p>How far apart the people in these photos "
        f"stand: proxemetry {escape(str(run.get('version')))}, method {escape(str(settings.get('method')))}, people "
        f"found by {escape(str(run.get('pose')))}.{by_hand}</p>{only}<div class='tiles'>{tiles}</div></header>"
    )


def _distances(numbers: Numbers) -> str:
    kind = ground_in_words(numbers.on_ground)
    return (
        f"<section><h2>Distances</h2><p>Between body centres, {kind}; the gap between two bodies is about 0.25 m less. "
        "Brackets and the shaded band are 90 % intervals, computed over photos, because pairs in one photo are not "
        "independent. Each distance counts for a zone by its probability of lying in it. Quote the distance to the "
        "nearest other person and the zones of all pairs; the median of all pairs mostly reflects the size of "
        f"crowds.</p>{_on_assumptions(numbers)}{legend()}"
        f"{_block('From each person to the nearest other', numbers.nearest, 'people')}"
        f"{_block('Between all pairs', numbers.every, 'pairs')}</section>"
    )


def _on_assumptions(numbers: Numbers) -> str:
    assumed = numbers.bases[FocalBasis.ASSUMED]
    if not assumed:
        return ""
    return (
        f"<p><strong>In {assumed:,} of {_many(numbers.measured, 'measured photo', 'measured photos')} the "
        "focal length is ASSUMED.</strong> Where one assumption for many photos is wrong, all their distances are "
        "wrong in the same direction, and these intervals do not include that error.</p>"
    )


def _block(title: str, distances: Distances, of: str) -> str:
    if not distances.n:
        return f"<h3>{title}</h3><p>There is none.</p>"
    zones = "".join(f"<td>{_percent(share)}</td>" for _, share in names_of(distances.zones))
    heads = "".join(f"<th scope='col'>{name}</th>" for name, _ in names_of(distances.zones))
    lower, upper = distances.quartiles_m
    return (
        f"<div class='block'><h3>{title}</h3><p>{_many(distances.n, 'distance', 'distances')} in "
        f"{_many(distances.n_photos, 'photo', 'photos')}; median "
        f"{_median(distances)}, half of them between "
        f"{lower:.1f} and {upper:.1f} m.</p>{histogram(distances, title, of)}"
        f"<table><thead><tr>{heads}</tr></thead><tbody><tr>{zones}</tr></tbody></table></div>"
    )


def _by_group(numbers: Numbers, group_by: str) -> str:
    groups = numbers.groups
    if len(groups) < 2:
        return ""
    more = numbers.n_groups - len(groups)
    largest = f" The {len(groups)} with the most photos; there are {more:,} more." if more else ""
    rows = "".join(
        f"<tr><th scope='row'>{escape(g.name)}</th><td>{g.photos:,}</td><td>{g.people:,}</td>"
        f"<td>{_median(g.nearest)}</td>"
        f"<td>{zone_bar(g.zones, f'zones of {g.name}')}</td></tr>"
        for g in groups
    )
    return (
        f"<section><h2>By {escape(group_by)}</h2><p>Median distance to the nearest other person, and the share of all "
        f"pairs in each zone in percent.{largest}</p><table><thead><tr><th scope='col'>{escape(group_by)}</th>"
        "<th scope='col'>photos</th><th scope='col'>people</th><th scope='col'>nearest other</th>"
        "<th scope='col'>zones</th></tr></thead>"
        f"<tbody>{rows}</tbody></table></section>"
    )


def _counts(title: str, counts: Sequence[tuple[str, int]]) -> str:
    if not counts:
        return ""
    rows = "".join(f"<tr><th scope='row'>{escape(what)}</th><td>{n:,}</td></tr>" for what, n in counts)
    return f"<h3>{title}</h3><table class='counts'><tbody>{rows}</tbody></table>"


_STATUS = {
    "ok": "measured", "no_camera": "people found, but no focal length and so no distances",
    "failed": "could not be read", "excluded": "excluded by a reviewer",
}  # fmt: skip


def _refusals(numbers: Numbers) -> str:
    statuses = [(_STATUS.get(s, s), n) for s, n in numbers.statuses]
    return (
        f"<section><h2>What was and was not measured</h2>{_counts('Photos', statuses)}"
        f"{_counts('Why photos have no distances', numbers.refusals)}"
        f"{_counts('Why people have no place', numbers.unplaced)}"
        f"{_counts('People in doubt: perhaps not people, or counted twice', numbers.doubts)}</section>"
    )


def _cameras(numbers: Numbers) -> str:
    bases = [(words, numbers.bases[basis]) for basis, words in WORDS.items() if numbers.bases[basis]]
    return (
        "<section><h2>Where the focal lengths came from</h2><p>Depth is proportional to the focal "
        "length; the distance of two people side by side hardly depends on it. "
        "Estimated ones were found in the picture itself, from straight lines, people or other photos of the camera, "
        "each with its interval; ASSUMED is a guess, with an interval to match.</p>"
        f"{_counts('Measured photos', bases)}"
        f"{_counts('Sources', numbers.focal_sources)}{_shoots(numbers.shoots)}"
        f"{_counts('Doubts about cameras', numbers.flags)}</section>"
    )


def _shoots(shoots: Sequence[str]) -> str:
    if not shoots:
        return ""
    said = "".join(f"<li>{escape(text)}</li>" for text in shoots)
    return f"<h3>What the people in photos from one camera show (--same-camera)</h3><ul>{said}</ul>"


def _figures(figures: Sequence[tuple[str, str]], faces: str) -> str:
    if not figures:
        return ""
    hidden = (
        " Heads are pixelated where people were found; a person who was not found stays recognisable."
        if faces == "blur" else ""
    )  # fmt: skip
    shown = "".join(
        f"<figure id='{figure_id(k)}'><img src='{url}' alt='{escape(photo, quote=True)} with distances and the view "
        "from above'></figure>"
        for k, (photo, url) in enumerate(figures)
    )
    return (
        f"<section><h2>A sample of photos</h2><p>Picked by chance among those with distances, the same ones on every "
        f"run.{hidden}</p>{shown}</section>"
    )


def _pairs(title: str, pairs: Sequence[Pair], links: Mapping[str, Links], text: str) -> str:
    if not pairs:
        return ""
    rows = "".join(
        f"<tr><th scope='row'>{_linked(p.photo, links[p.photo])}</th><td>{p.person_a} – {p.person_b}</td>"
        f"<td>{metres_text(p.distance_m, p.low_m, p.high_m)}</td><td>{escape(_zone(p))}</td></tr>"
        for p in pairs
    )
    return (
        f"<section><h2>{title}</h2><p>{text}</p><table><thead><tr><th scope='col'>photo</th><th scope='col'>people</th>"
        "<th scope='col'>distance [90 % interval]</th><th scope='col'>zone</th></tr></thead>"
        f"<tbody>{rows}</tbody></table></section>"
    )


def _linked(photo: str, links: Links) -> str:
    """Return a photo's name with links to its figure in the page, its overlay and the photo, as far as they exist."""
    named = (("figure", links.figure), ("overlay", links.overlay), ("photo", links.photo))
    shown = " · ".join(f"<a href='{escape(url, quote=True)}'>{what}</a>" for what, url in named if url)
    return f"{escape(photo)} <span class='links'>{shown}</span>" if shown else escape(photo)


def _zone(pair: Pair) -> str:
    """Return a pair's zone, with the likelier ones of an uncertain one."""
    if pair.zone != UNCERTAIN:
        return pair.zone
    likely = sorted(zip(pair.p_zones, ZONES, strict=True), reverse=True)
    named = ", ".join(f"{zone} {100 * p:.0f} %" for p, zone in likely if p >= _WORTH_SAYING)
    return f"{pair.zone}: {named}"


def _method(run: Mapping[str, Any], methods: str) -> str:
    settings = run.get("settings") or {}
    method = str(settings.get("method"))
    models = [(name, f"sha256 {digest}") for name, digest in (run.get("models") or {}).items()]
    packages = [("proxemetry", str(run.get("version"))), ("Python", str(run.get("python")))]
    packages += [(k, str(v)) for k, v in (run.get("packages") or {}).items()]
    listed = "".join(f"<dt>{escape(k)}</dt><dd>{escape(v)}</dd>" for k, v in [*models, *packages])
    limits = "".join(f"<li>{escape(text)}</li>" for text in LIMITS)
    return (
        f"<section><h2>Method</h2><p>{escape(METHODS.get(method, METHODS['']))}</p><h2>Limits</h2><ul>{limits}</ul>"
        f"<h2>A methods paragraph to paste</h2><p>{escape(methods)}</p><h2>How to cite</h2><p>{escape(CITE)}</p>"
        f"<h2>What was run</h2><dl>{listed}</dl>"
        f"<details open><summary>Settings</summary><pre>{escape(json.dumps(settings, indent=1))}</pre></details>"
        "</section>"
    )
