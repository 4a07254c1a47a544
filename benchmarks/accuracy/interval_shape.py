"""Central or shortest intervals: how often 90 % intervals hold the distance of people side by side, anywhere, in line.

    python -m benchmarks.accuracy.interval_shape

Two people at 3-10 m with independent relative depth errors of 3, 6 and 10 % and 3 cm across, 2,000 pairs a row.
"""

import math

import numpy as np

from proxemetry import distances
from proxemetry.bodies import Bodies
from proxemetry.intervals import HIGH, LOW

PAIRS = 2000
ARRANGEMENTS = ("side by side", "anywhere", "in a row")


def true_gap(rng, arrangement):
    """Return where the second person stands from the first: right and ahead, metres."""
    if arrangement == "side by side":
        return np.array([rng.uniform(0.5, 1.5), rng.normal(0, 0.1)])
    turn = rng.uniform(0, 2 * math.pi) if arrangement == "anywhere" else math.pi / 2
    return rng.uniform(0.6, 5) * np.array([math.cos(turn), math.sin(turn)])


def main():
    """Print the table."""
    rng = np.random.default_rng(3)
    print(f"{'arrangement':14} {'depth error':>11}  central: cover  width   shortest: cover  width")
    for arrangement in ARRANGEMENTS:
        for relative in (0.03, 0.06, 0.10):
            results = np.array([one_pair(rng, arrangement, relative) for _ in range(PAIRS)]).mean(axis=0)
            print(
                f"{arrangement:14} {relative:11.0%}  {results[0]:14.1%} {results[1]:5.2f} m"
                f"   {results[2]:15.1%} {results[3]:5.2f} m"
            )


def one_pair(rng, arrangement, relative):
    """Return whether each interval covers, and how wide it is."""
    gap = true_gap(rng, arrangement)
    sd = np.array([0.03, 0.01, relative * rng.uniform(3, 10)])
    seen = np.array([[0, 0, 6], [gap[0], 0, 6 + gap[1]]]) + rng.standard_normal((2, 3)) * sd
    bodies = Bodies(seen, np.diag(np.tile(sd**2, 2)), "", ("a", "b"), (None, None), up=np.array([0, -1.0, 0]))
    answer = distances.measure_distances(bodies)
    draws = np.linalg.norm((seen[0] - seen[1] + rng.standard_normal((4000, 3)) * sd * math.sqrt(2))[:, ::2], axis=1)
    truth = np.linalg.norm(gap)
    rows = []
    for low, high in (np.quantile(draws, [LOW, HIGH]), (answer.low_m[0, 1], answer.high_m[0, 1])):
        rows += [low <= truth <= high, high - low]
    return rows


if __name__ == "__main__":
    main()
