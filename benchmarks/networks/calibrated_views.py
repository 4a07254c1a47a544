"""Photos by four calibrated cameras at once: each picture measured by itself, against joints triangulated from all.

    python -m benchmarks.networks.calibrated_views WHEEL [--trials Trial_1,Trial_2] [--pose A,B]

WHEEL is that of the package `pose2sim` (`pip download --no-deps pose2sim`, BSD-3, of D. Pagnon): a man walks on a beam
and loses his balance in front of four cameras 1.7 to 2.1 m above it that look down by 18 to 25 degrees, two of them
turned about their axes by 13 and 26 degrees; in two pictures a woman stands behind him, on a lower floor. In the second
trial a woman is drawn into the same pictures. Ten moments of each are taken.

The truth: joints as the back ends' answers for all views together have them (`calibrated_cameras.py`), with the cameras
turned by 0.4 to 0.8 degrees until the first trial's sight lines meet. No picture counts for more than another, so
systematic errors of a back end that depend on the view show, and those that do not show in lengths only. Each picture
is then measured by itself, with the focal length given but not the camera's place; and again with gravity from straight
lines, as `proxemetry measure` would. `true` are the same joints, moved by 0.5 % of the stature. Pictures of turned
cameras are measured as they are, and turned upright; only upright ones count in the lines by posture.

One man, one motion: neighbouring moments are very similar, so the figures are less certain than their number suggests.
The fit takes the two floors, 0.35 m apart, for one: this adds to the errors of pairs.
"""

from __future__ import annotations

import argparse
import io
import zipfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from benchmarks.networks.calibrated_cameras import (
    Sighting,
    View,
    read_qualisys,
    straightened,
    together,
    triangulated,
    turned_to_meet,
)
from benchmarks.networks.known_people import Tally, count, joined, owners, true_people, true_pixels
from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.camera import Camera, Mount
from proxemetry.camera.lines import gravity_from_lines
from proxemetry.camera.lines.segments import segments_of
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, available, backend_named

_DEMO = "Pose2Sim/Demo_Batch"
_EVERY = 10
#: Whose habits the truth is to be free of is averaged with others: the back ends with COCO's joints.
_WITNESSES = ("yolox-tinypose", "nanodet-movenet")
#: A camera that is turned by more is measured upright too, radians.
_TURNED = np.deg2rad(5.0)
#: Whose trunk is further from upright leans, radians.
_LEANING = np.deg2rad(20.0)


@dataclass(frozen=True, eq=False)
class KnownView:
    """One picture and its truth; see `known_people.KnownPhoto`.

    level: whether the camera is not turned about its axis. leaning: whether anyone leans.
    """

    camera_name: str
    pixels: RGBArray
    camera: Camera
    pitch_rad: float
    to_camera: FloatArray
    joints_m: FloatArray
    shown: np.ndarray
    level: bool
    leaning: bool


def frames_of(video: bytes, moments: int) -> list[RGBArray]:
    """Return so many frames, every tenth."""
    import av

    with av.open(io.BytesIO(video), mode="r") as clip:
        taken = islice(clip.decode(video=0), 0, _EVERY * moments, _EVERY)
        return [np.asarray(frame.to_ndarray(format="rgb24"), dtype=np.uint8) for frame in taken]


def read_views(wheel: Path) -> list[View]:
    """Return the wheel's calibrated cameras."""
    with zipfile.ZipFile(wheel) as files:
        return read_qualisys(files.read(f"{_DEMO}/calibration/Calib.qca.txt"))


def read_trial(wheel: Path, trial: str, views: Sequence[View], moments: int) -> list[list[RGBArray]]:
    """Return the pictures of a trial by moment and view, as wide as the calibration has them."""
    with zipfile.ZipFile(wheel) as files:
        clips = [frames_of(files.read(f"{_DEMO}/{trial}/videos/{view.name}.mp4"), moments) for view in views]
    return [
        [_as_wide(frame, view.camera.width) for frame, view in zip(moment, views, strict=True)]
        for moment in zip(*clips, strict=True)
    ]


def _as_wide(frame: RGBArray, width: int) -> RGBArray:
    """Return a frame with the columns that an encoder cut off on the right, black."""
    missing = width - frame.shape[1]
    return frame if missing <= 0 else np.pad(frame, ((0, 0), (0, missing), (0, 0)))


def sightings_of(views: Sequence[View], seen: dict[str, list[People]]) -> list[list[Sighting]]:
    """Return everyone of a moment, as all back ends saw them in all views; the first back end tells who is who."""
    first = next(iter(seen))
    found: list[list[Sighting]] = []
    for rows in together(views, seen[first]):
        sightings = [Sighting(v, seen[first][v].keypoints_px[r], seen[first][v].scores[r]) for v, r in rows.items()]
        at = triangulated(views, sightings, min(3, len(rows)))
        for name in list(seen)[1:]:
            for v, view in enumerate(views):
                row = _who(seen[name][v], view, at)
                if row is not None:
                    sightings.append(Sighting(v, seen[name][v].keypoints_px[row], seen[name][v].scores[row]))
        found.append(sightings)
    return found


def _who(people: People, view: View, joints_m: FloatArray) -> int | None:
    truth = known_view(np.zeros((1, 1, 3), np.uint8), view, [joints_m])
    whom = owners(people, *true_pixels(truth))
    return int(np.flatnonzero(whom == 0)[0]) if (whom == 0).any() else None


def known_view(pixels: RGBArray, view: View, joints_m: Sequence[FloatArray]) -> KnownView:
    """Return a picture's truth from joints (17, 3) in the room's frame."""
    at = view.seen(np.array(joints_m).reshape(-1, 17, 3))
    down = -view.up
    ahead = np.array([0.0, 0.0, 1.0]) - down[2] * down
    ahead /= np.linalg.norm(ahead)
    to_camera = np.asarray(np.column_stack([np.cross(down, ahead), down, ahead]), dtype=float)
    return KnownView(
        view.name, pixels, view.camera, view.pitch_rad, to_camera, at, np.full(len(at), np.inf),
        abs(view.roll_rad) < _TURNED, leans(joints_m),
    )  # fmt: skip


def upright(view: View, picture: RGBArray) -> tuple[View, RGBArray]:
    """Return a camera and its picture turned until the horizon is level."""
    level, matrix = straightened(view)
    size = (view.camera.width, view.camera.height)
    return level, np.asarray(cv2.warpAffine(picture, matrix, size, flags=cv2.INTER_AREA), dtype=np.uint8)


def known_views(
    views: Sequence[View], moments: Sequence[Sequence[RGBArray]], truth: Sequence[Sequence[FloatArray]]
) -> list[KnownView]:  # fmt: skip
    """Return all pictures with their truth, those of turned cameras upright too."""
    made: list[KnownView] = []
    for pictures, joints in zip(moments, truth, strict=True):
        for view, picture in zip(views, pictures, strict=True):
            made.append(known_view(picture, view, joints))
            if not made[-1].level:
                level, turned = upright(view, picture)
                made.append(known_view(turned, level, joints))
    return made


def seen_together(
    views: Sequence[View], moments: Sequence[Sequence[RGBArray]], witnesses: dict[str, PoseBackend]
) -> list[list[list[Sighting]]]:  # fmt: skip
    """Return by moment everyone as they were seen in all views."""
    found: list[list[list[Sighting]]] = []
    for pictures in moments:
        seen = {name: [b.detect(Photo.from_array(p)) for p in pictures] for name, b in witnesses.items()}
        found.append(sightings_of(views, seen))
    return found


def joints_of(views: Sequence[View], people: Sequence[Sequence[Sighting]]) -> list[FloatArray]:
    """Return the joints of everyone who is seen in two views at least."""
    found = [triangulated(views, s, min(3, len({one.view for one in s}))) for s in people]
    return [joints for joints in found if np.isfinite(joints[[5, 6, 11, 12]]).all()]


def lengths_lines(truth: Sequence[Sequence[FloatArray]]) -> Iterator[str]:
    """Yield for each person, the one at the lowest x of the room first, lengths between true joints in cm over all
    moments, mean and standard deviation: bones do not change."""
    ends = {"torso": ([5, 6], [11, 12]), "shoulders": ([5], [6]), "hips": ([11], [12]), "thigh": ([11], [13]),
            "shank": ([13], [15]), "ears": ([3], [4])}  # fmt: skip
    everyone = [sorted(people, key=lambda at: float(np.nanmean(at[:, 0]))) for people in truth]
    for same in zip(*everyone, strict=False):
        at, parts = np.array(same), list[str]()
        for name, (a, b) in ends.items():
            length = 100 * np.linalg.norm(at[:, a].mean(axis=1) - at[:, b].mean(axis=1), axis=1)
            parts.append(f"{name} {np.nanmean(length):.1f} +- {np.nanstd(length):.1f}")
        yield ", ".join(parts)


def leans(joints_m: Sequence[FloatArray]) -> bool:
    """Return whether anyone's trunk leans by more than `_LEANING`; joints (17, 3) in the room's frame."""
    trunks = np.array([at[[5, 6]].mean(axis=0) - at[[11, 12]].mean(axis=0) for at in joints_m])
    return bool((np.arctan2(np.linalg.norm(trunks[:, :2], axis=1), trunks[:, 2]) > _LEANING).any())


def mount_from_lines(picture: KnownView, people: People) -> Mount | None:
    """Return what straight lines tell of the camera's place, as a user's photo would have it."""
    segments = segments_of(Photo.from_array(picture.pixels), people.boxes_px)
    gravity = None if segments is None else gravity_from_lines(segments, picture.camera)
    return None if gravity is None else gravity.mount()


def report(pictures: Sequence[KnownView], backends: dict[str, PoseBackend]) -> None:
    """Print the figures of the joints themselves and of each back end."""
    rng = np.random.default_rng(0)
    for name in ("true", *backends):
        tallies: dict[str, Tally] = {}
        for picture in pictures:
            pixels, statures_px = true_pixels(picture)
            if name == "true":
                people = true_people(pixels, statures_px, rng)
            else:
                people = backends[name].detect(Photo.from_array(picture.pixels))
            whom = owners(people, pixels, statures_px)
            count(tallies.setdefault(picture.camera_name, Tally()), picture, people, whom)
            if picture.level:
                posture = "someone leans" if picture.leaning else "nobody leans"
                count(tallies.setdefault(posture, Tally()), picture, people, whom)
                mount = mount_from_lines(picture, people)
                count(tallies.setdefault(f"{posture}, with lines", Tally()), picture, people, whom, mount)
        print(name)
        for label, tally in sorted(tallies.items()):
            print(f"{label:>26} {tally.line()}")
        everything = joined([tally for label, tally in tallies.items() if label.endswith("leans")])
        print(f"{'joints':>26} {everything.joint_line()}", flush=True)


def main() -> None:
    """Print the figures of every back end."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("wheel", type=Path)
    parser.add_argument("--trials", default="Trial_1,Trial_2")
    parser.add_argument("--moments", type=int, default=10, help="how many of each trial, at most ten")
    add_models_option(parser)
    parser.add_argument("--pose", default="", help="comma-separated names (default: all that are available)")
    args = parser.parse_args()
    if not args.wheel.is_file():
        raise SystemExit(f"{args.wheel} is not there: pip download --no-deps pose2sim gets it")
    names = args.pose.split(",") if args.pose else available()
    backends = {name: backend_named(name, PoseOptions()) for name in names}
    witnesses = {name: backends.get(name) or backend_named(name, PoseOptions()) for name in _WITNESSES}
    views = read_views(args.wheel)
    turned: list[View] | None = None
    for trial in args.trials.split(","):
        moments = read_trial(args.wheel, trial, views, args.moments)
        seen = seen_together(views, moments, witnesses)
        if turned is None:
            turned = turned_to_meet(views, [s for people in seen for s in people if len({o.view for o in s}) > 2])
        truth = [joints_of(turned, people) for people in seen]
        print(f"{trial}\n" + "\n".join(lengths_lines(truth)))
        report(known_views(turned, moments, truth), backends)


if __name__ == "__main__":
    main()
