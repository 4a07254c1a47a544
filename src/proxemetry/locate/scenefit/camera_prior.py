"""The prior of the camera: what is assumed or stated of its place, and of its intrinsics."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from .projection import FOCAL, HEIGHT, N_SHARED, PITCH

#: Degrees of freedom of Student's distribution (docs/method.md, "Priors"): what is assumed of the camera has heavy
#: tails.
_SHARED_DOF = 3.0
#: What is stated of the camera's place is believed as stated near its mean; its tails are heavy.
_PLACE_DOF = 4.0


@dataclass(frozen=True, eq=False)
class Place:
    """What is stated or was measured of the camera: some of the shared unknowns, known together.

    which: shape (k,), of the shared unknowns. mean: shape (k,). precision: shape (k, k).
    """

    which: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    mean: FloatArray = field(default_factory=lambda: np.zeros(0))
    precision: FloatArray = field(default_factory=lambda: np.zeros((0, 0)))

    def __len__(self) -> int:
        return len(self.which)

    @property
    def covariance(self) -> FloatArray:
        """The inverse of the precision."""
        return np.asarray(np.linalg.inv(self.precision), dtype=float)

    def widened(self, factor: float) -> Place:
        """Return the place with every standard deviation multiplied."""
        return replace(self, precision=self.precision / factor**2)


@dataclass(frozen=True)
class Raised:
    """Cameras that hang or are held high and look down, beside those at eye level: pitch and height go together.

    share: how many are so. mean, sd: of pitch in radians and of the log height in metres, Student-t.
    """

    share: float
    mean: tuple[float, float]
    sd: tuple[float, float]


@dataclass(frozen=True, eq=False)
class SharedPrior:
    """The prior of the camera.

    mean, sd: shape (N_SHARED,), of what is known of each unknown alone, Student-t but for focal and principal; sd is
    infinite where the place alone determines it. place: what is known of several together, Student-t. raised: pitch and
    height of some cameras are these instead.
    """

    mean: FloatArray
    sd: FloatArray
    place: Place = field(default_factory=Place)
    raised: Raised | None = None

    def cost(self, shared: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the negative log density of estimates (..., N_SHARED), up to a constant, and its normal equations.

        Their shape is (..., N_SHARED, N_SHARED + 1): hessians and, last, the downhill gradient.
        """
        away = self.mean - shared
        z2 = (away / self.sd) ** 2
        off = 1 + z2[..., :FOCAL] / _SHARED_DOF
        precision = np.broadcast_to(self.sd**-2, shared.shape).copy()
        precision[..., :FOCAL] *= (1 + 1 / _SHARED_DOF) / off
        normal = np.concatenate([precision[..., None] * np.eye(N_SHARED), (precision * away)[..., None]], axis=-1)
        cost = (_SHARED_DOF + 1) / 2 * np.log(off).sum(axis=-1) + 0.5 * z2[..., FOCAL:].sum(axis=-1)
        if self.raised is not None:
            cost = cost + _mixed_in(self.raised, self.sd, shared, off, normal)
        return (cost, normal) if not len(self.place) else self._with_place(shared, cost, normal)

    def _with_place(self, shared: FloatArray, cost: FloatArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
        which, dof = self.place.which, _PLACE_DOF + len(self.place)
        away = self.place.mean - shared[..., which]
        pull = (self.place.precision @ away[..., None])[..., 0]
        off = 1 + (away * pull).sum(axis=-1) / dof
        normal[..., which[:, None], which] += self.place.precision / off[..., None, None]
        normal[..., which, -1] += pull / off[..., None]
        return cost + dof / 2 * np.log(off), normal

    @property
    def marginal_mean(self) -> FloatArray:
        """What each unknown is expected to be, shape (N_SHARED,)."""
        mean = self.mean.copy()
        mean[self.place.which] = self.place.mean
        return mean

    @property
    def marginal_sd(self) -> FloatArray:
        """How far each may be from that, shape (N_SHARED,)."""
        sd = self.sd.copy()
        sd[self.place.which] = np.sqrt(np.diag(self.place.covariance))
        return sd


def _mixed_in(raised: Raised, sd: FloatArray, shared: FloatArray, off: FloatArray, normal: FloatArray) -> FloatArray:
    """Return what raised cameras take from the cost; write their normal equations into those of eye level's.

    off: shape (..., FOCAL), one plus the squared deviations from eye level over the degrees of freedom. Each kind's
    equations count by how likely the camera is of it.
    """
    open_ = [(k, m, s) for k, m, s in zip((PITCH, HEIGHT), raised.mean, raised.sd, strict=True) if np.isfinite(sd[k])]
    which = np.array([k for k, _, _ in open_], dtype=np.intp)
    own_mean, own_sd = (np.array([part[n] for part in open_]) for n in (1, 2))
    away = own_mean - shared[..., which]
    own_off = 1 + (away / own_sd) ** 2 / _SHARED_DOF
    likelier = (_SHARED_DOF + 1) / 2 * np.log(off[..., which] / own_off) + np.log(sd[which] / own_sd)
    odds = np.log(raised.share / (1 - raised.share)) + likelier.sum(axis=-1)
    part = np.exp(-np.logaddexp(0.0, -odds))[..., None]
    precision = (1 + 1 / _SHARED_DOF) / own_off * own_sd**-2
    for column, mixed in ((which, precision), (-1, precision * away)):
        normal[..., which, column] += part * (mixed - normal[..., which, column])
    return -np.logaddexp(0.0, odds)
