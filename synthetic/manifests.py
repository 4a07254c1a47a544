"""The list of a results folder's photos, made without measuring any."""

from collections.abc import Sequence

from proxemetry.archive.run.manifest_update import ManifestUpdate
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.manifest import Manifest, read
from proxemetry.archive.store.photos import Search


def listed_photos(folder: Folder, photos: Search | Sequence[str]) -> Manifest:
    """Return the manifest of a results folder, made now or extended by the photos that it lacks.

    photos: a search for them, or the names of recorded ones.
    """
    update = ManifestUpdate(folder, photos, read(folder))
    update.allow()
    try:
        return update.result()
    finally:
        update.close()
