"""One stature a track: each sighting's estimate of a person's height, pooled robustly and used for the others.

A single frame's fit weighs what it sees against how tall people are; here the second is taken out again, so that a
hundred frames do not count the population a hundred times. Each sighting gets what the *others* give: nothing is used
twice, and a person seen once has only the photo's own numbers. The camera is held meanwhile, as it is in the fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..anthropometry import moments, populations
from ..arrays import FloatArray
from ..locate import LocateSettings
from .sightings import Chain, Sightings
from .smoothing import LASTING_SHARE

#: A sighting with less information than this share of the prior's has none on a stature.
_LEAST_TOLD = 0.05
#: Residuals beyond so many standard deviations count less (Huber 1981): bending, false matches, swapped people.
_HUBER = 1.5
_ROUNDS = 20
#: What of a sighting's variance differs from frame to frame.
_PASSING = 1 - LASTING_SHARE**2
#: Half the width of a Gaussian's middle 50 %, in standard deviations.
_MAD_SD = 0.6745

#: Metres and their standard deviation, of a person in a frame, by the row of the scene.
Known = Mapping[int, tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Stature:
    """The stature of one person from n sightings, as logarithms of metres.

    mean, sd: of all together with what is known of people beforehand. others, others_sd: shape (n,), what the other
    sightings give for each, people left out; NaN where they give nothing.
    """

    mean: float
    sd: float
    others: FloatArray
    others_sd: FloatArray


def pooled(stature_m: FloatArray, sd_m: FloatArray, settings: LocateSettings) -> Stature | None:
    """Return a person's stature by the sightings, given the fit's answers (n,); None where nothing is known."""
    usable = np.isfinite(stature_m) & (sd_m > 0)
    if not usable.any():
        return None
    log, variance = np.log(stature_m[usable]), (sd_m[usable] / stature_m[usable]) ** 2
    prior, prior_variance = _alike(float(np.median(log)), settings)
    told = 1 / variance - 1 / prior_variance
    clear = told > _LEAST_TOLD / prior_variance
    if not clear.any():
        return Stature(float(log.mean()), float(np.sqrt(variance.mean())), *_nothing(len(stature_m)))
    own = (log[clear] / variance[clear] - prior / prior_variance) / told[clear]
    weight, lasting = _robust(own, 1 / told[clear])
    total, product = weight.sum(), weight * own
    variance = _PASSING / total + lasting
    precision = 1 / variance + 1 / prior_variance
    mean = (product.sum() / total / variance + prior / prior_variance) / precision
    others, others_sd = _nothing(len(stature_m))
    share = np.zeros(len(stature_m)), np.zeros(len(stature_m))
    rows = np.flatnonzero(usable)[clear]
    share[0][rows], share[1][rows] = weight, product
    left = total - share[0]
    heard = left > 1e-9 * total
    others[heard] = (product.sum() - share[1][heard]) / left[heard]
    others_sd[heard] = np.sqrt(_PASSING / left[heard] + lasting)
    return Stature(float(mean), float(np.sqrt(1 / precision)), others, others_sd)


def _nothing(count: int) -> tuple[FloatArray, FloatArray]:
    return np.full(count, np.nan), np.full(count, np.nan)


def _alike(log_stature: float, settings: LocateSettings) -> tuple[float, float]:
    """Return mean and variance of the log statures of the likeliest group of this one: adults or children."""
    groups = populations(settings.body_size, settings.child_weight)
    kinds = [
        part for part in (
            tuple(g for g in groups if g.name.startswith("children") == young and g.weight > 0)
            for young in (False, True)
        ) if part
    ]  # fmt: skip
    found: list[tuple[float, float, float]] = []
    for kind in kinds:
        mean, covariance = moments(kind)
        spread = float(covariance[0, 0])
        likely = np.log(sum(g.weight for g in kind)) - 0.5 * ((log_stature - mean[0]) ** 2 / spread + np.log(spread))
        found.append((float(likely), float(mean[0]), spread))
    _, mean, variance = max(found)
    return mean, variance


def _robust(values: FloatArray, variance: FloatArray) -> tuple[FloatArray, float]:
    """Return the weight of each value, and the variance of what is wrong in all of them alike.

    Frames scatter more than each states, by posture and by detector; how much more is read off them.
    """
    between, weight = 0.0, 1 / variance
    for _ in range(_ROUNDS):
        middle = float(weight @ values / weight.sum())
        off = np.abs(values - middle)
        spread = float(np.median(off)) / _MAD_SD
        between = max(0.0, spread**2 - float(np.median(variance)))
        sd = np.sqrt(variance + between)
        before, weight = weight, np.minimum(1.0, _HUBER * sd / np.maximum(off, 1e-12)) / sd**2
        if np.allclose(before, weight, rtol=1e-6):
            break
    return weight, LASTING_SHARE**2 * (float(np.median(variance)) + between)


def known_statures(
    chains: Sequence[Chain], statures: Sequence[Stature | None], shot: Sequence[Sightings]
) -> list[Known]:
    """Return for every frame of a shot the statures given to its people, by their rows in the scene."""
    answer: list[dict[int, tuple[float, float]]] = [{} for _ in shot]
    for chain, found in zip(chains, statures, strict=True):
        if found is None:
            continue
        for frame, person, log, sd in zip(chain.frames, chain.people, found.others, found.others_sd, strict=True):
            if np.isfinite(log):
                stature = float(np.exp(log))
                answer[frame][int(shot[frame].rows[person])] = stature, stature * float(sd)
    return list(answer)


def of_chain(chain: Chain, shot: Sequence[Sightings], settings: LocateSettings) -> Stature | None:
    """Return a person's stature from a chain's sightings."""
    links = list(zip(chain.frames, chain.people, strict=True))
    stature = np.array([shot[f].stature_m[p] for f, p in links])
    spread = np.array([shot[f].stature_sd_m[p] for f, p in links])
    return pooled(stature, spread, settings)


def told_again(before: Sightings, after: Sightings, known: Known) -> Sightings:
    """Return the sightings `after` statures were given, with what hangs on those statures as one error a person.

    A stature that is too tall puts its person too far in every frame: that part of the uncertainty does not average
    out. With covariance C before, C' after, v of the stature before and s of the one given, it is (C - C') s / (v + s).
    """
    lasting = np.zeros((len(after), 2, 2))
    here = {int(row): k for k, row in enumerate(before.rows)}
    for k, row in enumerate(after.rows.tolist()):
        if row not in known or row not in here:
            continue
        stature, sd = known[row]
        then = here[row]
        told, own = (sd / stature) ** 2, (before.stature_sd_m[then] / before.stature_m[then]) ** 2
        gained = _positive(before.covariance_m2[then] - after.covariance_m2[k])
        lasting[k] = _within(gained * told / (own + told), after.covariance_m2[k])
    return replace(after, lasting_m2=lasting)


def _positive(matrix: FloatArray) -> FloatArray:
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2)
    return np.asarray((vectors * np.maximum(values, 0.0)) @ vectors.T)


def _within(part: FloatArray, whole: FloatArray) -> FloatArray:
    """Return a part made no larger than the whole in any direction: the fit's alternatives may have changed."""
    largest = float(np.linalg.eigvals(np.linalg.solve(whole, part)).real.max())
    return part if largest <= 1 else part / largest
