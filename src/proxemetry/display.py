"""A scene in a notebook: its tables as data frames, and as HTML."""

from __future__ import annotations

import importlib.util
from html import escape
from typing import TYPE_CHECKING

from .distances import is_vague
from .errors import SettingsError
from .people.attributes import keys_of
from .scene import Scene
from .tables import TABLES, all_columns, rows

if TYPE_CHECKING:
    import pandas

#: Pairs that a notebook shows; the rest is counted.
_MOST_PAIRS = 12
_DTYPES = {"INTEGER": "Int64", "BOOLEAN": "boolean", "DOUBLE": "float64", "VARCHAR": "string"}


def frame(table: str, scene: Scene) -> pandas.DataFrame:
    """Return the rows of one scene in the table "photos", "people" or "pairs", missing values as pandas has them.

    Raises SettingsError where pandas is missing.
    """
    if importlib.util.find_spec("pandas") is None:
        raise SettingsError("data frames need an extra: pip install 'proxemetry[notebook]'")
    import pandas

    attributes = keys_of(scene.people.attributes)
    listed = rows(table, scene, attributes)
    columns = all_columns(attributes)[table] if table != "photos" else TABLES[table]
    return pandas.DataFrame(
        {c.name: pandas.array([row[c.name] for row in listed], dtype=_DTYPES[c.kind]) for c in columns}
    )


def html(scene: Scene) -> str:
    """Return a scene as a table of its pairs, nearest first, with intervals and zones; what is doubtful above it."""
    distances = scene.distances
    camera = scene.camera.camera
    focal = "focal length unknown" if camera is None else f"focal length {camera.f_px:.0f} px ({scene.camera.source})"
    head = f"<strong>{escape(scene.photo)}</strong>: {len(scene)} people; {escape(focal)}"
    doubtful = sum(map(bool, scene.doubts))
    if doubtful:
        head += f", {doubtful} of them doubtful"
    if scene.reason:
        head += f"; {escape(scene.reason)}"
    known = [(float(distances.distance_m[a, b]), a, b) for a, b in distances.pairs()]
    known = sorted(pair for pair in known if pair[0] == pair[0])  # without NaN
    body = "".join(
        f"<tr><td>{a} – {b}</td><td>{metres:.1f} m [{distances.low_m[a, b]:.1f}, {distances.high_m[a, b]:.1f}]"
        f"{' ?' if is_vague(distances.low_m[a, b], distances.high_m[a, b]) else ''}</td>"
        f"<td>{distances.zone(a, b)}</td></tr>"
        for metres, a, b in known[:_MOST_PAIRS]
    )
    more = f"<p>and {len(known) - _MOST_PAIRS} more pairs</p>" if len(known) > _MOST_PAIRS else ""
    if not known:
        return f"<div><p>{head}</p></div>"
    return (
        f"<div><p>{head}</p><table><thead><tr><th>people</th><th>distance [90 %]</th><th>zone</th></tr></thead>"
        f"<tbody>{body}</tbody></table>{more}</div>"
    )
