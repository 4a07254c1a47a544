"""A run over a clip killed at random moments: every frame must be there once, and nothing measured twice for good.

    python -m benchmarks.robustness.clip_kills [--kills 10] [--frames 400]

The clip and its keypoints are synthetic; `proxemetry video` is started, killed with SIGKILL after a random time, and
started again, until it ends by itself.
"""

from __future__ import annotations

import argparse
import csv
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from synthetic import clips

STEP_S = 0.2


def main() -> None:
    """Kill, go on, and count the frames."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--longest-s", type=float, default=8.0, help="kill each run within this many seconds")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        names = [f"clip.avi#t={k * STEP_S:.3f}" for k in range(args.frames)]
        clips.write_video(folder / "clip.avi", args.frames, 1 / STEP_S)
        there = np.tile(clips.walkers(1, STEP_S), (args.frames, 1, 1))
        clips.recorded(folder / "clip.json", names, there)
        clips.mount().write(folder / "camera.json")
        command = [
            sys.executable, "-m", "proxemetry", "video", str(folder / "clip.avi"), "--out", str(folder / "out"),
            "--mount", str(folder / "camera.json"), "--jobs", "2", "--detections", f"recorded:{folder / 'clip.json'}",
        ]  # fmt: skip
        rng, killed = np.random.default_rng(0), 0
        while killed < args.kills:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            time.sleep(rng.uniform(0.2, args.longest_s))
            if process.poll() is not None:
                break
            process.send_signal(signal.SIGKILL)
            process.wait()
            killed += 1
        ended = subprocess.run(command, capture_output=True, text=True, check=False)
        with (folder / "out" / "frames.csv").open(newline="") as file:
            frames = [int(r["frame"]) for r in csv.DictReader(file)]
        coco = json.loads((folder / "out" / "coco_keypoints.json").read_text())
        seen = [i["file_name"] for i in coco["images"]]
        once = seen == names and frames == list(range(len(names)))
        print(f"killed {killed} times; the last run ended with {ended.returncode}")
        print(f"frames {len(frames)} of {args.frames}, each once and in order: {once}")


if __name__ == "__main__":
    main()
