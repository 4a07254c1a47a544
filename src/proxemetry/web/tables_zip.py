"""The tables of photos that have no results folder, as one file to download."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable

from ..archive.store import parts
from ..archive.store.folder import Folder
from ..archive.store.part_rows import record_of
from ..archive.store.results import Results
from ..archive.store.run_file import write_run
from ..archive.store.scratch import scratch_folder
from ..scene import Scene
from ..version import __version__


def tables_zip(scenes: Iterable[Scene]) -> bytes:
    """Return photos.csv, people.csv, pairs.csv and codebook.csv of scenes as a zip archive.

    They are made as a results folder's are, in a temporary folder, so that columns and numbers are the same.
    """
    with scratch_folder("tables") as location:
        folder = Folder(location)
        parts.write(folder, 0, [record_of(scene) for scene in scenes], {"proxemetry_version": __version__})
        write_run(folder, {"version": __version__})
        Results(folder).write_tables()
        packed = io.BytesIO()
        with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in ("photos.csv", "people.csv", "pairs.csv"):
                archive.writestr(name, folder.read(name) or b"")
            archive.writestr("codebook.csv", folder.read("codebook.csv") or b"")
        return packed.getvalue()
