"""Files of a fixed camera that the fuzzer damages: points and homographies to calibrate by, boxes, regions, clips."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.robustness.fuzz_damage import Rng, broken_bytes, broken_json, broken_text, pick
from benchmarks.robustness.fuzz_recordings import HEIGHT, WIDTH, HandIn
from proxemetry.camera import Mount
from proxemetry.cli import main
from proxemetry.clip.boxes import Boxes
from proxemetry.clip.run import read_region
from proxemetry.measure import Settings
from proxemetry.photo import Photo
from proxemetry.scene import Scene
from synthetic import clips

_POINTS = "u_px,v_px,x_m,y_m\n100,300,-2,6\n540,300,2,6\n40,440,-1.5,3\n600,440,1.5,3\n320,360,0,4.5\n"
_HOMOGRAPHY = "0.01 0 -3.2\n0 -0.001 6\n0 0.004 -0.8\n"
_SUBTITLES = """1
00:00:00,000 --> 00:00:00,033
[rel_alt: 30.200 abs_alt: 120.1] [gb_yaw: 10.1 gb_pitch: -60.0 gb_roll: 0.0] [focal_len: 24.00]

2
00:00:00,033 --> 00:00:00,066
[rel_alt: 30.300 abs_alt: 120.2] [gb_yaw: 10.1 gb_pitch: -60.1 gb_roll: 0.0] [focal_len: 24.00]
"""
_WAYS = {"--points": _POINTS, "--homography": _HOMOGRAPHY, "--subtitles": _SUBTITLES}
_BOXES = "".join(
    f"{frame},{person},{150 + 80 * person + 2 * frame},{120 + 5 * person},60,180,0.9,-1,-1,-1\n"
    for frame in range(1, 6)
    for person in range(4)
)


def calibration(rng: Rng, folder: Path) -> HandIn:
    """Write damaged points, a homography or a drone's subtitles, and return what calibrates by them."""
    way = pick(rng, list(_WAYS))
    (folder / "known").write_bytes(broken_text(rng, _WAYS[way]))
    out = folder / "mount.json"

    def hand_in() -> Iterator[Scene]:
        end = main(["calibrate", "--size", f"{WIDTH}x{HEIGHT}", way, str(folder / "known"), "--out", str(out)])
        if end == 2:
            raise SystemExit(2)
        assert end == 0, f"exit code {end}"
        mount = Mount.read(out)
        covariance = np.array(mount.covariance, dtype=float)
        assert not np.isinf(covariance).any(), "a spread that is not finite"
        assert (np.nan_to_num(np.diagonal(covariance)) >= 0).all(), "a negative variance"
        yield from ()

    return hand_in


def detections(rng: Rng, folder: Path) -> HandIn:
    """Write damaged boxes of MOT Challenge, and return what places their people by a mount."""
    (folder / "boxes.txt").write_bytes(broken_text(rng, _BOXES))
    settings = Settings(mount=clips.mount())

    def hand_in() -> Iterator[Scene]:
        boxes = Boxes.read(folder / "boxes.txt")
        photo = Photo("clip.mp4#t=0.000", clips.WIDTH, clips.HEIGHT, "")
        for source in range(3):
            yield boxes.scene(photo, source, settings)

    return hand_in


def region(rng: Rng, folder: Path) -> HandIn:
    """Write a damaged region of the floor, and return what reads it."""
    corners = [[0, 0], [5, 0], [5, 4], [0, 4]]
    geo = {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": [[*corners, corners[0]]]}}
    (folder / "region.json").write_bytes(broken_json(rng, pick(rng, [corners, {"corners_m": corners}, geo])))

    def hand_in() -> Iterator[Scene]:
        found = read_region(folder / "region.json")
        assert np.isfinite(found.area_m2), "an area that is not finite"
        assert found.area_m2 > 0, "an area of nothing"
        yield from ()

    return hand_in


@cache
def _clip_whole() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        return clips.write_video(Path(folder) / "clip.avi", 6, 5.0).read_bytes()


def clip(rng: Rng, folder: Path) -> HandIn:
    """Write a damaged clip, whole boxes and a whole mount, and return what follows the people."""
    (folder / "clip.avi").write_bytes(broken_bytes(rng, _clip_whole(), head=0.5))
    (folder / "boxes.txt").write_text(_BOXES)
    clips.mount().write(folder / "mount.json")

    def hand_in() -> Iterator[Scene]:
        given = ["--mount", str(folder / "mount.json"), "--detections", str(folder / "boxes.txt"), "--jobs", "0"]
        end = main(["video", str(folder / "clip.avi"), "--out", str(folder / "out"), *given])
        if end == 2:
            raise SystemExit(2)
        assert end in (0, 1), f"exit code {end}"
        yield from ()

    return hand_in
