"""Keypoints out of a top-down network's raw answer: heatmaps and SimCC vectors, decoded below the size of a cell.

Decoders take the outputs for B crops and the input's (width, height) and return points of shape (B, K, 2), in the
input's continuous coordinates ((0, 0) is the outer corner of its top-left pixel), and scores of shape (B, K), 0..1.

Networks are trained on whole-numbered pixel positions, which name the middle of a pixel: decoded positions are moved
by half a pixel into the continuous frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import ModelError

#: DARK's smoothing: a Gaussian of two cells, eleven wide.
_BELL = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 2.0**2))
_KERNEL = _BELL / _BELL.sum()
Outputs = list[NDArray[np.float32]]


def decode_heatmaps_msra(outputs: Outputs, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Decode heatmaps drawn at position / stride (Xiao et al. 2018), as HRNet without UDP has them."""
    cells, scores = _refined_peaks(_maps(outputs))
    strides = np.array([size[0] / outputs[0].shape[3], size[1] / outputs[0].shape[2]])
    return cells * strides + 0.5, scores


def decode_heatmaps_udp(outputs: Outputs, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Decode heatmaps whose first and last cells are the input's first and last pixels (UDP, Huang et al. 2020)."""
    cells, scores = _refined_peaks(_maps(outputs))
    intervals = np.array([(size[0] - 1) / (outputs[0].shape[3] - 1), (size[1] - 1) / (outputs[0].shape[2] - 1)])
    return cells * intervals + 0.5, scores


def _maps(outputs: Outputs) -> NDArray[np.float32]:
    if outputs[0].ndim != 4:
        raise ModelError(f"the pose network returns {outputs[0].shape}: expected heatmaps (B, K, H, W)")
    return outputs[0]


def _refined_peaks(maps: NDArray[np.float32]) -> tuple[FloatArray, FloatArray]:
    """Return each map's peak in cells, shape (B, K, 2), and its height, shape (B, K).

    The logarithm of a Gaussian is a parabola: its top follows from the smoothed map's slope and curvature at the
    largest cell (DARK, Zhang et al. 2020, with their kernel for maps drawn two cells wide). A step of more than a cell
    means that there is no such top; it is cut.
    """
    count, joints, height, width = maps.shape
    flat = maps.reshape(count * joints, height, width)
    peak = flat.reshape(len(flat), -1).argmax(axis=1)
    scores = flat.reshape(len(flat), -1).max(axis=1)
    x, y = (peak % width).clip(1, width - 2), (peak // width).clip(1, height - 2)
    smooth = _smoothed_around(flat, x, y)

    def log(dx: int, dy: int) -> FloatArray:
        return np.log(np.maximum(smooth[:, 1 + dy, 1 + dx], 1e-6))

    centre, slope_x, slope_y = log(0, 0), (log(1, 0) - log(-1, 0)) / 2, (log(0, 1) - log(0, -1)) / 2
    bend_x, bend_y = log(1, 0) - 2 * centre + log(-1, 0), log(0, 1) - 2 * centre + log(0, -1)
    twist = (log(1, 1) - log(1, -1) - log(-1, 1) + log(-1, -1)) / 4
    determinant = bend_x * bend_y - twist**2
    is_top = (determinant > 1e-9) & (bend_x < 0)
    safe = np.where(is_top, determinant, 1.0)
    step_x = np.where(is_top, (twist * slope_y - bend_y * slope_x) / safe, 0.0).clip(-1, 1)
    step_y = np.where(is_top, (twist * slope_x - bend_x * slope_y) / safe, 0.0).clip(-1, 1)
    cells = np.stack([x + step_x, y + step_y], axis=-1).reshape(count, joints, 2)
    return cells, scores.reshape(count, joints).astype(float).clip(0.0, 1.0)


def _smoothed_around(maps: NDArray[np.float32], x: NDArray[np.intp], y: NDArray[np.intp]) -> FloatArray:
    """Return the maps' 3 x 3 cells around (x, y), smoothed, shape (N, 3, 3): only these are looked at."""
    reach = len(_KERNEL) // 2 + 1
    offsets = np.arange(-reach, reach + 1)
    rows, columns = (_reflected(at[:, None] + offsets, n) for at, n in ((y, maps.shape[1]), (x, maps.shape[2])))
    around = maps[np.arange(len(maps))[:, None, None], rows[:, :, None], columns[:, None, :]].astype(float)
    slide = np.stack([np.pad(_KERNEL, (k, 2 - k)) for k in range(3)])
    return slide @ around @ slide.T


def _reflected(index: NDArray[np.intp], length: int) -> NDArray[np.intp]:
    """Return indices mirrored at the map's first and last cells."""
    folded = np.abs(index) % max(2 * length - 2, 1)
    return np.where(folded < length, folded, 2 * length - 2 - folded)


def decode_simcc(outputs: Outputs, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Decode one vector an axis (SimCC, Li et al. 2022; RTMPose, Jiang et al. 2023), two bins a pixel as a rule.

    outputs: x of shape (B, K, bins across) and y of shape (B, K, bins down), in either order: x is the one whose
    length has the input's width. The score is the lower of both peaks: a joint is as sure as its unsurer axis.
    """
    if len(outputs) < 2 or outputs[0].ndim != 3 or outputs[1].ndim != 3:
        shapes = ", ".join(str(o.shape) for o in outputs)
        raise ModelError(f"the pose network returns {shapes}: expected two SimCC vectors (B, K, bins)")
    across, down = outputs[0], outputs[1]
    if across.shape[2] * size[1] != down.shape[2] * size[0] and down.shape[2] * size[1] == across.shape[2] * size[0]:
        across, down = down, across
    x, score_x = _refined_tops(across)
    y, score_y = _refined_tops(down)
    points = np.stack([x * size[0] / across.shape[2], y * size[1] / down.shape[2]], axis=-1) + 0.5
    return points, np.minimum(score_x, score_y).clip(0.0, 1.0)


def _refined_tops(vectors: NDArray[np.float32], reach: int = 3) -> tuple[FloatArray, FloatArray]:
    """Return each vector's top in bins and its height, both of shape (B, K).

    The top is that of the least-squares parabola through the `reach` bins either side of the largest: SimCC draws
    Gaussians about six bins wide, whose top a parabola fits to a few hundredths of a bin.
    """
    length = vectors.shape[2]
    peak = vectors.argmax(axis=2)
    middle = peak.clip(reach, length - 1 - reach)
    offsets = np.arange(-reach, reach + 1)
    window = np.take_along_axis(vectors, middle[..., None] + offsets, axis=2).astype(float)
    spread = offsets**2 - (offsets**2).mean()
    slope = (window * offsets).sum(axis=2) / (offsets**2).sum()
    bend = (window * spread).sum(axis=2) / (spread**2).sum()
    step = np.where(bend < -1e-12, -slope / np.minimum(2 * bend, -1e-12), 0.0)
    inside = np.abs(step) <= reach
    return np.where(inside, middle + step, peak), vectors.max(axis=2).astype(float)


def decode_movenet(outputs: Outputs, size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Decode single-pose MoveNet, which answers points: (B, 1, K, 3), y, x and score, fractions of the input."""
    if outputs[0].ndim != 4 or outputs[0].shape[1] != 1 or outputs[0].shape[3] != 3:
        raise ModelError(f"the pose network returns {outputs[0].shape}: expected points (B, 1, K, 3)")
    values = outputs[0][:, 0].astype(float)
    return values[..., [1, 0]] * size, values[..., 2].clip(0.0, 1.0)


HEADS = {
    "heatmap-msra": decode_heatmaps_msra,
    "heatmap-udp": decode_heatmaps_udp,
    "simcc": decode_simcc,
    "movenet": decode_movenet,
}
