"""Robustness of the joint fit: one assumption is violated at a time, and its errors and intervals are measured.

    python -m benchmarks.accuracy.breakage [--count 40]

Photos of synthetic groups by cameras of every kind (24 to 50 mm); each row changes one thing about the world, the
detector or the settings of the method.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from proxemetry.camera import Camera
from proxemetry.locate import LocateSettings
from synthetic.detections import Detector
from synthetic.pair_errors import constant_error_pct, record, summary
from synthetic.scenes import Recipe, SyntheticPhoto, scenes

METHODS = ("scene", "combined", "torso")
SEED = 2000
CONSTANT_M = 1.70
BASE = Recipe(posture="standing", focal_mm=(24.0, 35.0, 50.0))


@dataclass(frozen=True)
class Case:
    """A row of the table: the photos, what the method is told of the people, and of the camera."""

    name: str
    recipe: Recipe = BASE
    settings: LocateSettings = field(default_factory=LocateSettings)
    camera: Callable[[SyntheticPhoto], Camera] = lambda photo: photo.camera


def wrong_focal(factor: float, stated_rel_sd: float) -> Callable[[SyntheticPhoto], Camera]:
    """Return what tells a focal length that is wrong by a factor, with a stated doubt."""
    return lambda photo: photo.camera.with_focal(photo.camera.f_px * factor, focal_rel_sd=stated_rel_sd)


def recipe(**changes: object) -> Recipe:
    """Return the base recipe with changes."""
    return replace(BASE, **changes)  # type: ignore[arg-type]


CASES = (
    Case("standing, as assumed"),
    *(Case(f"camera {kind}", recipe(kind=kind)) for kind in ("eye_level", "tripod", "elevated", "pitched")),
    Case("16 mm, near", recipe(focal_mm=(16.0,))),
    Case("200 and 300 mm, far", recipe(focal_mm=(200.0, 300.0))),
    Case("seated", recipe(posture="seated")),
    Case("seated and standing", recipe(posture="mixed")),
    Case("30 % children", recipe(children=0.3)),
    Case("30 % children, told adults", recipe(children=0.3), LocateSettings(body_size="adults")),
    Case("30 % children, told 30 %", recipe(children=0.3), LocateSettings(child_weight=0.3)),
    Case("told all are women", settings=LocateSettings(body_size="women")),
    Case("told all are men", settings=LocateSettings(body_size="men")),
    Case("told all are children", settings=LocateSettings(body_size="children")),
    Case("10 % of keypoints far off", recipe(detector=Detector(outliers=0.1))),
    Case("keypoint noise doubled", recipe(detector=Detector(noise=0.8))),
    Case("exact keypoints", recipe(detector=Detector(noise=0.0, outliers=0.0))),
    Case("focal 10 % too long, unstated", camera=wrong_focal(1.1, 0.0)),
    Case("focal 10 % too short, unstated", camera=wrong_focal(0.9, 0.0)),
    Case("focal 10 % too long, 10 % stated", camera=wrong_focal(1.1, 0.1)),
    Case("focal 10 % too short, 10 % stated", camera=wrong_focal(0.9, 0.1)),
    Case("floor not used", settings=LocateSettings(floor="none")),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40, help="photos a row")
    args = parser.parse_args()
    print(f"{'':36s}{'pairs':>6s}{'mean%':>8s}{'median%':>8s}{'bias%':>8s}{'cover%':>8s}{'width%':>8s}"
          f"{'combined':>10s}{'torso':>8s}{'1.70 m':>8s}")  # fmt: skip
    for case in CASES:
        results = record(scenes(args.count, SEED, case.recipe), METHODS, case.settings, case.camera)
        s = summary(results["scene"])
        others = [summary(results[m]).median_error_pct for m in METHODS[1:]]
        print(f"{case.name:36s}{s.pairs:6d}{s.mean_error_pct:8.1f}{s.median_error_pct:8.1f}{s.bias_pct:+8.1f}"
              f"{s.coverage_pct:8.1f}{s.width_pct:8.0f}{others[0]:10.1f}{others[1]:8.1f}"
              f"{constant_error_pct(results['scene'], CONSTANT_M):8.1f}")  # fmt: skip
    print("combined and torso: median error in percent of the pairs they answer")


if __name__ == "__main__":
    main()
