"""From measurements to places: positions, what each tape misses by, and in plain words what cannot be determined."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...arrays import FloatArray
from ...errors import SettingsError
from .ambiguity import Layouts, distance_sd, distances_of, layouts
from .contradiction import CHECKED, Contradiction, contradiction, normalised
from .measurements import MOST_TAGS, Measurement, Spot, Tape
from .network import Network, components


@dataclass(frozen=True)
class Fit:
    """How a measurement fits. residual_m: measured less computed (NaN where its marks have no place).

    z: the residual over its own standard deviation. checked: whether other measurements check it at all.
    """

    measurement: Measurement
    residual_m: float
    z: float
    checked: bool


@dataclass(frozen=True, eq=False)
class Places:
    """N marks on the floor. positions_m: shape (N, 2), NaN where undetermined; reasons say why.

    distance_m, distance_sd_m: shape (N, N), NaN where either mark has no place. fits: one a measurement, tapes first.
    contradiction: None where all agree. mirrored: the whole may be its mirror image, which changes no distance. scale:
    how many times larger than stated the measurements' errors turned out, 1 where they are as stated or smaller;
    standard deviations hold it.
    """

    tags: tuple[str, ...]
    positions_m: FloatArray
    reasons: tuple[str | None, ...]
    distance_m: FloatArray
    distance_sd_m: FloatArray
    fits: tuple[Fit, ...]
    contradiction: Contradiction | None = None
    mirrored: bool = False
    scale: float = 1.0
    free: int = 0
    by_tag: dict[str, tuple[float, float]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rows: list[tuple[float, float]] = [(float(x), float(y)) for x, y in self.positions_m]
        places = {tag: at for tag, at in zip(self.tags, rows, strict=True) if math.isfinite(at[0])}
        object.__setattr__(self, "by_tag", places)


def solve(tags: Sequence[str], tapes: Sequence[Tape], spots: Sequence[Spot]) -> Places:
    """Return the places of marks from taped distances and coordinates, by least squares.

    tags: the marks asked about; those that measurements name are included too. Raises SettingsError where a mark has
    two coordinates, a pair two tapes, or there are more marks than `MOST_TAGS`.
    """
    named = [*tags, *(end for tape in tapes for end in (tape.a, tape.b)), *(spot.tag for spot in spots)]
    marks = tuple(dict.fromkeys(named))
    _check(marks, tapes, spots)
    groups = components(marks, tapes, spots)
    main = _main(groups, spots)
    inner = tuple(tag for tag in marks if tag in main)
    network = Network(inner, tuple(t for t in tapes if t.a in main), tuple(s for s in spots if s.tag in main))
    if len(main) < 2 and not network.spots:
        reasons = tuple(_unlinked(tag, tapes, main) for tag in marks)
        return _nowhere(marks, reasons, (*tapes, *spots))
    found = layouts(network)
    held = _held(network, found)
    positions = _in_frame(network, found.best_m, held)
    scale = math.sqrt(max(1.0, found.cost / network.free)) if network.free > 0 else 1.0
    sd = distance_sd(network, found.best_m) * scale
    reasons = {t: _why_open(network, found, k, held) for k, t in enumerate(inner) if k not in held}
    row = {tag: k for k, tag in enumerate(inner)}
    kept = np.array([row[t] if t in row and row[t] in held else -1 for t in marks])
    there = kept >= 0
    both = there[:, None] & there[None]
    away = distances_of(positions)
    return Places(
        marks,
        np.where(there[:, None], positions[kept], np.nan),
        tuple(_unlinked(t, tapes, main) if t not in row else reasons.get(t) for t in marks),
        np.where(both, away[np.ix_(kept, kept)], np.nan),
        np.where(both, sd[np.ix_(kept, kept)], np.nan),
        _fits(network, found.best_m, (*tapes, *spots)),
        contradiction(network, found.best_m, found.cost),
        _is_mirrored(network, held),
        scale,
        network.free,
    )


def _check(marks: tuple[str, ...], tapes: Sequence[Tape], spots: Sequence[Spot]) -> None:
    if len(marks) > MOST_TAGS:
        raise SettingsError(f"{len(marks)} marks are more than the {MOST_TAGS} of a shoot that are solved together")
    for what, items in (("tapes", [str(sorted(t.ends)) for t in tapes]), ("coordinates", [s.tag for s in spots])):
        if len(set(items)) < len(items):
            twice = next(item for k, item in enumerate(items) if item in items[:k])
            raise SettingsError(f"{twice} has two {what}: keep one")


def _main(groups: list[frozenset[str]], spots: Sequence[Spot]) -> frozenset[str]:
    """Return the group whose marks get places: that of the coordinates where there are any, else the largest."""
    placed = {spot.tag for spot in spots}
    return next((g for g in groups if g & placed), groups[0] if groups else frozenset())


def _nowhere(marks: tuple[str, ...], reasons: tuple[str | None, ...], measured: tuple[Measurement, ...]) -> Places:
    n = len(marks)
    none = np.full((n, n), np.nan)
    fits = tuple(Fit(m, math.nan, math.nan, False) for m in measured)
    return Places(marks, np.full((n, 2), np.nan), reasons, none, none, fits)


def _unlinked(tag: str, tapes: Sequence[Tape], main: frozenset[str]) -> str:
    if not any(tag in tape.ends for tape in tapes):
        return "nothing was measured to it: type its coordinates, or tape it to three marks that have a place"
    others = ", ".join(sorted(main)[:3])
    return f"no tape links it with {others}: tape it, or a mark that it is taped to, to these"


def _held(network: Network, found: Layouts) -> list[int]:
    """Return the rows of the largest set of marks of which every distance is the same in all layouts."""
    same = found.same.astype(bool)
    placed = [network.tags.index(s.tag) for s in network.spots]
    best: list[int] = []
    for first in range(len(network.tags)):
        order = sorted(range(len(network.tags)), key=lambda k: (k not in placed, k != first, -int(same[k].sum()), k))
        chosen: list[int] = []
        for k in order:
            if all(same[k, m] for m in chosen):
                chosen.append(k)
        if len(chosen) > len(best):
            best = chosen
    return sorted(best) if len(best) > 1 or network.spots else []


def _why_open(network: Network, found: Layouts, row: int, held: list[int]) -> str:
    """Return in words why a mark has no place, and what to tape."""
    tag = network.tags[row]
    near = [t.b if t.a == tag else t.a for t in network.tapes if tag in t.ends]
    away = max(held, key=lambda k: float(found.high_m[row, k] - found.low_m[row, k]), default=row)
    what = f"tape it to {network.tags[away]}" if network.tags[away] not in near and away != row else "tape it to more"
    if len(near) == 1:
        return f"one tape alone, to {near[0]}: it may stand anywhere around it; tape it to two more marks"
    low, high = found.low_m[row, away], found.high_m[row, away]
    if len(near) == 2 and all(network.tags.index(other) in held for other in near):
        return f"two places fit, one on either side of the line {near[0]}–{near[1]} (mirror images): {what}"
    return f"several places fit, {low:.2f} to {high:.2f} m from {network.tags[away]}: {what}"


def _in_frame(network: Network, positions_m: FloatArray, held: list[int]) -> FloatArray:
    """Return positions as typed coordinates have them; without any, the first camera (else the first mark) at 0, 0.

    Then y runs from there to the middle of the others, and the first mark beside that line has a positive x.
    """
    if len(network.spots) > 1 or not held:
        return positions_m
    origin = next((k for k in held if network.tags[k].startswith("C")), held[0])
    if network.spots:
        origin = network.tags.index(network.spots[0].tag)
    moved = positions_m - positions_m[origin]
    middle = moved[held].mean(axis=0)
    length = float(np.linalg.norm(middle))
    if length > 1e-6:
        sine, cosine = middle / length
        moved = moved @ np.array([[cosine, sine], [-sine, cosine]])
    beside = next((k for k in held if abs(moved[k, 0]) > 0.02), None)
    if beside is not None and moved[beside, 0] < 0:
        moved = moved * np.array([-1.0, 1.0])
    return moved + positions_m[origin] if network.spots else moved


def _fits(network: Network, positions_m: FloatArray, measured: Sequence[Measurement]) -> tuple[Fit, ...]:
    """Return how well each measurement fits; the larger of a spot's two residuals stands for it."""
    whitened = network.residuals(positions_m.ravel())
    z, redundancy = normalised(network, positions_m), network.redundancy(positions_m)
    inside, fits = set(map(id, network.measurements)), list[Fit]()
    for m in measured:
        if id(m) not in inside:
            fits.append(Fit(m, math.nan, math.nan, False))
            continue
        rows = network.rows(m)
        worst = max(rows, key=lambda r: abs(float(whitened[r])))
        checked = bool(redundancy[rows].max() > CHECKED)
        fits.append(Fit(m, float(whitened[worst]) * m.sd_m, float(z[worst]), checked))
    return tuple(fits)


def _is_mirrored(network: Network, held: list[int]) -> bool:
    """Whether coordinates leave open on which side of their line the rest lies."""
    if len(held) < 3:
        return False
    at = np.array([(s.x_m, s.y_m) for s in network.spots]).reshape(-1, 2)
    if len(at) < 3:
        return len(at) < len(held)
    return bool(np.linalg.svd(at - at.mean(axis=0), compute_uv=False)[1] < 1e-3)
