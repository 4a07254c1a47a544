"""Who never moves in a clip: its people, and the same people frozen where they stood.

    python -m benchmarks.networks.motionless CLIP... [--pose NAME] [--fps 2] [--frozen 8] [--seconds 190] [--out DIR]

Clips are of a fixed camera. Each is looked at twice: as it is, and with up to --frozen of its people held where one
frame shows them. What the camera's noise does to the background goes on over them, others walk in front of them, and
the picture is compressed again; a clip shorter than --seconds is played forth and back until it lasts as long. The
frozen clip stays in --out, for `proxemetry video`.

People are followed by their boxes alone. Per clip it prints how many are seen for `LEAST_S` seconds, how many of these
never move, and how far bodies stray (`stillness.strayed_share`) in stretches of some lengths: the least and the median.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry.arrays import FloatArray, RGBArray
from proxemetry.assignment import assign
from proxemetry.clip.frames import open_clip
from proxemetry.clip.stillness import LEAST_S, WINDOW_S, is_motionless, strayed_share
from proxemetry.overlap import pairwise_iou
from proxemetry.people import People, PoseBackend
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named

#: Boxes of one person overlap by this much from frame to frame, and no more than so many seconds lie between.
_OVERLAP, _GAP_S = 0.35, 5.0
#: Pixels further than this from their median over the clip, of 255, are of the frozen body, and of who passes by.
_CHANGED, _PASSING = 20, 30
#: People who are frozen are at least so tall, pixels, seen with this score, and apart from others in their frame.
_LEAST_PX, _CLEAR, _APART_PX = 60, 0.5, 25
#: Who is at a place for this share of the clip hides what is behind, and is frozen with it.
_ALWAYS = 0.5
#: Stretches of so many seconds are looked at, one every ten seconds.
LENGTHS_S, _EVERY_S = (30.0, 60.0, 120.0, LEAST_S), 10.0
_SEED = 1


@dataclass(frozen=True, eq=False)
class Held:
    """A person frozen as a frame shows them in a box (4,). whole: with what is around the body in it."""

    frame: int
    box_px: FloatArray
    whole: bool


@dataclass(eq=False)
class Chain:
    """One person's boxes (4,) and joints (K, 2), with the times of both, in order."""

    t_s: list[float] = field(default_factory=list[float])
    boxes_px: list[FloatArray] = field(default_factory=list[FloatArray])
    joints_px: list[FloatArray] = field(default_factory=list[FloatArray])

    def strayed(self, length_s: float) -> list[float]:
        """Return how far the body strays in stretches of so many seconds that it is seen in throughout."""
        t_s, joints = np.array(self.t_s), np.array(self.joints_px)
        shares: list[float] = []
        for begin in np.arange(t_s[0], t_s[-1] - length_s + WINDOW_S, _EVERY_S):
            rows = (t_s >= begin) & (t_s < begin + length_s)
            if len(np.unique(np.floor((t_s[rows] - begin) / WINDOW_S))) >= 0.9 * length_s / WINDOW_S:
                shares.append(strayed_share(t_s[rows], joints[rows]))
        return [share for share in shares if np.isfinite(share)]


def followed(found: Sequence[People], t_s: Sequence[float]) -> list[Chain]:
    """Return everybody's chain through the frames, by the overlap of boxes."""
    chains: list[Chain] = []
    for people, now in zip(found, t_s, strict=True):
        there = [c for c in chains if now - c.t_s[-1] <= _GAP_S]
        before = np.array([c.boxes_px[-1] for c in there]).reshape(-1, 4)
        overlap = np.nan_to_num(pairwise_iou(people.boxes_px, before))
        known = {row: there[column] for row, column in assign(-overlap) if overlap[row, column] >= _OVERLAP}
        for row in range(len(people)):
            if row not in known:
                chains.append(known.setdefault(row, Chain()))
            known[row].t_s.append(now)
            known[row].boxes_px.append(people.boxes_px[row])
            known[row].joints_px.append(people.keypoints_px[row])
    return chains


def chosen_people(found: Sequence[People], most: int, width: int) -> list[Held]:
    """Return clear people who stand apart, no two of them in one place."""
    candidates = [
        (frame, box)
        for frame, people in enumerate(found)
        for row, box in enumerate(people.boxes_px)
        if box[3] - box[1] >= _LEAST_PX and people.person_scores[row] >= _CLEAR
        and box[0] > 0.02 * width and box[2] < 0.98 * width
        and not any(_touch(box, other) for k, other in enumerate(people.boxes_px) if k != row)
    ]  # fmt: skip
    chosen: list[Held] = []
    for k in np.random.default_rng(_SEED).permutation(len(candidates)):
        frame, box = candidates[k]
        if len(chosen) < most and not any(_touch(box, other.box_px) for other in chosen):
            there = sum(bool((pairwise_iou(people.boxes_px, box[None]) > _OVERLAP).any()) for people in found)
            chosen.append(Held(frame, box, there > _ALWAYS * len(found)))
    return chosen


def _touch(a: FloatArray, b: FloatArray) -> bool:
    return bool((np.minimum(a[2:], b[2:]) + _APART_PX > np.maximum(a[:2], b[:2])).all())


def write_frozen(
    frames: Sequence[RGBArray], chosen: Sequence[Held], path: Path, fps: float, seconds: float
) -> None:  # fmt: skip
    """Write the clip with these people held where they are, under the noise of each frame."""
    usual = np.median(np.stack(frames[:: max(1, len(frames) // 50)]), axis=0)
    rng = np.random.default_rng(_SEED)
    steady = np.abs(frames[1].astype(float) - frames[0])
    noise_sd = 1.48 * float(np.median(steady[steady < _CHANGED])) / np.sqrt(2)
    height, width = frames[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), fps, (width, height))
    there_and_back = [*frames, *frames[-2:0:-1]]
    for number in range(max(len(frames), round(seconds * fps))):
        pixels = there_and_back[number % len(there_and_back)]
        made = pixels.copy()
        for held in chosen:
            margin = (1.0 if held.whole else 0.12) * (held.box_px[3] - held.box_px[1])
            around = held.box_px + margin * np.array([-1, -1, 1, 1])
            x0, y0, x1, y1 = around.clip(0, [width, height] * 2).astype(int)
            here = np.s_[y0:y1, x0:x1]
            made[here] = _held(frames[held.frame][here], pixels[here], usual[here], noise_sd, held.whole, rng)
        writer.write(np.ascontiguousarray(made[..., ::-1]))
    writer.release()


def _held(
    still: RGBArray, now: RGBArray, usual: FloatArray, noise_sd: float, whole: bool, rng: np.random.Generator
) -> RGBArray:  # fmt: skip
    """Return a part of a frame with what was still in it a moment before, under noise and behind who passes by."""
    noise = now - usual
    drawn = rng.normal(0, noise_sd, noise.shape)
    if whole:
        return (still + drawn).clip(0, 255).astype(np.uint8)
    body = _filled(np.abs(still - usual).max(axis=-1) > _CHANGED, 9, 0.1)
    passing = _filled(np.abs(noise).max(axis=-1) > _PASSING, 7, 0.3)
    noise = np.where(np.abs(noise) > _PASSING, drawn, noise)
    return np.where((body & ~passing)[..., None], (still + noise).clip(0, 255).astype(np.uint8), now)


def _filled(mask: NDArray[np.bool_], side: int, share: float) -> NDArray[np.bool_]:
    return np.asarray(cv2.GaussianBlur(mask.astype(np.float32), (side, side), 0) > share)


def seen_in(path: Path, fps: float, backend: PoseBackend) -> tuple[list[float], list[RGBArray], list[People]]:
    """Return times, pixels and people of a clip's frames."""
    frames = list(open_clip(path, fps).frames())
    pixels = [frame.photo.pixels() for frame in frames]
    return [frame.t_s for frame in frames], pixels, [backend.detect(Photo.from_array(p)) for p in pixels]


def _row(name: str, kind: str, chains: Sequence[Chain]) -> str:
    lasting = [c for c in chains if c.t_s[-1] - c.t_s[0] >= LEAST_S - WINDOW_S]
    cells: list[str] = []
    for length in LENGTHS_S:
        strayed = [share for chain in chains for share in chain.strayed(length)]
        cells.append(f"{min(strayed):.4f}, {np.median(strayed):.4f} of {len(strayed)}" if strayed else "-")
    marked = sum(is_motionless(np.array(c.t_s), np.array(c.joints_px)) for c in lasting)
    return f"| {name} | {kind} | {len(lasting)} | {marked} | {' | '.join(cells)} |"


def main() -> None:
    """Look at each clip twice and print the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clips", nargs="+", type=Path)
    parser.add_argument("--pose", default="yolox-tinypose")
    parser.add_argument("--fps", type=float, default=2.0)
    parser.add_argument("--frozen", type=int, default=8)
    parser.add_argument("--seconds", type=float, default=LEAST_S + 2 * WINDOW_S)
    parser.add_argument("--out", type=Path)
    add_models_option(parser)
    args = parser.parse_args()
    out, backend = args.out or Path(tempfile.mkdtemp()), backend_named(args.pose, PoseOptions())
    out.mkdir(parents=True, exist_ok=True)
    lengths = " | ".join(f"strayed in {length:g} s: least, median" for length in LENGTHS_S)
    print(f"| clip | people | seen {LEAST_S:g} s | never move | {lengths} |")
    print(f"| --- | --- | ---: | ---: |{' --- |' * len(LENGTHS_S)}")
    for clip in args.clips:
        t_s, frames, found = seen_in(clip, args.fps, backend)
        print(_row(clip.name, "as they are", followed(found, t_s)), flush=True)
        chosen = chosen_people(found, args.frozen, frames[0].shape[1])
        if not chosen:
            continue
        made = out / f"{clip.stem}_frozen.mp4"
        write_frozen(frames, chosen, made, args.fps, args.seconds)
        t_s, _, found = seen_in(made, args.fps, backend)
        chains = followed(found, t_s)
        held = [c for c in chains if any(_stands_at(c, one.box_px) for one in chosen)]
        print(_row(clip.name, f"{len(chosen)} frozen", held), flush=True)
        print(_row(clip.name, "beside them", [c for c in chains if not any(c is h for h in held)]), flush=True)


def _stands_at(chain: Chain, box_px: FloatArray) -> bool:
    overlap = np.nan_to_num(pairwise_iou(np.array(chain.boxes_px), box_px[None]))
    return bool(np.median(overlap) > _OVERLAP)


if __name__ == "__main__":
    main()
