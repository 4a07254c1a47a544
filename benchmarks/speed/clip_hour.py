"""An hour of synthetic people, from scenes on: memory and time of tracking, smoothing and counting.

    python -m benchmarks.speed.clip_hour [--minutes 60] [--people 12] [--fps 5]

People walk in straight lines through a place of 20 x 20 m, some of them in pairs, with sightings good to 0.15 m. Peak
memory is that of the process, with everything from tracking to the tables in it.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

import numpy as np

from proxemetry.archive.store.folder import Folder
from proxemetry.camera import Camera, Mount
from proxemetry.clip.analysis import Wanted, assembled
from proxemetry.clip.camera import ClipCamera
from proxemetry.clip.measuring import Measured
from proxemetry.clip.placing import Placed
from proxemetry.clip.shots import Change, Shot
from proxemetry.clip.sightings import Sightings
from proxemetry.clip.writing import write_results

SD_M = 0.15
#: A camera on a mast before the place, whose error all people share.
MOUNT = Mount.stated(
    np.deg2rad(20.0), 0.0, 8.0, pitch_sd_rad=0.005, roll_sd_rad=0.005, height_sd_m=0.2,
    camera=Camera.centred(1000, 1280, 720),
)  # fmt: skip


def main() -> None:
    """Print processor time a frame and peak memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=60)
    parser.add_argument("--people", type=int, default=12, help="at one time")
    parser.add_argument("--fps", type=float, default=5)
    args = parser.parse_args()
    times = np.arange(0, 60 * args.minutes, 1 / args.fps)
    shot = crowd(times, args.people)
    measured = Measured(tuple(times), (Shot(0, len(times) - 1, 0, Change.START),), 1280, 720, ())
    with tempfile.TemporaryDirectory() as scratch:
        begun = time.process_time()
        placed = [Placed(s, "ok", None, len(s), {}) for s in shot]
        found = assembled(measured, Wanted(), {0: ClipCamera(MOUNT, MOUNT.camera, "made up")}, placed)
        followed_s = time.process_time() - begun
        write_results(found, Folder(Path(scratch) / "out"))
        written_s = time.process_time() - begun - followed_s
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{len(times)} frames, {sum(map(len, shot))} sightings, {len(found.people)} tracks")
    print(f"following, smoothing and groups {1000 * followed_s / len(times):.1f} ms a frame, pairs and tables "
          f"{1000 * written_s / len(times):.1f} ms a frame (processor time)")  # fmt: skip
    print(f"peak memory {peak:.2f} GB")


def crowd(times: np.ndarray, at_once: int) -> list[Sightings]:
    """Return sightings of people who cross the place, `at_once` of them on average."""
    rng = np.random.default_rng(0)
    seconds = 20 / 1.2
    count = int(at_once * times[-1] / seconds)
    begin = np.sort(rng.uniform(-seconds, times[-1], count))
    angle, aside = rng.uniform(0, 2 * np.pi, count), rng.uniform(-8, 8, count)
    ahead = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = ahead[:, ::-1] * (-1, 1)
    for k in range(1, count, 3):  # a companion at arm's length
        begin[k], ahead[k], across[k], aside[k] = begin[k - 1], ahead[k - 1], across[k - 1], aside[k - 1] + 0.8
    shot = []
    for t in times:
        there = np.flatnonzero((begin <= t) & (t < begin + seconds))
        gone = 1.2 * (t - begin[there])[:, None] - 10
        places = gone * ahead[there] + aside[there, None] * across[there] + rng.normal(0, SD_M, (len(there), 2))
        places = places + (0.0, 22.0)
        shot.append(Sightings.of_places(float(t), places, SD_M))
    return shot


if __name__ == "__main__":
    main()
