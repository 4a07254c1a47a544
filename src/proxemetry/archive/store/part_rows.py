"""One photo's row of a part: its row of the table of photos, its people, its pairs and the whole scene."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Any

from ...camera.sources import FocalBasis
from ...people.attributes import keys_of
from ...scene import Scene
from ...tables import TABLES, rows
from .file_state import FileState


@dataclass(frozen=True)
class Counts:
    """How many photos went which way; sums over shards are sums of these.

    again: photos that had been measured before, of another file under the same name.
    """

    photos: int = 0
    failed: int = 0
    no_camera: int = 0
    people: int = 0
    pairs: int = 0
    again: int = 0

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(getattr(self, n) + getattr(other, n) for n in self.__dataclass_fields__))


@dataclass(frozen=True)
class Record:
    """One photo's row of a part, as JSON, and what it counts for."""

    json: str
    counts: Counts


@dataclass(frozen=True)
class PreviousRow:
    """A photo's row in the part that is there already."""

    fields: Mapping[str, Any]

    @property
    def file(self) -> FileState | None:
        """The state of the file that was measured, None where none was read."""
        size, modified_ns = self.fields["file_bytes"], self.fields["file_modified_ns"]
        return None if size is None else FileState(size, modified_ns)

    @property
    def sha256(self) -> str:
        """The SHA-256 of the file that was measured, "" where none was read."""
        return self.fields["sha256"] or ""

    @property
    def own_focal(self) -> OwnFocal:
        """What the photo showed about its focal length by itself."""
        told = self.fields["own_focal"]  # missing where an earlier version wrote the part
        return OwnFocal.of(self.scene) if told is None else OwnFocal(told)

    @property
    def scene(self) -> Scene:
        """The scene, as measured."""
        return Scene.from_json(self.fields["scene"])

    def told(self, others: str) -> PreviousRow:
        """Return the row with another digest of the evidence from other photos."""
        return PreviousRow({**self.fields, "others": others})

    def record(self, file: FileState | None) -> Record:
        """Return the row as it stands, of a file with this state."""
        found = self.fields
        counts = Counts(
            1, int(found["status"] == "failed"), int(found["status"] == "no_camera"), found["n_people"] or 0,
            found["n_pairs"] or 0,
        )  # fmt: skip
        return Record(_text({**found, **_of_file(file)}), counts)

    def copied(self, photo: str, file: FileState | None) -> Record:
        """Return the row as that of `photo`, a copy of the file; the row as it stands: a scene would round twice."""
        scene = self.scene.renamed(photo)
        text = _text({**self.fields, "photo": photo, "scene": scene.to_json(), **_of_file(file)})
        return Record(text, _counts(scene))


def _text(fields: Mapping[str, Any]) -> str:
    return json.dumps(fields, allow_nan=False, ensure_ascii=False)


def _of_file(file: FileState | None) -> dict[str, int | None]:
    size, modified_ns = (None, None) if file is None else (file.size, file.modified_ns)
    return {"file_bytes": size, "file_modified_ns": modified_ns}


class OwnFocal(StrEnum):
    """What a photo shows about its focal length by itself, before other photos are used."""

    STATED = "stated"
    SURE = "sure"
    DOUBTFUL = "doubtful"
    NONE = "none"

    @classmethod
    def of(cls, scene: Scene) -> OwnFocal:
        """Return it for a scene measured alone: what its file says is sure where nothing is doubtful about it."""
        source = scene.camera.source
        basis = FocalBasis.ASSUMED if source is None else source.kind.basis
        if basis is FocalBasis.STATED:
            return cls.STATED
        if basis is not FocalBasis.RECORDED:
            return cls.NONE
        return cls.DOUBTFUL if scene.camera.flags or scene.about.digital_zoom is not None else cls.SURE


def record_of(
    scene: Scene, file: FileState | None = None, others: str = "", own_focal: OwnFocal | None = None
) -> Record:
    """Return the row of a scene, and of the state that the file had when it was measured.

    others: a digest of what other photos showed about its camera. own_focal: what it showed by itself, before.
    """
    (photo,) = rows("photos", scene)
    nested: dict[str, list[dict[str, Any]]] = {
        table: [{k: v for k, v in row.items() if k != "photo"} for row in rows(table, scene)]
        for table in ("people", "pairs")
    }
    attributes = scene.people.attributes
    for row, stated in zip(nested["people"], attributes, strict=True):
        row["attributes"] = dict(stated) or None
    fields = {**photo, **nested, "attributes": list(keys_of(attributes)), "scene": scene.to_json(), **_of_file(file)}
    fields |= {"focal_mm": scene.about.focal_mm, "others": others, "own_focal": own_focal or OwnFocal.of(scene)}
    return Record(_text(fields), _counts(scene))


def _counts(scene: Scene) -> Counts:
    return Counts(
        photos=1,
        failed=int(scene.status == "failed"),
        no_camera=int(scene.status == "no_camera"),
        people=len(scene),
        pairs=scene.distances.below(math.inf),
    )


@cache
def structure() -> str:
    """Return the rows' structure as DuckDB's `from_json` takes it."""
    fields: dict[str, Any] = {c.name: c.kind for c in TABLES["photos"]}
    for table in ("people", "pairs"):
        fields[table] = [{c.name: c.kind for c in TABLES[table] if c.name != "photo"}]
    fields["people"][0]["attributes"] = "MAP(VARCHAR, VARCHAR)"
    fields |= {"attributes": ["VARCHAR"], "scene": "VARCHAR", "file_bytes": "BIGINT", "file_modified_ns": "BIGINT"}
    fields |= {"focal_mm": "DOUBLE", "others": "VARCHAR", "own_focal": "VARCHAR"}
    return json.dumps([fields])
