"""Detection of groups on trajectories with annotated groups; each scene is held out in turn.

    python -m benchmarks.accuracy.clip_groups DATA [--fit]

DATA is a folder of scenes, each with `obsmat.txt` (frame, id, x, z, y, ...; metres, 2.5 frames a second) and
`groups.txt` (the ids of one group a line), as the data sets ETH (Pellegrini et al. 2009) and UCY (Lerner et al. 2007)
are kept by OpenTraj. `--fit` prints the model fitted to all scenes, as `clip/groups.py` holds it.
"""

from __future__ import annotations

import argparse
import itertools
from pathlib import Path

import numpy as np

from proxemetry.clip.groups import Model, adjusted, features, groups_of, predicted, together
from proxemetry.clip.sightings import Chain, Sightings
from proxemetry.clip.smoothing import smooth

STEP_S = 0.4
#: Annotated positions are good to a tenth of a metre.
SD_M = 0.1
_RIDGE = 0.1


def paths_of(scene: Path):
    """Return the smoothed paths of a scene, and the pairs of ids that are annotated as together."""
    rows = np.loadtxt(scene / "obsmat.txt")
    frames = rows[:, 0].astype(int)
    step = int(np.median(np.diff(np.unique(frames))))
    number = (frames - frames.min()) // step
    times = np.arange(number.max() + 1) * STEP_S
    ids = rows[:, 1].astype(int)
    order = np.lexsort((ids, number))
    starts = np.searchsorted(number[order], np.arange(len(times) + 1))
    shot = [
        Sightings.of_places(times[k], rows[order[starts[k] : starts[k + 1]]][:, [2, 4]], SD_M)
        for k in range(len(times))
    ]
    place = np.empty(len(rows), dtype=int)
    place[order] = np.arange(len(rows)) - starts[number[order]]
    paths = []
    for person in np.unique(ids):
        mine = np.flatnonzero(ids == person)
        mine = mine[np.argsort(number[mine])]
        paths.append(smooth(Chain(number[mine], place[mine]), shot, times, int(person)))
    pairs = set()
    for line in (scene / "groups.txt").read_text().splitlines():
        pairs |= {tuple(sorted(p)) for p in itertools.combinations(map(int, line.split()), 2)}
    return paths, pairs


def described(paths):
    """Return the pairs that are ever near, and their features."""
    pairs, rows = [], []
    for a, b in itertools.combinations(paths, 2):
        shared = together(a, b)
        found = None if shared is None else features(shared)
        if found is not None:
            pairs.append((a.number, b.number))
            rows.append(found)
    return pairs, np.array(rows)


def fitted(rows, labels) -> Model:
    """Return the logistic regression of labels on standardised features, with a slight ridge."""
    mean, sd = rows.mean(axis=0), rows.std(axis=0)
    design = np.c_[np.ones(len(rows)), (rows - mean) / sd]
    ridge = np.diag(np.r_[0.0, np.full(rows.shape[1], _RIDGE)])
    weights = np.zeros(design.shape[1])
    for _ in range(50):
        p = 1 / (1 + np.exp(-design @ weights))
        hessian = (design * (p * (1 - p) + 1e-9)[:, None]).T @ design + ridge
        weights = weights + np.linalg.solve(hessian, design.T @ (labels - p) - ridge @ weights)
    return Model(tuple(mean), tuple(sd), tuple(weights), float(labels.mean()))


def main() -> None:
    """Print pair precision, recall and F1 a scene, held out, and pooled."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("data", type=Path)
    parser.add_argument("--fit", action="store_true", help="print the model fitted to all scenes")
    args = parser.parse_args()
    scenes = sorted(p.parent for p in args.data.glob("*/groups.txt"))
    known = {}
    for scene in scenes:
        paths, truth = paths_of(scene)
        pairs, rows = described(paths)
        labels = np.array([tuple(sorted(p)) in truth for p in pairs])
        known[scene.name] = (paths, truth, pairs, rows, labels)
    print("| scene held out | pairs annotated | found | right | precision | recall | F1 | F1 of groups' pairs |")
    print("|---|---|---|---|---|---|---|---|")
    total = np.zeros(4)
    for name, (paths, truth, pairs, rows, _) in known.items():
        others = [v for k, v in known.items() if k != name]
        model = fitted(np.concatenate([v[3] for v in others]), np.concatenate([v[4] for v in others]))
        p = adjusted(predicted(rows, model), model.rate)
        found = {tuple(sorted(k)) for k, v in zip(pairs, p, strict=True) if v > 0.5}
        clusters = groups_of([x.number for x in paths], dict(zip(pairs, p, strict=True)))
        linked = {c for g in clusters for c in itertools.combinations(g, 2)}
        counts = np.array([len(truth), len(found), len(found & truth), len(linked & truth)])
        total += counts
        print(_line(name, counts, len(linked)))
    print(_line("pooled", total, None))
    if args.fit:
        rows = np.concatenate([v[3] for v in known.values()])
        labels = np.concatenate([v[4] for v in known.values()])
        model = fitted(rows, labels)
        print(f"{len(labels)} pairs, {labels.sum()} of them companions")
        for field in ("mean", "sd", "weights"):
            print(f"    {field}=({', '.join(f'{v:.4f}' for v in getattr(model, field))}),")
        print(f"    rate={model.rate:.4f},")


def _line(name, counts, linked) -> str:
    truth, found, right, in_groups = counts
    group_f1 = "" if linked is None else f"{2 * in_groups / (linked + truth):.3f}"
    return (
        f"| {name} | {truth:.0f} | {found:.0f} | {right:.0f} | {right / found:.2f} | {right / truth:.2f} "
        f"| {2 * right / (found + truth):.3f} | {group_f1} |"
    )


if __name__ == "__main__":
    main()
