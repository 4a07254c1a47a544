"""Synthetic photos of unknown focal length: how often intervals of distances hold, and how wide they are.

    python -m benchmarks.accuracy.unstated_focal [--scenes 150] [--seed 0]

Cameras are drawn as published photos may be taken: phones, zooms of 24-70 and 70-200 mm. The rows are the focal length
known, the prior alone, with straight lines (a building or floor in front of the camera, at any angle) and with people.
"""

from __future__ import annotations

import argparse
import math

import numpy as np

from proxemetry.camera import Camera, CameraEstimate
from proxemetry.camera.unstated import without_statement
from proxemetry.people import People
from proxemetry.photo import Photo
from synthetic.line_scenes import seen_by
from synthetic.pair_errors import record, summary
from synthetic.scenes import Recipe, SyntheticPhoto, scenes

KINDS = ("street", "odd angles", "one wall", "few", "clutter")


def lenses(count: int, seed: int) -> tuple[float, ...]:
    """Return 35 mm equivalents: two phones in five, two zooms of 24-70 mm, one of 70-200."""
    rng = np.random.default_rng(seed)
    phones = rng.uniform(24, 28, 2 * count // 5)
    zooms = np.exp(rng.uniform(math.log(24), math.log(70), 2 * count // 5))
    long = np.exp(rng.uniform(math.log(70), math.log(200), count // 5))
    return tuple(np.concatenate([phones, zooms, long]).tolist())


def camera_of(photo: SyntheticPhoto, lines: bool, people: bool) -> Camera:
    """Return the camera that is found where nothing states the focal length."""
    true, rng = photo.camera, np.random.default_rng(int(photo.focal_mm * 1e6) % 2**32)
    segments = None
    if lines:
        kind = KINDS[int(rng.integers(len(KINDS)))]
        pitch, roll = math.degrees(photo.pitch_rad), math.degrees(photo.roll_rad)
        segments = seen_by(kind, rng, true.width, true.height, true.f_px, pitch, roll).segments_px
    seen = photo.people if people else People.none(photo.people.skeleton)
    blank = Photo(photo.name, true.width, true.height, "")
    camera = without_statement(CameraEstimate(None), blank, seen, segments, assume=True).camera
    assert camera is not None
    return camera


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    photos = list(scenes(args.scenes, args.seed, Recipe(focal_mm=lenses(args.scenes, args.seed))))
    told = {
        "known": lambda photo: photo.camera,
        "prior alone": lambda photo: camera_of(photo, lines=False, people=False),
        "with lines": lambda photo: camera_of(photo, lines=True, people=False),
        "with people": lambda photo: camera_of(photo, lines=False, people=True),
        "with both": lambda photo: camera_of(photo, lines=True, people=True),
    }
    print(
        f"{'':14s}{'pairs':>7s}{'median error%':>15s}{'interval holds%':>17s}{'median width%':>15s}{'focal sd%':>11s}"
    )
    for name, camera in told.items():
        s = summary(record(photos, ("scene",), camera_of=camera)["scene"])
        sd = float(np.median([camera(photo).focal_rel_sd for photo in photos[:50]]))
        print(
            f"{name:14s}{s.pairs:7d}{s.median_error_pct:15.1f}{s.coverage_pct:17.1f}{s.width_pct:15.0f}{100 * sd:11.0f}"
        )


if __name__ == "__main__":
    main()
