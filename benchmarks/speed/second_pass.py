"""Time to pool a million photos' evidence on each other's cameras, and to find those that it changes.

    python -m benchmarks.speed.second_pass [--photos 1000000]

The parts of an archive are made out of those of 256 photos with recorded keypoints: half of them state no focal length
and are of two sizes, a third is doubtful and of 300 models that the rest is sure of. Timed is what every run does once
all photos are measured, before it measures any of them again: the table of models, the shoots, and finding the rows
whose camera changes. The cost of measuring photos again is that of `fit_cost`.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchmarks.speed.recorded_archive import write_keypoints
from proxemetry.archive.run.camera_pool import CameraPool, Shoot, models_of, stale_shards
from proxemetry.archive.run.run import run
from proxemetry.archive.run.shoots import shoots_of
from proxemetry.archive.run.work import Job
from proxemetry.archive.store import parts
from proxemetry.archive.store.duck import connection, quoted
from proxemetry.archive.store.folder import Folder
from proxemetry.camera.others import SameShoot
from proxemetry.locate import LocateSettings

TEMPLATE = 256


def main() -> None:
    """Make the parts and print what each step costs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--photos", type=int, default=1_000_000)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = _archive(Path(scratch), args.photos)
        models = _timed("table of models", lambda: models_of(folder))
        shoots = _timed("shoots", lambda: shoots_of(folder, None, LocateSettings()))
        print(f"{len(models)} models, {len(shoots)} shoots: {[s.said for s in shoots.values()]}")
        background = np.random.default_rng(0).integers(0, 255, (360, 480), dtype=np.uint8)
        background = cv2.GaussianBlur(background, (9, 9), 3)
        told = {size: Shoot(SameShoot(4.8, 0.1, 300, 500), "told", background) for size in shoots}
        pool = CameraPool(models, told)
        stale = _timed("rows that are told something", lambda: stale_shards(folder, pool))
        print(f"{len(stale)} of {len(parts.finished(folder))} parts to measure again")
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB at the peak")


def _timed(what: str, step: Callable[[], Any]) -> Any:
    started, before = time.perf_counter(), time.process_time()
    found = step()
    print(
        f"{what}: {time.perf_counter() - started:.1f} s, {time.process_time() - before:.1f} s of processor", flush=True
    )
    return found


def _archive(root: Path, count: int) -> Folder:
    """Write the parts of an archive of so many photos, and return its folder."""
    keypoints = root / "keypoints.json"
    write_keypoints(keypoints, TEMPLATE)
    run([], Job(str(root / "template"), f"recorded:{keypoints}"), jobs=0)
    folder = Folder(root / "out")
    (root / "out" / "scenes").mkdir(parents=True)
    duck = connection()
    duck.execute(
        "CREATE TEMP TABLE rows AS SELECT *, row_number() OVER (ORDER BY photo) AS place FROM "
        f"read_parquet('{root}/template/scenes/*.parquet')"
    )
    for shard in range(-(-count // TEMPLATE)):
        number = f"({shard * TEMPLATE} + place)"
        duck.execute(
            f"COPY (SELECT * EXCLUDE (place) REPLACE ({number}::VARCHAR || '.jpg' AS photo, "
            f"CASE WHEN {number} % 6 < 3 THEN 'none' WHEN {number} % 6 < 5 THEN 'doubtful' ELSE 'sure' END "
            "AS own_focal, "
            f"'Maker' AS camera_make, CASE WHEN {number} % 6 < 3 THEN NULL ELSE 'M' || hash({number}) % 300 END "
            f"AS camera_model, (160 + 2 * ({number} % 2))::INTEGER AS width_px, "
            f"(4 + {number} % 3)::DOUBLE AS focal_mm) FROM rows "
            f"WHERE {number} <= {count}) TO {quoted(folder.path(parts.name_of(shard)))} "
            "(FORMAT parquet, COMPRESSION zstd)"
        )
    duck.execute("DROP TABLE rows")
    return folder


if __name__ == "__main__":
    main()
