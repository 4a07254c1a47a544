"""Is the Gaussian at the best explanation good enough? The joint fit beside Hamiltonian sampling of its own posterior.

    python -m benchmarks.accuracy.sampling --labels DIR [--every 4] [--samples 150]

Both see the same photos (`measured_layouts`) and the same model. Sampling starts at the fit's answer, with its
covariance as the metric, and stays among the explanations near it; the fit's answer is also shown with its other modes.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from proxemetry import distances
from proxemetry.arrays import FloatArray
from proxemetry.bodies import Bodies
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit.batch import HypothesisBatch
from proxemetry.locate.scenefit.body_model import body_model
from proxemetry.locate.scenefit.camera_prior import SharedPrior
from proxemetry.locate.scenefit.explained import Explained
from proxemetry.locate.scenefit.fit import explained_people, shared_prior
from proxemetry.locate.scenefit.posterior import placed_people
from proxemetry.locate.scenefit.projection import N_LOCAL, N_SHARED, camera_axes, torso_position
from proxemetry.locate.scenefit.solver import Fit, evaluate
from synthetic.layouts import photos
from synthetic.scenes import SyntheticPhoto

SEED = 3000
_STEPS, _STEP, _BURN_IN = 10, 0.22, 30


def fitted(photo: SyntheticPhoto) -> tuple[Bodies, Explained, SharedPrior] | None:
    """Run the joint fit; return also its explanations and the camera's prior. None where nobody is detected."""
    prior, model = shared_prior(photo.camera), body_model(photo.people.skeleton)
    explained = explained_people(photo.people, photo.camera, prior, LocateSettings(), model)
    if explained is None:
        return None
    return placed_people(explained, model).bodies(len(photo.people), explained.usable, "unusable"), explained, prior


class Posterior:
    """The negative log posterior of all unknowns as one vector, in coordinates where the fit's covariance is one."""

    def __init__(self, rows: HypothesisBatch, fit: Fit, prior: SharedPrior) -> None:
        """Take the rows of the best explanations and the fit of them."""
        self.rows, self.prior, self.count = rows, prior, len(rows)
        self.centre = np.concatenate([fit.local.ravel(), fit.shared])
        precision = np.zeros((len(self.centre), len(self.centre)))
        tail = slice(self.count * N_LOCAL, None)
        for k, block in enumerate(fit.hessian):
            own = slice(k * N_LOCAL, (k + 1) * N_LOCAL)
            precision[own, own] = block[:N_LOCAL, :N_LOCAL]
            precision[own, tail] = block[:N_LOCAL, N_LOCAL:]
            precision[tail, own] = block[N_LOCAL:, :N_LOCAL]
            precision[tail, tail] += block[N_LOCAL:, N_LOCAL:]
        precision[tail, tail] += fit.shared_normal[:, :-1]
        self.root = np.linalg.inv(np.linalg.cholesky(precision)).T

    def unknowns(self, y: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return local (R, N_LOCAL) and shared (N_SHARED,) at a point."""
        x = self.centre + self.root @ y
        return x[:-N_SHARED].reshape(self.count, N_LOCAL), x[-N_SHARED:]

    def __call__(self, y: FloatArray) -> tuple[float, FloatArray]:
        """Return the cost and its gradient."""
        fit = evaluate(self.rows, *self.unknowns(y), self.prior)
        shared = fit.gradient[:, N_LOCAL:].sum(axis=0) + fit.shared_normal[:, -1]
        downhill = np.concatenate([fit.gradient[:, :N_LOCAL].ravel(), shared])
        return fit.cost, -self.root.T @ downhill

    def sample(self, rng: np.random.Generator, count: int) -> tuple[list[FloatArray], float]:
        """Return points drawn by Hamiltonian Monte Carlo, and the share of proposals accepted."""
        y = np.zeros(len(self.centre))
        cost, gradient = self(y)
        points: list[FloatArray] = []
        accepted = 0
        for number in range(count + _BURN_IN):
            momentum = rng.standard_normal(len(y))
            there, slope, energy = y.copy(), gradient, cost + momentum @ momentum / 2
            step = _STEP * rng.uniform(0.8, 1.2)
            for _ in range(_STEPS):
                momentum = momentum - step / 2 * slope
                there = there + step * momentum
                new_cost, slope = self(there)
                momentum = momentum - step / 2 * slope
            if np.log(rng.random()) < energy - new_cost - momentum @ momentum / 2:
                y, cost, gradient = there, new_cost, slope
                accepted += 1
            if number >= _BURN_IN:
                points.append(y)
        return points, accepted / (count + _BURN_IN)


@dataclass
class Tally:
    """Relative errors, whether intervals held, and their relative widths, pair by pair."""

    error: list[float] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    width: list[float] = field(default_factory=list)

    def add(self, truth: float, answer: float, low: float, high: float) -> None:
        """Count a pair."""
        self.error.append(answer / truth - 1)
        self.inside.append(low <= truth <= high)
        self.width.append((high - low) / answer)

    def line(self) -> str:
        """Return the figures in percent."""
        error = 100 * np.array(self.error)
        return (f"{len(error):6d}{np.abs(error).mean():8.1f}{np.median(np.abs(error)):8.1f}{error.mean():+8.1f}"
                f"{100 * np.mean(self.inside):8.1f}{100 * np.median(self.width):8.0f}")  # fmt: skip


def sampled_lengths(posterior: Posterior, points: list[FloatArray]) -> FloatArray:
    """Return the drawn distances on the ground (P, P, draws)."""
    lengths: list[FloatArray] = []
    for point in points:
        local, shared = posterior.unknowns(point)
        up = -camera_axes(shared[None, :2])[0, :, 1]
        ground = torso_position(local, shared) @ distances.ground_frame(up)[:2].T
        lengths.append(np.linalg.norm(ground[:, None] - ground[None], axis=-1))
    return np.stack(lengths, axis=-1)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--labels", type=Path, required=True)
    parser.add_argument("--every", type=int, default=4, help="take every n-th photo")
    parser.add_argument("--samples", type=int, default=150)
    args = parser.parse_args()
    rng = np.random.default_rng(0)
    tallies = {"fit": Tally(), "fit, best mode alone": Tally(), "sampled": Tally()}
    spent, rates = {"fit": 0.0, "sampled": 0.0}, []
    for photo in list(photos(args.labels, SEED))[:: args.every]:
        begin = time.process_time()
        answer = fitted(photo)
        spent["fit"] += time.process_time() - begin
        if answer is None or len(answer[1].first) < len(photo.people):
            continue
        bodies, explained, prior = answer
        begin = time.process_time()
        posterior = Posterior(explained.rows.taken(explained.first), explained.fit, prior)
        points, rate = posterior.sample(rng, args.samples)
        spent["sampled"] += time.process_time() - begin
        rates.append(rate)
        lengths, even = sampled_lengths(posterior, points), np.full((1, len(points)), 1 / len(points))
        with_modes = distances.measure_distances(bodies)
        alone = distances.measure_distances(replace(bodies, modes=()))
        for i, owner in enumerate(photo.owners):
            for j in range(i):
                if owner == photo.owners[j] or not np.isfinite(with_modes.distance_m[i, j]):
                    continue
                truth = float(photo.distances_m[owner, photo.owners[j]])
                for name, d in (("fit", with_modes), ("fit, best mode alone", alone)):
                    tallies[name].add(truth, d.distance_m[i, j], d.low_m[i, j], d.high_m[i, j])
                drawn = np.sort(lengths[i, j])[None]
                low, high = distances.shortest_intervals(drawn, even)
                tallies["sampled"].add(truth, float(distances.least_error(drawn, even)[0]), low[0], high[0])
    print(f"{'':22s}{'pairs':>6s}{'mean %':>8s}{'median':>8s}{'bias %':>8s}{'in 90 %':>8s}{'width %':>8s}")
    for name, tally in tallies.items():
        print(f"{name:22s}{tally.line()}")
    print(f"accepted {100 * np.mean(rates):.0f} % of proposals; sampling cost {spent['sampled'] / spent['fit']:.0f} "
          "times the fit")  # fmt: skip


if __name__ == "__main__":
    main()
