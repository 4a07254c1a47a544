"""The clip with people, tracks and distances drawn in, as a video that browsers play.

An extra, `proxemetry[video]`, since encoders are large. The codec is AV1 by SVT-AV1, or VP9: both are free of patents
and of the GPL. Heads are pixelated unless asked otherwise.
"""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Collection
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ..archive.store.folder import Folder
from ..arrays import FloatArray, RGBArray
from ..errors import SettingsError
from ..people import People
from ..plots.faces import heads_px, pixelated
from ..plots.pair_selection import VAGUE_MARK
from ..scene import Scene
from .analysis import Analysis
from .frames import open_clip
from .measuring import scenes

FILE = "annotated.mp4"
#: Encoders in the order of preference: their names in FFmpeg, and what makes them quick enough.
_ENCODERS = (("libsvtav1", {"preset": "8", "crf": "35"}), ("libvpx-vp9", {"deadline": "realtime", "cpu-used": "6"}))
_COLOURS = (
    (59, 110, 165), (181, 83, 60), (79, 138, 76), (138, 95, 168), (168, 134, 45), (47, 138, 138), (168, 79, 120),
)  # fmt: skip
_NEAR = (192, 57, 43)
_MARGIN = 0.25


def require_encoder() -> str:
    """Return the encoder that will be used; raises SettingsError, before any work, where there is none."""
    if importlib.util.find_spec("av") is None:
        raise SettingsError("--annotated needs an extra: pip install 'proxemetry[video]'")
    from av.codec import codecs_available

    for name, _ in _ENCODERS:
        if name in codecs_available:
            return name
    raise SettingsError("--annotated: this PyAV has neither SVT-AV1 nor VP9; pip install --upgrade av")


def annotate(path: Path, found: Analysis, folder: Folder, *, fps: float, faces: str = "blur") -> str:
    """Write the annotated clip into the folder and return its name."""
    os.environ.setdefault("SVT_LOG", "1")  # without the encoder's own report of its settings
    import av

    name = require_encoder()
    times = np.array(found.measured.times_s)
    rate = max(1, round(1 / float(np.median(np.diff(times))))) if len(times) > 1 else 1
    tracks, doubtful = _by_frame(found), {p.track.number for p in found.people if p.doubt}
    limit = found.wanted.within_m[-1]
    every = (Scene.from_json(text) for _, texts in scenes(folder) for text in texts)
    hidden = hidden_heads(found, folder)
    with folder.writing(FILE) as temporary, av.open(temporary, "w", format="mp4") as output:
        stream: Any = output.add_stream(name, rate=rate, options=dict(_ENCODERS)[name])
        width, height = found.measured.width_px // 2 * 2, found.measured.height_px // 2 * 2
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        for number, (frame, scene) in enumerate(zip(open_clip(path, fps).frames(), every, strict=False)):
            heads = hidden.get(number, np.zeros((0, 3)))
            drawn = draw(frame.photo.pixels(), scene, tracks.get(number, {}), limit, faces, heads, doubtful)
            picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(drawn[:height, :width]), format="rgb24")
            output.mux(stream.encode(picture))
        output.mux(stream.encode(None))
    return FILE


def _by_frame(found: Analysis) -> dict[int, dict[int, tuple[int, float, float]]]:
    """Return for each frame the track and place of each row of its scene."""
    answer: dict[int, dict[int, tuple[int, float, float]]] = {}
    for person in found.people:
        for frame, row, (x, y) in zip(person.track.frames, person.rows, person.track.positions_m, strict=True):
            if row >= 0:
                answer.setdefault(int(frame), {})[int(row)] = (person.track.number, float(x), float(y))
    return answer


def hidden_heads(found: Analysis, folder: Folder) -> dict[int, FloatArray]:
    """Return for each frame the circles (x, y, radius) of heads that are there but were not found, shape (n, 3).

    A person who is bridged is somewhere between where they were seen before and after, and so is their head.
    """
    gaps = [
        (int(p.track.frames[a]), int(p.rows[a]), int(p.track.frames[b]), int(p.rows[b]))
        for p in found.people
        for a, b in pairwise(np.flatnonzero(p.rows >= 0))
        if b > a + 1
    ]
    ends = {frame for first, _, last, _ in gaps for frame in (first, last)}
    circles = {
        number: _heads(Scene.from_json(text).people)
        for begin, texts in (scenes(folder) if ends else ())
        for number, text in enumerate(texts, start=begin)
        if number in ends
    }
    found_heads: dict[int, list[FloatArray]] = {}
    for first, row, last, later in gaps:
        before, after = circles[first][row], circles[last][later]
        for frame in range(first + 1, last):
            share = (frame - first) / (last - first)
            between = (1 - share) * before + share * after
            between[2] *= 1 + _MARGIN
            found_heads.setdefault(frame, []).append(between)
    return {frame: np.array(heads) for frame, heads in found_heads.items()}


def draw(
    pixels: RGBArray, scene: Scene, tracks: dict[int, tuple[int, float, float]], limit_m: float, faces: str,
    hidden: FloatArray | None = None, doubtful: Collection[int] = (),
) -> RGBArray:  # fmt: skip
    """Return a frame with boxes, track numbers and distances below a limit; heads pixelated unless `faces` shows.

    hidden: circles (x, y, radius) of heads that were not found in this frame, shape (n, 3). doubtful: numbers of tracks
    that get a question mark.
    """
    heads = _heads(scene.people)
    heads = heads if hidden is None else np.concatenate([heads, hidden])
    picture = pixels.copy() if faces == "show" else pixelated(pixels, heads)
    size = max(0.4, pixels.shape[0] / 1100)
    feet = {row: _foot(scene.people, row) for row in tracks}
    rows = sorted(tracks)
    written: list[tuple[int, int]] = []
    for a, b, gap in _nearest(tracks, limit_m):
        x, y = (feet[a][0] + feet[b][0]) // 2, (feet[a][1] + feet[b][1]) // 2 + round(28 * size)
        while any(abs(x - u) < 90 * size and abs(y - v) < 26 * size for u, v in written):
            y += round(26 * size)  # below the one that stands there
        written.append((x, y))
        cv2.line(picture, feet[a], feet[b], _NEAR, 2, cv2.LINE_AA)
        _write(picture, f"{gap:.1f} m", (x, y), _NEAR, size)
    for row in rows:
        box = scene.people.boxes_px[row]
        number = tracks[row][0]
        colour = _COLOURS[number % len(_COLOURS)]
        if np.isfinite(box).all():
            x0, y0, x1, y1 = (int(v) for v in box)
            cv2.rectangle(picture, (x0, y0), (x1, y1), colour, 2)
            mark = VAGUE_MARK if number in doubtful else ""
            _write(picture, f"{number}{mark}", (x0, y0 - 4), colour, size)
    return picture


def _nearest(tracks: dict[int, tuple[int, float, float]], limit_m: float) -> list[tuple[int, int, float]]:
    """Return each person's nearest other within the limit, each pair once: all pairs of a crowd cannot be read."""
    found: set[tuple[int, int, float]] = set()
    for a, (_, x, y) in tracks.items():
        gaps = [(float(np.hypot(x - u, y - v)), b) for b, (_, u, v) in tracks.items() if b != a]
        gap, b = min(gaps, default=(np.inf, a))
        if gap <= limit_m:
            found.add((min(a, b), max(a, b), gap))
    return sorted(found)


def _heads(people: People) -> np.ndarray:
    """Return circles about all heads, a little larger than in photos: a moving head is blurred anyway."""
    heads = heads_px(people)
    heads[:, 2] *= 1 + _MARGIN
    return heads


def _foot(people: People, row: int) -> tuple[int, int]:
    x0, _, x1, y1 = np.nan_to_num(people.boxes_px[row])
    return int((x0 + x1) / 2), int(y1)


def _write(picture: RGBArray, text: str, at: tuple[int, int], colour: tuple[int, int, int], size: float) -> None:
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, (255, 255, 255), 3, cv2.LINE_AA)
    cv2.putText(picture, text, at, cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)
