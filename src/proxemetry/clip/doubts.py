"""Doubts about whole tracks: what most of the frames that show a person say, and what all of them show together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..people.attributes import Attributes, PairsWhere, values_of
from ..people.doubts import PersonDoubt
from ..tables import DOUBT, doubts_in_text, reasons_in
from .placing import Placed
from .stillness import is_motionless


def of_sightings(
    frames: NDArray[np.intp], rows: NDArray[np.intp], placed: Sequence[Placed]
) -> list[tuple[PersonDoubt, ...] | None]:
    """Return the reasons in each of a track's frames (n,), given its rows (n,) of their scenes; None where unseen."""
    return [
        placed[frame].doubts[row] if row >= 0 and placed[frame].doubts else None
        for frame, row in zip(frames, rows, strict=True)
    ]


def stays_put(
    frames: NDArray[np.intp], t_s: FloatArray, rows: NDArray[np.intp], placed: Sequence[Placed]
) -> bool:  # fmt: skip
    """Return whether a track, given its frames (n,), their times and its rows of their scenes, never moves at all."""
    seen, joints = list[float](), list[FloatArray]()
    for frame, time, row in zip(frames, t_s, rows, strict=True):
        of_frame = placed[frame].keypoints_px
        if row >= 0 and of_frame is not None:
            seen.append(time)
            joints.append(of_frame[row])
    return bool(seen) and is_motionless(np.array(seen), np.array(joints, dtype=float))


def of_track(sightings: Sequence[tuple[PersonDoubt, ...]], motionless: bool) -> tuple[PersonDoubt, ...] | None:
    """Return a track's reasons in their order, given those of its sightings; None without sightings."""
    reasons = of_most(sightings)
    return reasons if reasons is None or not motionless else (*reasons, PersonDoubt.MOTIONLESS)


def of_most(sightings: Sequence[tuple[PersonDoubt, ...]]) -> tuple[PersonDoubt, ...] | None:
    """Return the reasons that more than half of a track's sightings have, in their order; None without sightings."""
    if not sightings:
        return None
    count = Counter(reason for reasons in sightings for reason in reasons)
    return tuple(reason for reason in PersonDoubt if 2 * count[reason] > len(sightings))


def counts(where: PairsWhere, attributes: Attributes, reasons: tuple[PersonDoubt, ...] | None) -> bool:
    """Return whether a track with these attributes and doubts is as asked for; of several doubts any will do.

    If a recording has an attribute named like the column of doubts, the attribute is meant, as in tables of photos.
    """
    if reasons is None:
        return where.holds(attributes)
    return any(where.holds({DOUBT: reason, **attributes}) for reason in reasons_in(doubts_in_text(reasons)))


def require_some(where: PairsWhere, tracks: Iterable[tuple[Attributes, tuple[PersonDoubt, ...] | None]]) -> None:
    """Raise SettingsError where no track of these attributes and doubts can be as asked for."""
    tracks = list(tracks)
    known = values_of([attributes for attributes, _ in tracks])
    asked = [reasons for _, reasons in tracks if reasons is not None]
    if DOUBT in where.accepted and DOUBT not in known and asked:
        known[DOUBT] = Counter(reason for reasons in asked for reason in reasons_in(doubts_in_text(reasons)))
    where.require_some(known)
