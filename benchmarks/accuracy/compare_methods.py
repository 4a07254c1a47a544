"""Methods side by side on synthetic scenes, by kind of camera and posture, scored by the benchmark's protocol `v1`.

    python -m benchmarks.accuracy.compare_methods --count 40 --methods torso,combined,scene

Every figure is for keypoints with a detector's noise and occlusion, and cameras known exactly.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence

from proxemetry.benchmark import Predictions, Score, read_labels, score
from proxemetry.benchmark.report import comparison
from proxemetry.benchmark.scenes import prediction_of
from proxemetry.camera import CameraEstimate
from proxemetry.locate import METHODS, LocateSettings
from proxemetry.measure import place
from proxemetry.settings import Settings
from synthetic.files import write
from synthetic.scenes import KINDS, POSTURES, Recipe, SyntheticPhoto, layouts_from_labels, scenes


def score_methods(
    photos: Sequence[SyntheticPhoto], methods: Sequence[str], body_size: str = "adults"
) -> dict[str, Score]:
    """Place the detected people of these photos by each method, and score each."""
    with tempfile.TemporaryDirectory() as folder:
        write(folder, photos)
        labels = read_labels(folder)
    scores = {}
    for method in methods:
        settings = Settings(method=method, locate=LocateSettings(body_size=body_size))
        placed = (
            place(p.name, "", p.camera.width, p.camera.height, p.people, CameraEstimate(p.camera), settings)
            for p in photos
        )
        scores[method] = score(labels, Predictions(tuple(prediction_of(scene) for scene in placed), method))
    return scores


def main() -> None:
    """Print one table for every kind of camera and posture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40, help="photos of each kind and posture")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--methods", default="torso,combined,scene")
    parser.add_argument("--kinds", default=",".join(KINDS[:-1]))
    parser.add_argument("--postures", default="standing,seated")
    parser.add_argument("--children", type=float, default=0.0, metavar="SHARE")
    parser.add_argument("--body-size", default="adults")
    parser.add_argument("--layouts", metavar="CSV", help="ground truth file whose places are used")
    args = parser.parse_args()
    methods = args.methods.split(",")
    assert set(methods) <= set(METHODS)
    assert set(args.postures.split(",")) <= set(POSTURES)
    layouts = layouts_from_labels(args.layouts) if args.layouts else ()
    for kind in args.kinds.split(","):
        for posture in args.postures.split(","):
            recipe = Recipe(kind=kind, posture=posture, children=args.children, layouts=layouts)
            photos = list(scenes(args.count, args.seed, recipe))
            started = time.process_time()
            text = comparison(score_methods(photos, methods, args.body_size))
            print(f"{kind}, {posture} ({time.process_time() - started:.1f} s)\n{text}", flush=True)


if __name__ == "__main__":
    main()
