"""How far a detected joint lies from where it should be: the pixel standard deviation, for weighing keypoints.

The law, per image axis and with `body_px` the apparent stature (see `apparent_stature_px`):

    sd_px^2 = floor_px^2 + (definition[joint] * body_px)^2 + (spread[joint] * score^(-score_power) * body_px)^2

floor_px is what a photo's own pixels cost, definition[joint] how far people differ on where the joint is, spread[joint]
how much the detector's answer varies at score 1, both as fractions of the stature, and score_power how that grows as it
gets uncertain. Also, a back end may see lengths between joints longer or shorter than they are: for all people alike
(`scale`), and each person's by as much at all of their joints (`common`: a head that is seen too narrow is too narrow
at both ears). It locates joints less well from above than from eye level, as there were few such in what it was trained
on: noise grows with the sine of the angle from above (`from_above`), and bodies are seen as if from less far above than
they are (`too_level_deg`). Last, people's errors are shared, so that many of them determine the camera less well than
their number suggests (`alike`). The table `keypoint_noise.toml` holds the numbers with their origin;
`keypoint_noise.py`, `from_above.py` and `seen_tilt.py` of `benchmarks/networks` measure them.
"""

from __future__ import annotations

import functools
import importlib.resources
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from .people import People
from .skeleton import kind_of

#: The source that stands in for one that was not measured.
DEFAULT_SOURCE = "default"

#: `NoiseLaw.alike` of detectors that were not measured: that of those that were. Six people whose joints were measured
#: have 89 % of their pairs inside the intervals with it, 77 without (benchmarks/accuracy/captured_people.py).
UNMEASURED_ALIKE = 3.0
#: `NoiseLaw.too_level_deg` of these: that of those that were measured.
UNMEASURED_TOO_LEVEL_DEG = 2.0

#: What counts as one stature where only a limb is seen, metres (a 1.70 m adult; joints as detectors place them).
_STATURE_M = 1.70
_LIMBS_M = (
    (("neck", "mid_hip"), 0.52), (("left_shoulder", "right_shoulder"), 0.35),
    (("left_hip", "left_knee"), 0.42), (("right_hip", "right_knee"), 0.42),
    (("left_knee", "left_ankle"), 0.41), (("right_knee", "right_ankle"), 0.41),
    (("left_shoulder", "left_elbow"), 0.28), (("right_shoulder", "right_elbow"), 0.28),
    (("nose", "neck"), 0.25),
)  # fmt: skip


@dataclass(frozen=True)
class NoiseLaw:
    """The noise of one back end or skeleton.

    definition, spread: joint name (without its side) -> fraction of the apparent stature, one image axis; what is not
    listed has that of "other". origin: where the numbers come from. scale, common: name of a length
    (`anthropometry.LENGTHS`) -> how long it is seen, of its true length, and the relative standard deviation of that
    from person to person; what is not listed is seen as it is. lowest_score: what scores less is drawn, not seen.
    from_above: joint name (without its side) -> what is added to 1, times the sine of the angle, for the factor by
    which the spread grows; what is not listed has that of "other", 0 where there is none. alike: by what the variance
    of all that people together show of the camera's pitch, roll and height is multiplied. too_level_deg: by how many
    degrees less from above bodies are seen than they are, before cameras that look down.
    """

    definition: Mapping[str, float]
    spread: Mapping[str, float]
    score_power: float
    floor_px: float
    origin: str
    scale: Mapping[str, float] = field(default_factory=dict[str, float])
    common: Mapping[str, float] = field(default_factory=dict[str, float])
    lowest_score: float = 0.05
    from_above: Mapping[str, float] = field(default_factory=dict[str, float])
    alike: float = 1.0
    too_level_deg: float = 0.0

    def sd_px(self, joint: str, score: ArrayLike, body_px: ArrayLike) -> FloatArray:
        """Return the standard deviation along one image axis, pixels; NaN where the score is 0.

        score and body_px broadcast.
        """
        kind = kind_of(joint)
        definition = self.definition.get(kind, self.definition["other"])
        return np.hypot(
            self.floor_px, np.hypot(definition, self.score_noise([joint], score)) * np.asarray(body_px, dtype=float)
        )

    def score_noise(self, joints: Sequence[str], scores: ArrayLike) -> FloatArray:
        """Return how far the detector's answers for K joints stray from their own mean, in statures.

        scores: shape (..., K), as is the answer; NaN where a score is 0. One joint goes with scores of any shape.
        """
        known = np.asarray(scores, dtype=float)
        usable = np.where(known > 0, np.clip(known, _LOWEST_SCORE, 1.0), np.nan)
        return np.array([self.spread.get(kind_of(j), self.spread["other"]) for j in joints]) * usable**-self.score_power

    def grows_from_above(self, joints: Sequence[str]) -> FloatArray:
        """Return what is added to 1, times the sine of the angle from above, for each of K joints, shape (K,)."""
        return np.array([self.from_above.get(kind_of(j), self.from_above.get("other", 0.0)) for j in joints])


#: Below this score a joint is no worse: the power law was measured above it.
_LOWEST_SCORE = 0.1


@functools.cache
def laws() -> Mapping[str, NoiseLaw]:
    """Return every law of the table by the name of its back end or skeleton."""
    text = importlib.resources.files(__package__ or "").joinpath("keypoint_noise.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    default = table[DEFAULT_SOURCE]
    return {
        name: NoiseLaw(
            {**default["definition"], **row.get("definition", {})},
            {**default["spread"], **row.get("spread", {})},
            row["score_power"], row["floor_px"], row["origin"], row.get("scale", {}), row.get("common", {}),
            row.get("lowest_score", NoiseLaw.lowest_score), row.get("from_above", {}), row.get("alike", 1.0),
            row.get("too_level_deg", 0.0),
        )
        for name, row in table.items()
    }  # fmt: skip


def law_of(*sources: str) -> NoiseLaw:
    """Return the law of the first source that the table has: the back end's name, then the skeleton's, for example."""
    known = laws()
    return next((known[source] for source in sources if source in known), known[DEFAULT_SOURCE])


def law_for(people: People) -> NoiseLaw:
    """Return the law of the back end that saw people, else their skeleton's.

    People found by a back end that was not measured, and recorded people, share errors as others do
    (`UNMEASURED_ALIKE`).
    """
    law = law_of(people.source, people.skeleton.name)
    unmeasured = people.source and people.source not in laws()
    return replace(law, alike=UNMEASURED_ALIKE, too_level_deg=UNMEASURED_TOO_LEVEL_DEG) if unmeasured else law


def people_sd_px(people: People) -> FloatArray:
    """Return the standard deviations of all joints of all people, shape (P, K), pixels; NaN where missing."""
    law, body_px = law_for(people), apparent_stature_px(people)
    columns = [law.sd_px(joint, people.scores[:, k], body_px) for k, joint in enumerate(people.skeleton.joints)]
    return np.stack(columns, axis=1) if columns else np.zeros((len(people), 0))


def apparent_stature_px(people: People) -> FloatArray:
    """Return how tall each person would stand in the photo where they are, shape (P,), pixels.

    The largest stature that a seen limb implies, since turning and bending only shorten limbs; the box's longer side
    where fewer than two joints are seen. For weighing, not for measuring: limbs differ by some 10 % between people.
    """
    implied = [
        np.linalg.norm(people.joint(a) - people.joint(b), axis=1) * (_STATURE_M / length_m)
        for (a, b), length_m in _LIMBS_M
    ]
    from_limbs = np.where(np.isfinite(implied), implied, -np.inf).max(axis=0)
    sides = people.boxes_px[:, 2:] - people.boxes_px[:, :2]
    return np.where(np.isfinite(from_limbs), from_limbs, sides.max(axis=1, initial=0.0))
