"""The focal length of a photo that nothing states: what published photos have, weighed with its lines and people.

Each kind of evidence is believed only so far (`trust`): the posterior is the prior times a mixture of its likelihood
and of nothing. Where the interval stays wide, what is left is an assumption, and is marked as one.
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
from .estimate import CameraEstimate, Candidate, Testimony, Witness
from .focal import flags_beside_focal
from .frame import Frame, frame_of
from .from_people.self_calibration import FocalPosterior, focal_posterior
from .lines.focal import NO_STRUCTURE, ONE_DIRECTION, TRUSTED, WEAK_PRIOR, WIDEST, FocalProfile, focal_profile
from .of_shoot import contradiction, of_shoot
from .others import LEAST_PHOTOS, Others, SameModel
from .published import log_density, quantile_mm
from .sensors import FULL_FRAME_DIAGONAL_MM
from .sources import Doubt, Flag, FocalSource, Source

#: Widest central 90 % interval that is an estimate, as high over low; a wider one is an assumption.
WIDEST_RATIO = 1.3 / 0.7
#: How far people are believed where they determine a focal length: their intervals of four hold half of the truths, of
#: ten nine in ten (`benchmarks/accuracy/self_calibration.py --mocap`).
_PEOPLE_TRUST = 0.85
#: Lines that are believed less than this say nothing worth printing.
_HARDLY = 0.5
#: How far a photo has a focal length that others of the same model have; lenses change, and editors mix files.
_MODEL_TRUST = 0.85
#: How near to one of theirs, as a logarithm.
_AS_OTHERS_SD = 0.05
_GRID: FloatArray = np.linspace(math.log(8.0), math.log(800.0), 461)  # log 35 mm equivalents


@dataclass(frozen=True, eq=False)
class _Evidence:
    """How probable one kind of evidence makes `_GRID`'s focal lengths: its likelihood (G,), about 1.

    trust: how far it is believed. candidate: what it says by itself. testimony: the same in words.
    """

    said: FloatArray
    trust: float
    candidate: Candidate
    testimony: Testimony

    @property
    def likelihood(self) -> FloatArray:
        """Its likelihood as far as it is believed: a mixture of it and of no evidence."""
        return self.trust * self.said + (1 - self.trust)


def without_statement(
    estimate: CameraEstimate, photo: Photo, people: People, segments_px: FloatArray | None, assume: bool,
    others: Others | None = None,
) -> CameraEstimate:  # fmt: skip
    """Return an estimate that lacks a focal length with one from lines, people, other and published photos.

    segments_px: straight segments (N, 4) of the photo, None where they were not looked for. assume: whether what
    published photos have counts; without it the evidence must do alone, or the estimate stays without a camera. A field
    of view that may be assumed gives way to an estimate, and goes before any other assumption.
    """
    frame, others = frame_of(photo.width, photo.height, photo.metadata), others or Others()
    if others.shoot is not None:
        doubt = contradiction(others.shoot, people, photo)
        if doubt is None:
            return of_shoot(estimate, others.shoot, photo)
        estimate = replace(estimate, flags=(*estimate.flags, doubt))
    pieces = _pieces(photo, frame, people, segments_px)
    if others.model is not None:
        pieces.append(_of_model(others.model, frame.diagonal_px / FULL_FRAME_DIAGONAL_MM))
    evidence = [piece for piece in pieces if isinstance(piece, _Evidence)]
    by_fov = estimate.camera is not None
    heard = _heard(estimate, pieces, assume and not by_fov)
    if by_fov or not assume:  # alone it must be beyond doubt, or is none
        evidence = [replace(e, trust=1.0) for e in evidence if e.trust >= min(TRUSTED, _PEOPLE_TRUST)]
    unit = frame.diagonal_px / FULL_FRAME_DIAGONAL_MM
    candidates = (*(e.candidate for e in evidence if e.testimony.counted), *estimate.candidates)
    prior = np.exp(log_density(_GRID)) if assume and not by_fov else np.ones_like(_GRID)
    low, high, mean, sd = _posterior(prior, evidence)
    told = high - low <= math.log(WIDEST_RATIO) and bool(evidence)
    if not told and (by_fov or not assume):
        why = "; ".join(str(piece) for piece in pieces if isinstance(piece, Testimony))
        reason = None if by_fov else f"{estimate.reason}; {why or 'the evidence leaves it open'}"
        return replace(estimate, candidates=candidates, reason=reason, testimony=heard)
    if told:
        best = max(evidence, key=lambda e: _information(prior, e.likelihood))
        source, doubt = best.candidate.source, Doubt.ESTIMATED
        between = f"{math.exp(low) * unit:.0f} to {math.exp(high) * unit:.0f} px"
        text = f"focal length {source.kind.words}: {between}"
        why = f"they narrow it most, to {_millimetres(low, high)}"
    else:
        source, doubt = Source(FocalSource.ASSUMED_PRIOR), Doubt.ASSUMED
        text = f"focal length {source}"
        why = f"the evidence does not narrow it enough: {_millimetres(low, high)} stays possible"
    rel_sd = math.hypot(sd, frame.size_rel_sd)
    chosen = Candidate(math.exp(mean) * unit, rel_sd, source)
    camera = Camera.centred(chosen.focal_px, photo.width, photo.height, focal_rel_sd=rel_sd, source=source)
    camera = replace(camera, principal_sd_px=frame.principal_sd_px)
    if frame.principal_px is not None:
        camera = replace(camera, cx=frame.principal_px[0], cy=frame.principal_px[1])
    # Why the file's own answer is not used stays with what is used instead.
    why_not = (f for f in estimate.flags if f.doubt in (Doubt.CONTRADICTED, Doubt.METADATA))
    kept = (*flags_beside_focal(estimate.flags), *why_not)
    return CameraEstimate(
        camera, (chosen, *candidates), (*kept, Flag(doubt, text)), mount=estimate.mount, why=why, testimony=heard
    )


def _millimetres(low: float, high: float) -> str:
    """Return an interval of log 35 mm equivalents for print."""
    return f"{math.exp(low):.0f} to {math.exp(high):.0f} mm (35 mm equivalent)"


def _heard(
    estimate: CameraEstimate, pieces: list[_Evidence | Testimony], published: bool
) -> tuple[Testimony, ...]:  # fmt: skip
    """Return the evidence from each source, in words; published: whether published photos count."""
    said = (piece.testimony if isinstance(piece, _Evidence) else piece for piece in pieces)
    file = (Testimony(Witness.FILE, estimate.reason.partition("; ")[0], counted=False),) if estimate.reason else ()
    low, middle, high = (quantile_mm(share) for share in (0.05, 0.5, 0.95))
    usual = f"half have less than {middle:.0f} mm, nine in ten {low:.0f} to {high:.0f} mm (35 mm equivalent)"
    expected = Testimony(Witness.PUBLISHED, usual if published else f"not asked ({usual})", published)
    return (*file, *said, expected)


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
) -> list[_Evidence | Testimony]:  # fmt: skip
    """Return the evidence that there is, or why a kind of it is missing."""
    unit = frame.diagonal_px / FULL_FRAME_DIAGONAL_MM
    pieces: list[_Evidence | Testimony] = []
    if segments_px is not None:
        profile = focal_profile(segments_px, photo.width, photo.height, frame.principal_sd_px)
        if isinstance(profile, str):
            pieces.append(Testimony(Witness.LINES, f"none: {profile}", counted=False))
        else:
            pieces.append(_of_lines(profile, len(segments_px), unit / math.hypot(photo.width, photo.height), unit))
    if len(people):
        posterior = focal_posterior(people, photo.width, photo.height)
        if isinstance(posterior, str):
            pieces.append(Testimony(Witness.PEOPLE, f"none: {posterior}", counted=False))
        else:
            pieces.append(_of_people(posterior, unit))
    return pieces


def _of_lines(profile: FocalProfile, count: int, diagonals_a_mm: float, unit: float) -> _Evidence:
    log = profile.at(_GRID + math.log(diagonals_a_mm))
    low, middle, high = (value - math.log(diagonals_a_mm) for value in profile.quantiles(*WEAK_PRIOR))
    candidate = Candidate(
        math.exp(middle) * unit, (high - low) / (2 * HALF_WIDTH_SD), Source(FocalSource.LINES, f"{count} segments")
    )
    if profile.trust < _HARDLY:
        words, counted = f"none: {NO_STRUCTURE} ({count} segments)", False
    else:
        says = "leave it open" if high - low > WIDEST else f"say {math.exp(middle):.0f} mm"
        if profile.one_direction:
            says = f"({ONE_DIRECTION}) {says}"
        words = f"{count} segments {says}: {_millimetres(low, high)}, believed to {profile.trust:.0%}"
        counted = True
    return _believed(log, profile.trust, candidate, Testimony(Witness.LINES, words, counted))


def _of_people(posterior: FocalPosterior, unit: float) -> _Evidence:
    log = np.interp(_GRID + math.log(unit), posterior.log_f, posterior.log_likelihood)
    count, pitch = int(posterior.upright.sum()), math.degrees(posterior.pitch_rad)
    detail = f"{count} upright, camera pitched {pitch:.0f} degrees"
    candidate = Candidate(posterior.f_px, posterior.log_sd, Source(FocalSource.PEOPLE, detail))
    low, high = (math.log(value / unit) for value in (posterior.low_px, posterior.high_px))
    seen = f"{count} who stand upright, seen from {abs(pitch):.0f} degrees {'above' if pitch >= 0 else 'below'}"
    words = f"{seen}, say {_millimetres(low, high)}, believed to {_PEOPLE_TRUST:.0%}"
    return _believed(log, _PEOPLE_TRUST, candidate, Testimony(Witness.PEOPLE, words, counted=True))


def _of_model(model: SameModel, unit: float) -> _Evidence | Testimony:
    """Return what focal lengths other photos of the same model have, as far as this one may have another."""
    photos = sum(count for _, count in model.equivalents)
    if photos < LEAST_PHOTOS:
        return Testimony(Witness.OTHERS, f"none: {photos} of {model.model}, too few", counted=False)
    shares = np.array([count / photos for _, count in model.equivalents])
    at = np.log([mm for mm, _ in model.equivalents])
    said = (shares[:, None] * np.exp(-0.5 * ((_GRID - at[:, None]) / _AS_OTHERS_SD) ** 2)).sum(axis=0)
    middle = float(shares @ at)
    sd = math.hypot(_AS_OTHERS_SD, math.sqrt(float(shares @ (at - middle) ** 2)))
    candidate = Candidate(math.exp(middle) * unit, sd, Source(FocalSource.SAME_CAMERA, f"{photos} of {model.model}"))
    words = f"{photos} of {model.model} have {_millimetres(float(at.min()), float(at.max()))}"
    return _believed(np.log(said + 1e-300), _MODEL_TRUST, candidate, Testimony(Witness.OTHERS, words, counted=True))


def _believed(log: FloatArray, trust: float, candidate: Candidate, testimony: Testimony) -> _Evidence:
    """Return evidence of the log likelihood (G,): what is expected of published photos makes it 1 on the whole."""
    said = np.exp(log - log.max())
    expected = np.exp(log_density(_GRID))
    mean = float(said @ expected / expected.sum())
    return _Evidence(said / mean, trust, candidate, testimony)
