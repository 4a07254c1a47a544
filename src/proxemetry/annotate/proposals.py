"""Starting points: the people that a pose back end finds on a photo, as the benchmark's four parts."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..people import People
from ..people.skeleton import PARTS

#: Joints of a lower score are guesses, which a person would have to take away.
_LEAST_SCORE = 0.3


def proposed_people(
    people: People, width: int, height: int, first_key: int, *, keep_all: bool = False
) -> list[dict[str, Any]]:
    """Return the people of a photo as a "propose" action lists them, from left to right; keys count from `first_key`.

    As the rules have it, no point outside the picture is proposed, and no eyes where one of them is outside. keep_all:
    with the people who have no point, last, and with each one's `row` of `people`.
    """
    seen = people.scores >= _LEAST_SCORE
    sure = replace(
        people,
        keypoints_px=np.where(seen[..., None], people.keypoints_px, np.nan),
        scores=np.where(seen, people.scores, 0),
    )
    parts = np.stack([sure.part(part) for part in PARTS], axis=1)
    is_in = np.isfinite(parts).all(axis=-1) & (parts >= 0).all(axis=-1) & (parts < (width, height)).all(axis=-1)
    inside = np.array(is_in, dtype=bool).reshape(len(people), len(PARTS))
    for eye in ("left_eye", "right_eye"):
        at = sure.joint(eye)
        inside[:, 0] &= ~((at < 0) | (at >= (width, height))).any(axis=-1)
    shown = [k for k in range(len(people)) if inside[k].any()]
    shown.sort(key=lambda k: float(parts[k, inside[k], 0].mean()))
    rest = [k for k in range(len(people)) if keep_all and not inside[k].any()]
    return [
        {
            "person": first_key + place,
            **({"row": k} if keep_all else {}),
            "points": {
                part: [int(x), int(y)] for part, (x, y), there in zip(PARTS, parts[k], inside[k], strict=True) if there
            },
        }
        for place, k in enumerate([*shown, *rest])
    ]
