"""The joint fit of a photo: one floor, one camera and all people's bodies, by maximum a posteriori.

Feet, torsos, shoulders and eyes of all people answer together for the camera's pitch, roll and height and for each
person's place, heading, stature and posture; the normal equations at the answer give the covariance, shared errors
of floor and focal length included.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...bodies import MOST_MISFIT, Bodies
from ...camera import Camera, Mount
from ...people import People
from .. import LocateSettings
from .alternatives import Explanations, at_fit, interleaved, leave_one_out, refine
from .batch import HypothesisBatch
from .body_model import BodyModel, body_model
from .camera_prior import Place, Raised, SharedPrior
from .contradiction import misfit
from .evidence import Evidence, evidence_of
from .explained import Explained
from .hypotheses import (
    Bodytype,
    Hypotheses,
    batch_of,
    body_types,
    hypotheses_of,
    keypoint_precision,
    log_evidence,
    scaled_to_group,
    with_stature,
)
from .mirror import mirrored
from .other_cameras import likeliest_camera
from .posterior import placed_people
from .projection import (
    DEPTH,
    FOCAL,
    HEIGHT,
    LOG_LENGTHS,
    N_SHARED,
    PITCH,
    PRINCIPAL,
    ROLL,
    angle_from_above,
)
from .solver import Fit, gauss_newton_step, solve
from .start import initialise
from .tilt import expected_tilt

#: How even floors are, as a standard deviation of where the soles are: metres, and per metre of distance, since ground
#: slopes and streets are cambered; the tails are heavy (kerbs, steps).
FLOOR_SD_M, FLOOR_SLOPE_SD = 0.04, 0.003
#: Hand-held and mounted cameras: the prior of pitch, roll and height above the floor, assumed, with heavy tails
#: (docs/method.md, "Priors"; benchmarks/accuracy/breakage.py shows what cameras unlike it cost).
PITCH_SD_RAD = np.deg2rad(7.0)
ROLL_SD_RAD = np.deg2rad(1.2)
TYPICAL_HEIGHT_M, HEIGHT_LOG_SD = 1.55, 0.30
#: One camera in seven hangs high and looks down, from a stair, a ceiling or a mast; assumed (docs/method.md, "Priors").
#: By 22 +- 21 degrees, as that is how people look from there who are as far away as people are (`hypotheses`).
RAISED = Raised(0.15, (float(np.deg2rad(22.0)), float(np.log(2.8))), (float(np.deg2rad(21.0)), 0.40))

#: What a mount's covariance is about, among the shared unknowns.
_AS_SHARED = np.array([PITCH, ROLL, HEIGHT, FOCAL])
#: What is known exactly still needs a standard deviation.
_EXACT = 1e-5
#: By how much the floor's and the stated depths' precision is lowered in the first steps.
_LOOSE = 0.25
#: From the first steps on, and from where another explanation has been solved already.
_MOST_ITERATIONS, _MOST_AGAIN = 8, 4
_ALTERNATIVE_STEPS = 2
#: An explanation that is likelier by this log factor after the first steps leads in place of the one that looked best.
_LIKELIER = 1.0
_REASON = "fewer than two usable joints: nothing shows how large this person appears"


def locate(people: People, camera: Camera, settings: LocateSettings, mount: Mount | None = None) -> Bodies:
    """Return where people stand, from all evidence at once.

    `people` are in undistorted pixels of `camera`; `mount` is what is known of its place. Rows without two usable
    joints come back as NaN with a reason.
    """
    model = body_model(people.skeleton)
    explained = explained_people(people, camera, shared_prior(camera, mount), settings, model)
    if explained is None:
        return Bodies.unplaced(len(people), "scene", _REASON)
    return placed_people(explained, model).bodies(len(people), explained.usable, _REASON)


def explained_people(
    people: People, camera: Camera, prior: SharedPrior, settings: LocateSettings, model: BodyModel
) -> Explained | None:
    """Return the joint fit of all people with two usable joints or more, or None where there are none."""
    evidence = evidence_of(people, camera, model)
    usable = np.flatnonzero(_measurable(evidence))
    return _fit(_taken(evidence, usable), prior, settings, usable, model) if len(usable) else None


def _measurable(evidence: Evidence) -> NDArray[np.bool_]:
    """Return which people have at least two joints apart from one another, shape (P,)."""
    high = np.where(evidence.seen[..., None], evidence.points, -np.inf).max(axis=1, initial=-np.inf)
    low = np.where(evidence.seen[..., None], evidence.points, np.inf).min(axis=1, initial=np.inf)
    extent = np.where(evidence.seen.sum(axis=1) >= 2, (high - low).max(axis=1), 0.0)
    return extent > evidence.resolution


def _taken(evidence: Evidence, index: NDArray[np.intp]) -> Evidence:
    return replace(
        evidence, points=evidence.points[index], seen=evidence.seen[index], score_noise=evidence.score_noise[index],
        heading_rad=evidence.heading_rad[index], heading_sd_rad=evidence.heading_sd_rad[index],
        log_depth=evidence.log_depth[index], depth_rel_sd=evidence.depth_rel_sd[index],
    )  # fmt: skip


def shared_prior(camera: Camera, mount: Mount | None = None) -> SharedPrior:
    """Return what is known of the camera's place and of its intrinsics before the people are seen."""
    mean, sd = np.zeros(N_SHARED), np.zeros(N_SHARED)
    mean[HEIGHT] = np.log(TYPICAL_HEIGHT_M)
    sd[PITCH], sd[ROLL], sd[HEIGHT] = PITCH_SD_RAD, ROLL_SD_RAD, HEIGHT_LOG_SD
    sd[FOCAL] = max(camera.focal_rel_sd, _EXACT)
    sd[PRINCIPAL] = max(camera.principal_sd_px / camera.f_px, _EXACT)
    place = Place() if mount is None else _place(camera, mount)
    sd[place.which] = np.inf
    return SharedPrior(mean, sd, place, RAISED)


def _place(camera: Camera, mount: Mount) -> Place:
    """Return what a mount states about the shared unknowns of a camera.

    Where the mount's own focal length was found with its place, it stands for the camera's.
    """
    which = mount.known
    focal = 0.0 if mount.camera is None else np.log(mount.camera.f_px / camera.f_px)
    mean = np.array([mount.pitch_rad, mount.roll_rad, np.log(mount.height_m), focal])[which]
    covariance = np.array(mount.covariance)[np.ix_(which, which)] + np.eye(len(which)) * _EXACT**2
    return Place(_AS_SHARED[which], mean, np.asarray(np.linalg.inv(covariance), dtype=float))


def _fit(
    evidence: Evidence, prior: SharedPrior, settings: LocateSettings, usable: NDArray[np.intp], model: BodyModel
) -> Explained:
    types = _types_of(evidence, settings, usable)
    on_floor = np.array([settings.floor == "shared" and row not in settings.off_floor for row in usable])
    floor_sd = np.where(on_floor, FLOOR_SD_M, np.inf)
    start = initialise(evidence, np.exp([t[0].mean for t in types]), prior, model, on_floor.astype(float))
    hypotheses, first = hypotheses_of(start, types, model)
    rows = batch_of(hypotheses, evidence, types, floor_sd, model, _scale(hypotheses.local[first]))
    hypotheses, first, shared = _first_steps(rows, hypotheses, first, start.shared, prior)
    local = hypotheses.local[first]
    # with size, depth and view known, so is how noisy keypoints and floor are
    rows = rows.with_precision(keypoint_precision(evidence, model, _scale(local), shared)[rows.person])
    uneven = np.hypot(FLOOR_SD_M, FLOOR_SLOPE_SD * np.exp(local[:, DEPTH]))
    rows = rows.with_floor(FLOOR_SD_M / uneven[rows.person])
    fit = solve(rows.taken(first), local, shared, prior, iterations=_MOST_ITERATIONS)
    off = misfit(fit, prior)
    if off > MOST_MISFIT:  # a camera that was moved, or another one: its place is worth as little as it is wrong
        prior = replace(prior, place=prior.place.widened(off))
        fit = solve(rows.taken(first), fit.local, fit.shared, prior, iterations=_MOST_ITERATIONS)
    fit = likeliest_camera(rows.taken(first), fit, prior, _MOST_ITERATIONS)
    if evidence.from_above.any() or evidence.too_level_rad:
        # seen from the camera as it is now, which the first steps may have had too level
        rows = rows.with_precision(keypoint_precision(evidence, model, _scale(fit.local), fit.shared)[rows.person])
        tilt = expected_tilt(evidence.too_level_rad, angle_from_above(fit.local, fit.shared))
        rows = rows.with_tilt(tilt[rows.person])
        fit = solve(rows.taken(first), fit.local, fit.shared, prior, iterations=_MOST_AGAIN)
    explanations, weight, first, fit = _weighed(rows, first, hypotheses, fit, prior)
    other_side = mirrored(rows.taken(first), fit)
    return Explained(usable, evidence, rows, explanations, weight, first, fit, other_side, on_floor, off)


def _types_of(
    evidence: Evidence, settings: LocateSettings, usable: NDArray[np.intp]
) -> list[tuple[Bodytype, ...]]:  # fmt: skip
    """Return the groups of bodies that each usable person may be of."""
    sizes = settings.body_sizes or (None,) * (int(usable.max()) + 1)
    statures = settings.statures or (None,) * len(sizes)
    return [
        with_stature(body_types(sizes[k] or settings.body_size, settings.child_weight, evidence.lengths), statures[k])
        for k in usable
    ]


def _first_steps(
    rows: HypothesisBatch, hypotheses: Hypotheses, first: NDArray[np.intp], shared: FloatArray, prior: SharedPrior
) -> tuple[Hypotheses, NDArray[np.intp], FloatArray]:
    """Return hypotheses two steps nearer to what they explain, each person's likeliest row then, and the camera.

    Floor and stated depths are held loosely, so that people who start off them still converge to them.
    """
    tried = np.flatnonzero(hypotheses.group == 0)
    loose, leading = rows.taken(tried).with_floor(_LOOSE).with_depth(_LOOSE), np.searchsorted(tried, first)
    near = gauss_newton_step(loose, hypotheses.local[tried], shared, prior, leading)
    near = gauss_newton_step(loose, near.local, near.shared, prior, leading)
    hypotheses = scaled_to_group(hypotheses.with_local(tried, near.local), first)
    rough = hypotheses.log_prior[tried] - near.row_cost
    best = _best_rows(loose.person, rough)
    first = tried[np.where(rough[best] > rough[leading] + _LIKELIER, best, leading)]
    return hypotheses, first, near.shared


def _weighed(
    rows: HypothesisBatch, first: NDArray[np.intp], hypotheses: Hypotheses, fit: Fit, prior: SharedPrior
) -> tuple[Explanations, FloatArray, NDArray[np.intp], Fit]:
    """Return all rows' explanations with their log weights, each person's likeliest row, and the fit of those.

    Where another row than the fit's is the likeliest, all is solved again, twice at most.
    """
    for _ in range(2):
        explanations, weight = _weigh(rows, first, hypotheses, fit)
        best = _best_rows(rows.person, weight)
        if (best == first).all():
            return explanations, weight, first, fit
        first = best
        fit = solve(rows.taken(first), explanations.local[first], fit.shared, prior, iterations=_MOST_AGAIN)
        hypotheses = replace(hypotheses, local=explanations.local)
    return *_weigh(rows, first, hypotheses, fit), first, fit


def _weigh(
    rows: HypothesisBatch, first: NDArray[np.intp], hypotheses: Hypotheses, fit: Fit
) -> tuple[Explanations, FloatArray]:
    """Explain every row with the camera that the other people determine; return also the log weight of each."""
    cavity = leave_one_out(fit)
    following = np.ones(len(rows), dtype=bool)
    following[first] = False
    rest = np.flatnonzero(following)
    explanations = best = at_fit(fit, cavity)
    if len(rest):
        begin, rest_cavity = np.tile(fit.shared, (len(rest), 1)), cavity.taken(rows.person[rest])
        refined = refine(rows.taken(rest), hypotheses.local[rest], begin, rest_cavity, steps=_ALTERNATIVE_STEPS)
        explanations = interleaved(first, best, rest, refined)
    return explanations, log_evidence(explanations, rows, hypotheses.log_prior)


def _best_rows(person: NDArray[np.intp], weight: FloatArray) -> NDArray[np.intp]:
    """Return each person's likeliest row."""
    order = np.lexsort((-weight, person))
    return order[np.searchsorted(person[order], np.arange(person[-1] + 1))]


def _scale(local: FloatArray) -> FloatArray:
    """Return each row's stature over depth."""
    return np.exp(local[:, LOG_LENGTHS.start] - local[:, DEPTH])
