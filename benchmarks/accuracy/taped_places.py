"""Places from simulated tape measurements of KORTE's outdoor shoot: errors, intervals, and whether blunders are found.

python -m benchmarks.accuracy.taped_places --count 20
"""

from __future__ import annotations

import argparse
import itertools
import math

import numpy as np

from proxemetry.annotate.places import Tape, solve
from proxemetry.intervals import HALF_WIDTH_SD

#: Where people and cameras were in KORTE's outdoor shoot, metres (Seker et al. 2021, figure 2; the label files).
PLACES = {
    "C0": (0.0, 0.0), "C1": (-0.6, 12.0), "C2": (9.2, 4.1), "P0": (-1.2, 1.2), "P1": (0.0, 2.4), "P2": (-1.2, 4.8),
    "P3": (-1.8, 6.0), "P4": (-2.4, 6.0), "P5": (-3.0, 4.8),
}  # fmt: skip
PAIRS = list(itertools.combinations(PLACES, 2))
#: The standard deviation of each tape, metres.
TAPE_SD_M = 0.01


def taping(n_tapes: int, slip_m: float, random: np.random.Generator) -> tuple[list[Tape], Tape | None]:
    """Return some tapes with their noise, and the one of them that was misread by `slip_m`."""
    kept = [PAIRS[k] for k in random.permutation(len(PAIRS))[:n_tapes]]
    tapes = [Tape(a, b, math.dist(PLACES[a], PLACES[b]) + random.normal(0, TAPE_SD_M)) for a, b in kept]
    if not slip_m:
        return tapes, None
    wrong = int(random.integers(n_tapes))
    sign = 1 if tapes[wrong].metres < 2 * slip_m or random.random() < 0.5 else -1
    tapes[wrong] = Tape(tapes[wrong].a, tapes[wrong].b, tapes[wrong].metres + sign * slip_m)
    return tapes, tapes[wrong]


def row(n_tapes: int, slip_m: float, count: int) -> list[str]:
    """Return one line of the table: what `count` tapings of a kind come to."""
    random = np.random.default_rng(1000 * n_tapes + round(10 * slip_m))
    errors: list[float] = []
    inside: list[bool] = []
    named = among = missed = accused = without = 0
    for _ in range(count):
        tapes, wrong = taping(n_tapes, slip_m, random)
        found = solve(list(PLACES), tapes, [])
        without += sum(reason is not None for reason in found.reasons)
        suspects = [] if found.contradiction is None else [s.measurement for s in found.contradiction.suspects]
        if wrong is None:
            accused += bool(suspects)
        else:
            named += suspects == [wrong]
            among += len(suspects) > 1 and wrong in suspects
            missed += not suspects
            accused += bool(suspects) and wrong not in suspects
        for (i, a), (j, b) in itertools.combinations(enumerate(found.tags), 2):
            if math.isfinite(found.distance_m[i, j]):
                errors.append(abs(float(found.distance_m[i, j]) - math.dist(PLACES[a], PLACES[b])))
                inside.append(errors[-1] <= HALF_WIDTH_SD * float(found.distance_sd_m[i, j]))
    of_slips = [named, among, accused, missed] if slip_m else [None, None, accused, None]
    return [
        f"{n_tapes} of {len(PAIRS)}", f"{slip_m:g} m" if slip_m else "none", f"{without / count:.1f}",
        f"{100 * float(np.median(errors)):.1f} cm", f"{100 * float(np.mean(inside)):.0f} %",
        *("" if n is None else f"{100 * n / count:.0f} %" for n in of_slips),
    ]  # fmt: skip


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=20, help="simulated measurements for each row")
    count = parser.parse_args().count
    heads = (
        "tapes", "slip", "marks without a place", "median error", "in 90 %", "slip named", "among several",
        "others accused", "missed",
    )  # fmt: skip
    print("| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    for n_tapes, slip_m in itertools.product((36, 27, 21), (0.0, 0.1, 0.3, 1.0)):
        print("| " + " | ".join(row(n_tapes, slip_m, count)) + " |", flush=True)


if __name__ == "__main__":
    main()
