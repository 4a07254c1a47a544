"""One camera from people of many photos: their fits together, one body a person however often they are seen.

Rows of one person share the lengths of one body. Each row answers for its place, heading and posture, each person for
the lengths, each view (a photo of a camera that is carried about, or all photos of one that stays) for pitch, roll and
height, and what is left determines the lens. So the interval counts people, not detections; and it holds what more
people do not even out (`departures`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...camera import Camera
from ...people import People
from .. import LocateSettings
from .batch import HypothesisBatch
from .body_model import BodyModel, body_model
from .camera_prior import SharedPrior
from .departures import departures_of
from .fit import explained_people, shared_prior
from .pooled_equations import N_LENGTHS, N_VIEW, OWN, Crowd, Equations, State, equations_of
from .projection import DEPTH, FOCAL, LOG_LENGTHS, N_LOCAL, N_SHARED
from .solver import clip_step, solve_batch

_ITERATIONS, _SETTLED = 30, 1e-4
_LONGEST_LENGTH_STEP = 0.1
#: What is known of a row's depth beforehand, as a precision: nothing, but the equations stay solvable.
_OPEN = 1e-6
#: A focal length that is less well known than this is sought.
_SOUGHT_SD = 0.1


@dataclass(frozen=True, eq=False)
class Pooled:
    """What the people of many photos show about their one camera.

    camera: what log focal length and principal point are relative to. shared: shape (N_SHARED,), of the first view.
    covariance: shape (N_SHARED, N_SHARED), if everyone is a different person; its first three rows are NaN where there
    is more than one view. by_bodies: the part of it that people's own bodies make, which are the same again where
    people recur. overdispersion: how much further people are off than the noise of their joints explains, as a factor
    on variances. cost: negative log posterior. n_people, n_detections: how many it rests on. by_view: shape (V, 2), how
    each view pulls at the log focal length there, and with what precision; places: shape (V, 3), each one's pitch, roll
    and log height.
    """

    camera: Camera
    shared: FloatArray
    covariance: FloatArray
    by_bodies: FloatArray
    overdispersion: float
    cost: float
    n_people: int
    n_detections: int
    by_view: FloatArray
    places: FloatArray

    def covariance_if_met(self, times: float) -> FloatArray:
        """Return the covariance where each person is there so many times, and it is not known who is who.

        The errors of one body add up at worst (Cauchy and Schwarz); noise and postures even out all the same.
        """
        return self.covariance + (times - 1.0) * self.by_bodies


def pooled(
    people: People, camera: Camera, persons: NDArray[np.intp], settings: LocateSettings,
    views: NDArray[np.intp] | None = None,
) -> Pooled | None:  # fmt: skip
    """Return the camera found from the people in many photos, or None where no one is usable.

    people: everyone in all photos, in undistorted pixels of `camera`. persons: shape (P,), who each of them is. views:
    shape (P,), the photo of each, where the camera moved; no one then counts as the same person in two photos.
    Without it the camera was in one place.
    """
    model, prior = body_model(people.skeleton), shared_prior(camera)
    carried = views is not None
    views = np.zeros(len(people), dtype=np.intp) if views is None else views
    found = _start(people, camera, persons, prior, settings, model, views)
    if found is None:
        return None
    crowd, state, resolution = found
    sought = camera.focal_rel_sd > _SOUGHT_SD
    state = _solved(crowd, state if sought else replace(state, tilt=np.zeros(2)), prior)
    departures = departures_of(state.tilted(crowd), state.local, state.cameras_of(crowd), model, resolution, sought)
    equations = equations_of(crowd, state, prior, departures)
    return _answer(camera, crowd, state, equations, prior, carried)


def _start(
    people: People, camera: Camera, persons: NDArray[np.intp], prior: SharedPrior, settings: LocateSettings,
    model: BodyModel, views: NDArray[np.intp],
) -> tuple[Crowd, State, float] | None:  # fmt: skip
    """Return where the search for one lens begins: each person's likeliest explanation, view by view.

    With it what a detector resolves, in units of the focal length.
    """
    batches: list[HypothesisBatch] = []
    local: list[FloatArray] = []
    cameras: list[FloatArray] = []
    whose: list[NDArray[np.intp]] = []
    resolution = too_level = 0.0
    for number in np.unique(views):
        mine = np.flatnonzero(views == number)
        explained = explained_people(people[mine], camera, prior, settings, model)
        if explained is not None:
            resolution, too_level = explained.evidence.resolution, explained.evidence.too_level_rad
            batches.append(explained.rows.taken(explained.first))
            local.append(explained.fit.local)
            cameras.append(explained.fit.shared)
            whose.append(persons[mine[explained.usable]])
    if not batches:
        return None
    rows, per_person, shared = HypothesisBatch.joined(batches), np.concatenate(local), np.array(cameras)
    view = np.repeat(np.arange(len(whose)), list(map(len, whose)))
    pairs = np.column_stack([view, np.concatenate(whose)])
    _, first, owner = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    owner, count = owner.reshape(-1), len(first)
    mean, precision = _bodies(rows, owner, count)
    rows = replace(rows, prior_precision=_without_repetition(rows.prior_precision))
    lengths = np.zeros((count, N_LENGTHS))
    np.add.at(lengths, owner, per_person[:, LOG_LENGTHS])
    lengths /= np.bincount(owner, minlength=count)[:, None]
    crowd = Crowd(rows, owner, view[first], mean, precision, too_level)
    lens = np.median(shared[:, N_VIEW:], axis=0)
    return crowd, State(per_person, lengths, shared[:, :N_VIEW], lens, np.zeros(0)), resolution


def _without_repetition(precision: FloatArray) -> FloatArray:
    """Return the rows' prior precision without what would count again with every row.

    That is a person's lengths, which are known once, and how far away people are photographed: a guess that hundreds
    of rows turned into a certainty, which drew cameras and their focal length towards the people.
    """
    free = precision.copy()
    free[:, LOG_LENGTHS, :] = free[:, :, LOG_LENGTHS] = 0.0
    free[:, DEPTH, DEPTH] = _OPEN
    return free


def _bodies(rows: HypothesisBatch, owner: NDArray[np.intp], count: int) -> tuple[FloatArray, FloatArray]:
    """Return each person's prior, mean (T, L) and precision (T, L, L): that of the kind of body, adult or child,
    that most of their rows look like."""
    statures = rows.prior_mean[:, LOG_LENGTHS.start]
    mean, precision = np.zeros((count, N_LENGTHS)), np.zeros((count, N_LENGTHS, N_LENGTHS))
    for person in range(count):
        mine = np.flatnonzero(owner == person)
        like = mine[np.argsort(statures[mine])[len(mine) // 2]]
        mean[person] = rows.prior_mean[like, LOG_LENGTHS]
        precision[person] = rows.prior_precision[like, LOG_LENGTHS, LOG_LENGTHS]
    return mean, precision


def _solved(crowd: Crowd, state: State, prior: SharedPrior) -> State:
    """Return the best state: each person's rows with one body, one lens for all views."""
    state = _with_lengths(crowd, state)
    for _ in range(_ITERATIONS):
        state, longest = _stepped(crowd, state, equations_of(crowd, state, prior))
        if longest < _SETTLED:
            break
    return state


def _with_lengths(crowd: Crowd, state: State) -> State:
    local = state.local.copy()
    local[:, LOG_LENGTHS] = state.lengths[crowd.person]
    return replace(state, local=local)


def _stepped(crowd: Crowd, state: State, equations: Equations) -> tuple[State, float]:
    """Return the state after a step of everything, no longer than the model's linearity carries, and its length."""
    every_lens = np.tile(solve_batch(equations.lens[:, :-1], equations.lens[:, -1]), (len(state.places), 1))
    shared = np.concatenate([equations.views.step(every_lens), every_lens], axis=1)
    _, cameras = clip_step(np.zeros((1, N_LOCAL)), shared[:, :N_SHARED])
    shared[:, :N_SHARED] = cameras
    above = shared[crowd.view]
    longer = equations.people.step(above)
    lengths = np.clip(longer, -_LONGEST_LENGTH_STEP, _LONGEST_LENGTH_STEP)
    moved = np.zeros_like(state.local)
    moved[:, OWN] = equations.rows.step(np.concatenate([lengths, above], axis=1)[crowd.person])
    moved, _ = clip_step(moved, np.zeros(N_SHARED))
    after = State(
        state.local + moved, state.lengths + lengths, state.places + cameras[:, :N_VIEW],
        state.lens + cameras[0, N_VIEW:], state.tilt + shared[0, N_SHARED:],
    )  # fmt: skip
    return _with_lengths(crowd, after), float(max(np.abs(cameras).max(), np.abs(longer).max() / 10))


def _answer(
    camera: Camera, crowd: Crowd, state: State, equations: Equations, prior: SharedPrior, carried: bool
) -> Pooled:
    """Return the camera with its covariance: of what people say, of how far they disagree, and of departures."""
    people = equations.people
    if carried:
        hessian, data = equations.lens, equations.views.left.sum(axis=0)
        # what a view makes of what its people say: its own pitch, roll and height answer first
        answer = equations.views.response[crowd.view]
        left = people.left[:, N_VIEW:] - np.swapaxes(answer, 1, 2) @ people.left[:, :N_VIEW]
        sensitivity = people.response[..., N_VIEW:] - people.response[..., :N_VIEW] @ answer
        groups, asked = crowd.view, np.array([0])
    else:
        data = equations.by_view[0]
        hessian = data.copy()
        hessian[:N_SHARED, :N_SHARED] += prior.cost(state.cameras(np.zeros(1, dtype=np.intp)))[1][0, :, :-1]
        hessian[N_SHARED:, N_SHARED : len(data)] += np.eye(len(state.tilt))
        left, sensitivity = people.left, people.response
        groups, asked = np.arange(len(crowd.view)), np.arange(FOCAL + 1)
    count = len(data)
    inverse = np.asarray(np.linalg.inv(hessian[:, :count]), dtype=float)
    by_bodies = inverse @ np.einsum("tla,tlm,tmb->ab", sensitivity, crowd.precision, sensitivity) @ inverse
    by_data = inverse @ data[:, :count] @ inverse
    pulls = np.zeros((int(groups.max()) + 1, count))
    np.add.at(pulls, groups, left[..., -1 - _n_departures(data)])
    excess = _overdispersion(inverse @ pulls.T, np.diag(by_data), asked)
    shifts = inverse @ data[:, count + 1 :]
    covariance = inverse + (excess - 1) * by_data + shifts @ shifts.T
    size = len(data) - len(state.tilt)
    covariance, by_bodies = covariance[:size, :size], by_bodies[:size, :size]
    if carried:
        covariance, by_bodies = (_beside_open_places(part) for part in (covariance, by_bodies))
    shared = np.append(state.places[0], state.lens)
    by_view = equations.views.left[:, 0, [equations.views.left.shape[1], 0]]  # the gradient stands after the unknowns
    return Pooled(
        camera, shared, covariance, by_bodies, excess, equations.cost, len(state.lengths), len(crowd.rows), by_view,
        state.places,
    )  # fmt: skip


def _n_departures(normal: FloatArray) -> int:
    return normal.shape[1] - normal.shape[0] - 1


def _overdispersion(pulls: FloatArray, stated: FloatArray, asked: NDArray[np.intp]) -> float:
    """Return how many times further people are off than the noise of their joints explains, as a factor on variances.

    pulls: shape (n, G), how each group, a person or a photo, pulls at the camera; stated: shape (n,), the variances of
    their sum. White's estimate of these, averaged over the unknowns `asked`; 1 where groups are too few to tell.
    """
    unknown = stated > 1e-9
    asked = asked[unknown[asked]]
    groups = pulls.shape[1]
    if groups < 3 * len(asked) or not len(asked):
        return 1.0
    found = (pulls[asked] ** 2).sum(axis=1) * groups / (groups - 1)
    return float(max(1.0, np.mean(found / stated[asked])))


def _beside_open_places(lens: FloatArray) -> FloatArray:
    whole = np.full((N_SHARED, N_SHARED), np.nan)
    whole[N_VIEW:, N_VIEW:] = lens
    return whole
