"""Depth against lidar on street photos, for every method and every pose back end at hand.

    python -m benchmarks.accuracy.street --data DIR [--pose yolox-tinypose,blazepose] [--methods torso,combined,scene]

DIR holds photos of a car's cameras with two files of truth in the camera frame: nuscenes_mini_pedestrians.json and
kitti_000000_pedestrian.json. The cameras are known exactly. The true boxes enclose the projected boxes in space:
they are wider than the person and ignore what hides them. A person counts as found where most of a result's box lies in
the true box and it is at least 40 % as tall; of several, the one nearest to its middle. Everyone found enters the
errors, whatever their distance.

The truth files are checked first: the boxes in space, projected, must fall onto the boxes in the photo.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.locate import METHODS
from proxemetry.measure import place
from proxemetry.overlap import areas_of, shared_areas
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named
from proxemetry.settings import Settings

_LEAST_INSIDE, _LEAST_TALL = 0.7, 0.4
_BANDS_M = ((0, 10), (10, 20), (20, 40), (0, 40))
_TO_90 = 1.645
#: Of a person's height on the photo: how far a projected box may miss the labelled one, on the median.
_MOST_MISS = 0.05


@dataclass(frozen=True, eq=False)
class Street:
    """One photo with its camera and the people in it.

    boxes_px: shape (N, 4). middles_m: the middles of their boxes in space, camera frame, shape (N, 3). heights_m: (N,).
    """

    path: Path
    camera: Camera
    boxes_px: FloatArray
    middles_m: FloatArray
    heights_m: FloatArray


def read_streets(folder: Path) -> list[Street]:
    """Read both truth files of a folder; raises FileNotFoundError where one is absent."""
    streets = list(_nuscenes(folder, json.loads((folder / "nuscenes_mini_pedestrians.json").read_text())))
    streets.append(_kitti(folder, json.loads((folder / "kitti_000000_pedestrian.json").read_text())))
    return [street for street in streets if len(street.boxes_px)]


def _camera(matrix: Sequence[Sequence[float]], photo: Photo) -> Camera:
    return Camera(matrix[0][0], matrix[1][1], matrix[0][2], matrix[1][2], photo.width, photo.height)


def _nuscenes(folder: Path, table: Mapping[str, Mapping[str, Mapping[str, object]]]) -> Iterator[Street]:
    for name, row in table["images"].items():
        people: Sequence[Mapping[str, Sequence[float]]] = row["pedestrians"]  # type: ignore[assignment]
        # x, y, z, length, height, width, yaw; `check` shows that x, y, z are the box's middle, not its bottom
        spatial = np.array([p["bbox_3d_cam"] for p in people], dtype=float).reshape(-1, 7)
        boxes = np.array([p["bbox"] for p in people], dtype=float).reshape(-1, 4)
        camera = _camera(row["K"], Photo.open(folder / name))  # type: ignore[arg-type]
        yield Street(folder / name, camera, boxes, spatial[:, :3], spatial[:, 4])


def _kitti(folder: Path, row: Mapping[str, object]) -> Street:
    matrix = np.array(row["P2"], dtype=float)
    person: Mapping[str, Sequence[float]] = row["pedestrian"]  # type: ignore[assignment]
    # positions are of the left grey camera; the colour camera's own frame is shifted by what P2 says
    shift = np.linalg.solve(matrix[:3, :3], matrix[:3, 3])
    bottom, height = np.array(person["xyz_bottom_cam"]) + shift, person["lhw"][1]
    middle = bottom - (0, height / 2, 0)
    camera = _camera(matrix[:3, :3].tolist(), Photo.open(folder / str(row["file"])))
    box = np.array([person["bbox"]], dtype=float)
    return Street(folder / str(row["file"]), camera, box, middle[None], np.array([height]))


def check(streets: Sequence[Street]) -> str:
    """Return one line on how well the boxes in space fall onto those in the photos; raises ValueError where badly."""
    as_middle, as_bottom = [], []
    for street in streets:
        tall = street.boxes_px[:, 3] - street.boxes_px[:, 1]
        half = np.stack([np.zeros(len(tall)), street.heights_m / 2, np.zeros(len(tall))], axis=1)
        labelled = (street.boxes_px[:, 1] + street.boxes_px[:, 3]) / 2
        for found, shift in ((as_middle, 0), (as_bottom, 1)):
            projected = street.camera.project(street.middles_m - shift * half)[:, 1]
            found.extend(np.abs(projected - labelled) / tall)
    miss, other = float(np.median(as_middle)), float(np.median(as_bottom))
    if miss > _MOST_MISS:
        raise ValueError(f"projected boxes miss the labelled ones by {miss:.0%} of a person's height")
    return f"truth: {len(as_middle)} people; projected middles miss by {miss:.1%} of a height (as bottoms: {other:.0%})"


def found_rows(people: People, street: Street) -> list[tuple[int, int]]:
    """Return pairs of (row of people, row of truth), one to one, nearest middles first."""
    boxes, truth = people.boxes_px, street.boxes_px
    tall, heights = truth[:, 3] - truth[:, 1], boxes[:, 3] - boxes[:, 1]
    inside = shared_areas(boxes, truth) >= _LEAST_INSIDE * areas_of(boxes)[:, None]
    middles, true_middles = boxes[:, [0, 2]].mean(axis=1), truth[:, [0, 2]].mean(axis=1)
    aside = np.abs(middles[:, None] - true_middles) / tall
    fits = inside & (heights[:, None] >= _LEAST_TALL * tall)
    cost = np.where(fits, aside, np.inf)
    pairs: list[tuple[int, int]] = []
    while cost.size and np.isfinite(cost.min()):
        row, column = np.unravel_index(cost.argmin(), cost.shape)
        pairs.append((int(row), int(column)))
        cost[row], cost[:, column] = np.inf, np.inf
    return pairs


@dataclass(frozen=True, eq=False)
class Depths:
    """Depths of everyone found: truth, answer (NaN: not placed) and standard deviation in metres, shape (N,) each."""

    truth_m: FloatArray
    found_m: FloatArray
    sd_m: FloatArray
    number: int

    def line(self, low_m: float, high_m: float) -> str:
        """Return the figures of one band of true depths."""
        band = (self.truth_m > low_m) & (self.truth_m <= high_m) & np.isfinite(self.found_m)
        if not band.any():
            return f"{'-':>34}"
        error = self.found_m[band] - self.truth_m[band]
        inside = np.abs(error) <= _TO_90 * self.sd_m[band]
        return (
            f"{band.sum():3d} {np.abs(error).mean():5.2f} m {np.median(np.abs(error) / self.truth_m[band]):5.1%} "
            f"{np.mean(error / self.truth_m[band]):+6.1%} {inside.mean():5.0%}"
        )


def depths_of(seen: Sequence[tuple[Street, People]], method: str) -> Depths:
    """Return the depths that a method gives to people already found."""
    rows: list[tuple[float, float, float]] = []
    for street, people in seen:
        camera = street.camera
        scene = place(
            street.path.name, "", camera.width, camera.height, people, CameraEstimate(camera), Settings(method=method)
        )
        sd = scene.bodies.position_sd_m
        rows.extend(
            (street.middles_m[truth, 2], scene.bodies.positions_m[row, 2], sd[row, 2])
            for row, truth in found_rows(people, street)
        )
    values = np.array(rows).reshape(-1, 3)
    return Depths(*values.T, number=sum(len(s.boxes_px) for s, _ in seen))


def report(backend: PoseBackend, streets: Sequence[Street], methods: Sequence[str]) -> None:
    """Print the table of one back end."""
    seen = [(street, backend.detect(Photo.open(street.path))) for street in streets]
    within = sum(int((s.middles_m[:, 2] <= _BANDS_M[-1][1]).sum()) for s in streets)
    found = sum(s.middles_m[t, 2] <= _BANDS_M[-1][1] for s, p in seen for _, t in found_rows(p, s))
    print(f"\n{backend.name}: {found} of {within} people within {_BANDS_M[-1][1]} m found")
    print(f"{'method':9s}" + "".join(f"{f'{low}-{high} m':^36s}" for low, high in _BANDS_M))
    print(f"{'':9s}" + f"{'n   mean  median   bias  in 90 %':^36s}" * len(_BANDS_M))
    for method in methods:
        depths = depths_of(seen, method)
        print(f"{method:9s}" + "".join(f"{depths.line(*band):^36s}" for band in _BANDS_M))


def main() -> None:
    """Print one table for each back end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data/street_sample"))
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--effort", default="normal")
    args = parser.parse_args()
    streets = read_streets(args.data)
    print(check(streets))
    print("n people, mean and median error of depth, mean signed error, how many truths lie in the 90 % interval")
    for name in args.pose.split(",") if args.pose else available():
        report(backend_named(name, PoseOptions(effort=args.effort)), streets, args.methods.split(","))


if __name__ == "__main__":
    main()
