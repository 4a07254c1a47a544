"""What a run tells besides its numbers, each as one line."""

from __future__ import annotations

from ...camera.table import CameraTable
from ..store.manifest import Manifest
from ..store.results import Results
from .schedule import Note


def unused_rows(table: CameraTable, listed: Manifest) -> Note | None:
    """Return which rows of a camera table match no photo: a typing error would leave a photo to its own file."""
    unused = table.unused(item.photo for shard in range(listed.n_shards) for item in listed.items(shard))
    if not unused:
        return None
    first = f"line {unused[0].line} ({unused[0].photo})"
    more = f" and {len(unused) - 1} more" if len(unused) > 1 else ""
    apply = "apply" if more else "applies"
    return Note(f"{table.source}: {first}{more} {apply} to no photo")


def measured_again(count: int) -> Note | None:
    """Return how many photos had been replaced."""
    if not count:
        return None
    if count == 1:
        return Note("1 photo had been replaced since it was measured, and was measured again")
    return Note(f"{count} photos had been replaced since they were measured, and were measured again")


def lost_corrections(results: Results) -> Note | None:
    """Return which corrected files are no longer among the photos: that work is in no number."""
    lost = results.corrections_of_no_photo()
    if not lost:
        return None
    which = "1 corrected photo is" if len(lost) == 1 else f"{len(lost)} corrected photos are"
    named = f"{', '.join(lost[:3])}{', ...' if len(lost) > 3 else ''}"
    return Note(f"{which} another file now or gone ({named}): the corrections are kept for the file they were made on")
