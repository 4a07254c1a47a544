"""What photos are grouped by, in summaries and reports alike: one spelling in SQL, one place."""

from __future__ import annotations

from ...errors import SettingsError
from ...tables import TABLES

#: Name -> SQL over the photos table, NULL where unknown. Photos right in the folder named are in the folder ".".
GROUPINGS = {
    "year": "nullif(regexp_extract(date, '^[0-9]{4}'), '')",
    "month": "nullif(regexp_extract(date, '^[0-9]{4}-[0-9]{2}'), '')",
    "folder": "coalesce(nullif(parse_dirpath(photo, 'forward_slash'), ''), '.')",
}

#: What is not known of a photo, as people read it.
UNKNOWN = "unknown"


def sql_of(name: str) -> str:
    """Return the SQL of a grouping or a column of the photos table; raises SettingsError for anything else."""
    if name in GROUPINGS:
        return GROUPINGS[name]
    columns = [column.name for column in TABLES["photos"]]
    if name in columns:
        return f'"{name}"'
    known = ", ".join([*GROUPINGS, "country", "city", "source"])
    raise SettingsError(f"photos cannot be grouped by {name!r}: use {known} or another column of photos.csv")
