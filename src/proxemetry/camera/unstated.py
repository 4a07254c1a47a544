"""The focal length of a photo that nothing states: what published photos have, weighed with its lines and people.

Each kind of evidence is believed only so far (`trust`): the posterior is the prior times a mixture of what it says and
of nothing. Where the interval stays wide, what is left is an assumption, and is marked as one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..intervals import HALF_WIDTH_SD
from ..people import People
from ..photo import Photo
from .camera import Camera
from .estimate import CameraEstimate, Candidate
from .focal import flags_beside_focal
from .frame import Frame, frame_of
from .from_people.self_calibration import FocalPosterior, focal_posterior
from .lines.focal import TRUSTED, focal_profile
from .published import FULL_FRAME_DIAGONAL_MM, log_density
from .sources import Doubt, Flag, FocalSource, Source

#: Widest central 90 % interval that is an estimate, as high over low; a wider one is an assumption.
WIDEST_RATIO = 1.3 / 0.7
#: How far people are believed where they tell a focal length: their intervals of four hold half of the truths, of ten
#: nine in ten (`benchmarks/accuracy/self_calibration.py --mocap`).
_PEOPLE_TRUST = 0.85
#: An assumption's standard deviation grows by this: the fit is linear about one focal length, so wide a spread is not
#: (`benchmarks/accuracy/unstated_focal.py`: without it, intervals hold 82 % of pairs).
_BEYOND_LINEAR = 1.2
_GRID: FloatArray = np.linspace(math.log(8.0), math.log(800.0), 461)  # log 35 mm equivalents


@dataclass(frozen=True, eq=False)
class _Evidence:
    """What one kind of evidence says of `_GRID`'s focal lengths: its likelihood (G,), about 1; words for print.

    trust: how far it is believed.
    """

    kind: FocalSource
    said: FloatArray
    trust: float
    detail: str
    candidate: Candidate | None = None

    @property
    def likelihood(self) -> FloatArray:
        """What it says as far as it is believed: a mixture of that, and of nothing."""
        return self.trust * self.said + (1 - self.trust)


def without_statement(
    estimate: CameraEstimate, photo: Photo, people: People, segments_px: FloatArray | None, assume: bool
) -> CameraEstimate:
    """Return an estimate that lacks a focal length with what lines, people and published photos tell of it.

    segments_px: straight segments (N, 4) of the photo, None where nobody looked. assume: whether what published photos
    have counts; without it the evidence must do alone, or the estimate stays without a camera. A field of view that may
    be assumed gives way to an estimate, and goes before any other assumption.
    """
    frame = frame_of(photo.width, photo.height, photo.metadata)
    pieces = _pieces(photo, frame, people, segments_px)
    evidence = [piece for piece in pieces if isinstance(piece, _Evidence)]
    by_fov = estimate.camera is not None
    if by_fov or not assume:  # alone it must be beyond doubt, or is none
        evidence = [replace(e, trust=1.0) for e in evidence if e.trust >= min(TRUSTED, _PEOPLE_TRUST)]
    candidates = (*(e.candidate for e in evidence if e.candidate is not None), *estimate.candidates)
    prior = np.exp(log_density(_GRID)) if assume and not by_fov else np.ones_like(_GRID)
    low, high, mean, sd = _posterior(prior, evidence)
    told = high - low <= math.log(WIDEST_RATIO) and bool(evidence)
    if not told and (by_fov or not assume):
        why = "; ".join(piece for piece in pieces if isinstance(piece, str))
        reason = None if by_fov else f"{estimate.reason}; {why or 'the evidence leaves it open'}"
        return replace(estimate, candidates=candidates, reason=reason)
    unit = frame.diagonal_px / FULL_FRAME_DIAGONAL_MM
    if told:
        best = max(evidence, key=lambda e: _information(prior, e.likelihood))
        source, doubt = Source(best.kind, best.detail), Doubt.ESTIMATED
        between = f"{math.exp(low) * unit:.0f} to {math.exp(high) * unit:.0f} px"
        text = f"focal length {best.kind.words}: {between}"
    else:
        source, doubt = Source(FocalSource.ASSUMED_PRIOR), Doubt.ASSUMED
        text = f"focal length {source}"
    rel_sd = math.hypot(sd if told else sd * _BEYOND_LINEAR, frame.size_rel_sd)
    chosen = Candidate(math.exp(mean) * unit, rel_sd, source)
    camera = Camera.centred(chosen.focal_px, photo.width, photo.height, focal_rel_sd=rel_sd, source=source)
    camera = replace(camera, principal_sd_px=frame.principal_sd_px)
    if frame.principal_px is not None:
        camera = replace(camera, cx=frame.principal_px[0], cy=frame.principal_px[1])
    kept = tuple(flag for flag in flags_beside_focal(estimate.flags))
    return CameraEstimate(
        camera, (chosen, *candidates), (*kept, Flag(doubt, text)), mount=estimate.mount, why=estimate.why
    )


def _posterior(prior: FloatArray, evidence: list[_Evidence]) -> tuple[float, float, float, float]:
    """Return 5th and 95th percentile, mean and standard deviation of the log 35 mm equivalent."""
    density = prior * np.prod([e.likelihood for e in evidence], axis=0) if evidence else prior
    weight = density / density.sum()
    low, high = np.interp([0.05, 0.95], np.cumsum(weight), _GRID)
    mean = float(weight @ _GRID)
    # The fit takes it as normal: as wide as the interval, where tails are long.
    sd = max(math.sqrt(float(weight @ (_GRID - mean) ** 2)), float(high - low) / (2 * HALF_WIDTH_SD))
    return float(low), float(high), mean, sd


def _information(prior: FloatArray, likelihood: FloatArray) -> float:
    """Return how much evidence changes what is expected: the divergence of the posterior from the prior, nats."""
    before = prior / prior.sum()
    after = before * likelihood
    after /= after.sum()
    return float(after @ np.log(np.maximum(after, 1e-300) / before))


def _pieces(
    photo: Photo, frame: Frame, people: People, segments_px: FloatArray | None
) -> list[_Evidence | str]:  # fmt: skip
    """Return what there is of evidence, or why a kind of it says nothing."""
    unit = frame.diagonal_px / FULL_FRAME_DIAGONAL_MM
    pieces: list[_Evidence | str] = []
    if segments_px is not None:
        profile = focal_profile(segments_px, photo.width, photo.height, frame.principal_sd_px)
        if isinstance(profile, str):
            pieces.append(f"none from straight lines: {profile}")
        else:
            in_diagonals = _GRID + math.log(unit / math.hypot(photo.width, photo.height))
            pieces.append(_believed(FocalSource.LINES, profile.at(in_diagonals), profile.trust, "", None))
    posterior = focal_posterior(people, photo.width, photo.height)
    if isinstance(posterior, str):
        pieces.append(f"none from the people: {posterior}")
    else:
        pieces.append(_of_people(posterior, unit))
    return pieces


def _of_people(posterior: FocalPosterior, unit: float) -> _Evidence:
    log = np.interp(_GRID + math.log(unit), posterior.log_f, posterior.log_likelihood)
    count, pitch = int(posterior.upright.sum()), math.degrees(posterior.pitch_rad)
    detail = f"{count} upright, camera pitched {pitch:.0f} degrees"
    candidate = Candidate(posterior.f_px, posterior.log_sd, Source(FocalSource.PEOPLE, detail))
    return _believed(FocalSource.PEOPLE, log, _PEOPLE_TRUST, detail, candidate)


def _believed(
    kind: FocalSource, log: FloatArray, trust: float, detail: str, candidate: Candidate | None
) -> _Evidence:  # fmt: skip
    """Return evidence of the log likelihood (G,): what is expected of published photos makes it 1 on the whole."""
    said = np.exp(log - log.max())
    expected = np.exp(log_density(_GRID))
    mean = float(said @ expected / expected.sum())
    return _Evidence(kind, said / mean, trust, detail, candidate)
