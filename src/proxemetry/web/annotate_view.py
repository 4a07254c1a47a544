"""Annotations as their page reads them: JSON values, pixels of the full-size photo, metres on the floor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..annotate.completing import SCOPES
from ..annotate.history import History
from ..annotate.photos import OwnPhoto
from ..annotate.places import Places, remarks_on
from ..annotate.project import Project
from ..annotate.rules import CAMERA_RULES, PART_RULES, PEOPLE_RULES, PLACE_RULES
from ..annotate.scoring import Scores
from ..annotate.state import Lens, PhotoNotes, in_order, number_of
from ..archive.review.actions import Action
from ..benchmark import PROTOCOLS
from ..benchmark.report import to_text
from ..people.skeleton import PARTS
from ..plots.pair_selection import colour_of, text_on
from .view import number, numbers

#: Colours before they repeat.
_COLOURS = 12
#: Of fewer scored photos a bootstrap over photos says nothing.
_LEAST_PHOTOS = 5


def about_view(project: Project) -> dict[str, Any]:
    """Return what every view needs: whose, where, how far, the names in use and the rules."""
    now, photos = project.now, project.photos
    notes = [now.photo(p.sha256) for p in photos]
    shoots = now.shoot_numbers(project.files)
    return {
        "out": str(project.out),
        "who": project.who,
        "pose": project.pose,
        "photos": len(photos),
        "left_out": project.left_out,
        "lost": project.lost,
        "done": sum(n.done for n in notes),
        "skipped": sum(n.skipped for n in notes),
        "names": dict(now.names),
        "shoots": [
            {
                "number": n,
                "name": now.shoot(n).name,
                "photos": sum(x.shoot == n for x in notes),
                "cameras": in_order({x.camera for x in notes if x.shoot == n} | set(now.shoot(n).camera_names)),
                "camera_names": dict(now.shoot(n).camera_names),
            }
            for n in shoots
        ],
        "parts": list(PARTS),
        "colours": [{"fill": colour_of(k), "ink": text_on(colour_of(k))} for k in range(_COLOURS)],
        "rules": {"parts": PART_RULES, "people": PEOPLE_RULES, "places": PLACE_RULES, "camera": CAMERA_RULES},
        **history_view(project.history),
    }


def history_view(history: History) -> dict[str, Any]:
    """Return in words what would be undone and redone."""
    return {name: None if action is None else words_of(action)
            for name, action in (("undo", history.undoable), ("redo", history.redoable))}  # fmt: skip


def words_of(action: Action) -> str:
    """Return an action in words, as "Undo: ..." says it."""
    value, where = action.value, f" in {action.photo}" if action.photo else ""
    words: Mapping[str, str] = {
        "add_person": "a person added", "remove_person": "a person removed", "name_person": f"named {value.get('tag')}",
        "set_point": f"{value.get('part')} {'set' if value.get('to') else 'not visible'}",
        "name_people": "several people named", "finish": "done or not", "skip": "left out or not",
        "set_lens": "a lens stated", "place_photos": "shoot and camera", "name_shoot": "a shoot's name",
        "name_camera": "a camera's name", "name_tag": f"the name of {value.get('tag')}",
        "set_spot": f"coordinates of {value.get('tag')}", "set_tape": f"the tape {value.get('a')}–{value.get('b')}",
    }  # fmt: skip
    return f"{words.get(action.action, action.action)}{where}"


def card_view(identity: int, photo: OwnPhoto, notes: PhotoNotes) -> dict[str, Any]:
    """Return a card of the gallery."""
    return {
        "id": identity, "name": photo.name, "shoot": notes.shoot, "camera": notes.camera, "named": len(notes.named),
        "unnamed": sum(p.tag is None for p in notes.people), "done": notes.done, "skipped": notes.skipped,
        "proposed": notes.proposed is not None,
    }  # fmt: skip


def photo_view(project: Project, identity: int) -> dict[str, Any]:
    """Return everything about one photo."""
    photo, notes = project.photo(identity), project.notes(identity)
    before = next((project.notes(k) for k in range(identity - 1, -1, -1)
                   if _from_one_place(project.notes(k), notes)), None)  # fmt: skip
    return {
        "id": identity,
        "name": photo.name,
        "width": photo.width,
        "height": photo.height,
        "people": [
            {"key": p.key, "tag": p.tag, "by": p.by, "points": {part: list(at) for part, at in p.points.items()}}
            for p in sorted(notes.people, key=lambda p: (p.tag is None, number_of(p.tag) if p.tag else p.key))
        ],
        "before": [] if before is None else _left_to_right(before),
        "shoot": notes.shoot,
        "camera": notes.camera,
        "done": notes.done,
        "skipped": notes.skipped,
        "proposed": notes.proposed,
        "device": photo.camera,
        "lens": _lens(notes.lens),
        "file_lens": _lens(photo.lens),
        "scopes": {name: sum(belongs(photo, other) for other in project.photos) for name, belongs in SCOPES.items()},
        "previous": identity - 1 if identity else None,
        "next": identity + 1 if identity + 1 < len(project.photos) else None,
        "total": len(project.photos),
        **history_view(project.history),
    }


def _from_one_place(before: PhotoNotes, notes: PhotoNotes) -> bool:
    """Whether people stand on a photo from left to right as on an earlier one, on which people are named."""
    return bool(before.named) and (before.shoot, before.camera) == (notes.shoot, notes.camera)


def _left_to_right(notes: PhotoNotes) -> list[str]:
    """Return the tags of a photo's people as they stand in the picture."""
    return [
        p.tag or "" for p in sorted(notes.named, key=lambda p: sum(x for x, _ in p.points.values()) / len(p.points))
    ]


def _lens(lens: Lens | None) -> dict[str, Any] | None:
    if lens is None:
        return None
    return {"focal_mm": number(lens.focal_mm), "sensor_mm": numbers(lens.sensor_mm, 1), "equivalent": lens.equivalent}


def places_view(project: Project, shoot: int) -> dict[str, Any]:
    """Return a shoot's measurements, what follows from them, and what remains open."""
    known, places = project.now.shoot(shoot), project.places(shoot)
    seen = project.now.tags_seen(shoot, project.files)
    tags = in_order({*seen, *places.tags})
    reasons = dict(zip(places.tags, places.reasons, strict=True))
    suspects = {} if places.contradiction is None else {s.measurement: s for s in places.contradiction.suspects}
    fits = {fit.measurement: fit for fit in places.fits}
    spots = {tag: known.spots[tag] for tag in known.spots}
    return {
        "shoot": shoot,
        "name": known.name,
        "tags": [
            {
                "tag": tag,
                "name": (known.camera_names if tag.startswith("C") else project.now.names).get(tag, ""),
                "seen": tag in seen,
                "spot": None if tag not in spots else [spots[tag].x_m, spots[tag].y_m],
                "suspect": tag in spots and spots[tag] in suspects,
                "place": numbers(places.by_tag[tag], 3) if tag in places.by_tag else None,
                "reason": reasons.get(tag) or None,
            }
            for tag in tags
        ],
        "tapes": [
            {
                "a": tape.a, "b": tape.b, "metres": tape.metres, "sd_m": tape.sd_m,
                "residual_m": number(fits[tape].residual_m), "z": number(fits[tape].z, 2),
                "checked": fits[tape].checked, "suspect": tape in suspects,
                "expected_m": number(suspects[tape].expected_m, 3) if tape in suspects else None,
                "expected_sd_m": number(suspects[tape].expected_sd_m, 3) if tape in suspects else None,
            }
            for tape in sorted(known.tapes.values(), key=lambda t: sorted((number_of(t.a), number_of(t.b))))
        ],
        "distances": _distances(places),
        "remarks": [{"text": r.text, "problem": r.problem} for r in remarks_on(places)],
    }  # fmt: skip


def _distances(places: Places) -> list[dict[str, Any]]:
    people = [(k, tag) for k, tag in enumerate(places.tags) if tag.startswith("P") and tag in places.by_tag]
    people.sort(key=lambda item: number_of(item[1]))
    return [
        {"a": a, "b": b, "metres": number(places.distance_m[i, j], 3), "sd_m": number(places.distance_sd_m[i, j], 3)}
        for n, (i, a) in enumerate(people)
        for j, b in people[n + 1 :]
    ]


def scores_view(scores: Scores, project: Project) -> dict[str, Any]:
    """Return both protocols' figures per method, those of every photo, and the whole as text."""
    ids = {photo.name: k for k, photo in enumerate(project.photos)}
    return {
        "protocols": [
            {
                "name": name,
                "about": PROTOCOLS[name].about,
                "caption": next(iter(of.values())).caption,
                "baseline": number(next(iter(of.values())).overall.baseline_constant_pct, 1),
                "rows": [
                    {
                        "method": method, "pairs": o.n_pairs, "annotated_pairs": o.n_annotated_pairs,
                        "unscored": o.n_unscored, "error": number(o.pair_error_pct_mean_over_images, 1),
                        "ci": numbers(o.ci95.get("pair_error_pct_mean_over_images", ()), 1)
                        if o.n_images - o.n_unscored >= _LEAST_PHOTOS
                        else None,
                        "median": number(o.pair_error_pct_median_over_pairs, 1), "bias": number(o.signed_bias_pct, 1),
                        "found": number(100 * o.detection_rate, 0), "false": number(100 * o.false_discovery_rate, 0),
                        "coverage": number(100 * o.coverage_90, 0), "intervals": o.n_intervals,
                    }
                    for method, one in of.items() for o in (one.overall,)
                ],
                "text": "\n".join(f"{method}: {to_text(one)}" for method, one in of.items()),
                "photos": [
                    {"id": ids.get(image.label.filename), **image.to_dict()}
                    for image in next(iter(of.values())).images
                ],
            }
            for name, of in scores.items()
        ]
    }  # fmt: skip
