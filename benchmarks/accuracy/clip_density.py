"""Densities along trajectories, ours and those of PedPy (https://pedpy.readthedocs.io), which must be installed.

    python -m benchmarks.accuracy.clip_density OBSMAT [--every 5]

OBSMAT is a scene's `obsmat.txt` (frame, id, x, z, y; metres). The floor is the convex hull of all places with a margin
of half a metre, the region a square of 6 m in its middle.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from proxemetry.clip.density import Region, classic_density, voronoi_density


def main() -> None:
    """Print the mean of both densities by both programs, and the largest difference of a frame."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("obsmat", type=Path)
    parser.add_argument("--every", type=int, default=5, help="take every n-th frame")
    args = parser.parse_args()
    rows = np.loadtxt(args.obsmat)[:, [1, 0, 2, 4]]
    frames = np.unique(rows[:, 1])[:: args.every]
    rows = rows[np.isin(rows[:, 1], frames)]
    rows[:, 1] = np.searchsorted(frames, rows[:, 1])
    floor = Region.around(rows[:, 2:])
    middle = (rows[:, 2:].max(axis=0) + rows[:, 2:].min(axis=0)) / 2
    region = Region(middle + np.array([[-3.0, -3], [3, -3], [3, 3], [-3, 3]]))
    there = [rows[rows[:, 1] == k, 2:] for k in range(len(frames))]
    ours = np.array([(classic_density(p, region), voronoi_density(p, region, floor)) for p in there])
    theirs = _pedpy(rows, floor, region, len(frames))
    for k, name in enumerate(("classic", "Voronoi")):
        a, b = ours[:, k].mean(), theirs[:, k].mean()
        print(f"{name}: {a:.5f} against {b:.5f} persons/m2 ({100 * (a / b - 1):+.3f} %), "
              f"largest difference of a frame {np.abs(ours[:, k] - theirs[:, k]).max():.5f}")  # fmt: skip


def _pedpy(rows: np.ndarray, floor: Region, region: Region, count: int) -> np.ndarray:
    """Return PedPy's classic and Voronoi density of each frame, shape (F, 2)."""
    import pandas
    import pedpy

    table = pandas.DataFrame(
        {"id": rows[:, 0].astype(int), "frame": rows[:, 1].astype(int), "x": rows[:, 2], "y": rows[:, 3]}
    )
    trajectory = pedpy.TrajectoryData(table, frame_rate=2.5)
    walkable = pedpy.WalkableArea([tuple(c) for c in floor.corners_m])
    area = pedpy.MeasurementArea([tuple(c) for c in region.corners_m])
    classic = pedpy.compute_classic_density(traj_data=trajectory, measurement_area=area)
    cells = pedpy.compute_individual_voronoi_polygons(traj_data=trajectory, walkable_area=walkable)
    voronoi = pedpy.compute_voronoi_density(individual_voronoi_data=cells, measurement_area=area)[0]
    answer = np.zeros((count, 2))
    for k, found in enumerate((classic, voronoi)):
        found = found.reset_index()
        answer[found["frame"].to_numpy(dtype=int), k] = found["density"].to_numpy()
    return answer


if __name__ == "__main__":
    main()
