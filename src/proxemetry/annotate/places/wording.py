"""A solution of places in plain words: what contradicts, what has no place yet, what to tape, what nothing checks."""

from __future__ import annotations

from dataclasses import dataclass

from .contradiction import Contradiction
from .measurements import Tape
from .solution import Places

#: Misfits this many times larger than stated are worth reporting.
_LOOSE = 1.5
#: So many suspects are named; where more are, the table shows them.
_MOST_NAMED = 3


@dataclass(frozen=True)
class Remark:
    """One sentence on a solution. problem: something is to be done about it."""

    text: str
    problem: bool


def remarks_on(places: Places) -> list[Remark]:
    """Return what is to be said of a solution, what is wrong first."""
    found: list[Remark] = []
    if places.contradiction is not None:
        found.append(Remark(contradiction_text(places.contradiction), True))
    found += [Remark(f"{t}: {why}", True) for t, why in zip(places.tags, places.reasons, strict=True) if why]
    if places.by_tag and places.free <= 0 and any(isinstance(fit.measurement, Tape) for fit in places.fits):
        found.append(
            Remark("Nothing checks these measurements: one more tape than needed would show a misread one.", False)
        )
    if places.mirrored:
        found.append(Remark("Left and right may be exchanged as a whole. That changes no distance.", False))
    if places.scale > _LOOSE and places.contradiction is None:
        found.append(Remark(f"The tapes disagree {places.scale:.1f} times as much as their stated uncertainty.", False))
    return found


def contradiction_text(found: Contradiction) -> str:
    """Return in words what contradicts what, and what to do."""
    named = [
        f"{s.measurement} ({s.measurement.metres:g} m; the others say {s.expected_m:.2f})"
        if isinstance(s.measurement, Tape)
        else str(s.measurement)
        for s in found.suspects
    ]
    if not named:
        return "The measurements contradict each other."
    if len(named) == 1 and found.settled:
        return f"One measurement contradicts all others: {named[0]}. Measure it again."
    if found.settled and len(named) <= _MOST_NAMED:
        which = f"any one of these may be wrong: {', '.join(named)}"
    elif found.settled:
        which = f"any one of {len(named)} may be wrong"
    else:
        return f"Several measurements contradict the others, {', '.join(named)} the most. Measure them again."
    return f"The measurements contradict each other, and {which}. Measure again, or tape one more distance."
