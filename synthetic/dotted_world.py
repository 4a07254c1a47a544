"""A world of coloured dots, and back ends that see it: specifications of generated networks, one for each decoder."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .network_files import joints_network, one_stage_network, yolox_detector

_IMAGENET = "mean = [123.675, 116.28, 103.53]\nstd = [58.395, 57.12, 57.375]\n"

#: Where a figure's joints lie within its bounds, a row a joint, 0..1: no two closer than two dots.
FIGURE = np.array(
    [
        (0.5, 0.08), (0.8, 0.0), (0.2, 0.0), (1.0, 0.08), (0.0, 0.08), (0.95, 0.25), (0.05, 0.25), (1.0, 0.42),
        (0.0, 0.42), (0.9, 0.58), (0.1, 0.58), (0.7, 0.62), (0.3, 0.62), (0.75, 0.8), (0.25, 0.8), (0.8, 1.0),
        (0.2, 1.0),
    ]
)  # fmt: skip


def figure(x: float, y: float, width: float = 150, height: float = 250) -> np.ndarray:
    """A figure whose bounds have their middle at (x, y)."""
    return (FIGURE - 0.5) * (width, height) + (x, y)


#: In the letterbox (scale 1/2) the middles fall on the middles of stride-8 cells: 16 n + 8 in the photo.
PHOTO_SIZE = (832, 624)
PEOPLE = [figure(168, 200), figure(424, 328), figure(664, 360)]

HEADS = ("heatmap-msra", "heatmap-udp", "simcc")
ONE_STAGE = ("rtmo", "ultralytics-pose")


def specification(folder: Path, head: str = "heatmap-msra", batch: int | str = 1, more: str = "") -> str:
    """Write networks and the file that describes them as one back end; return its path. head: of either kind."""
    path = folder / "spec.toml"
    start = f'skeleton = "coco17"\nperson_score = 0.1\nkeypoint_score = 0.05\n{more}'
    if head in ONE_STAGE:
        one_stage_network(folder / "one.onnx", head)
        path.write_text(
            f'{start}[one_stage]\nfile = "one.onnx"\ndecode = "{head}"\nsize = [416, 416]\ncolours = "rgb"\n'
        )
        return str(path)
    yolox_detector(folder / "detector.onnx", 416, (75, 125))
    joints_network(folder / "pose.onnx", head, batch)
    path.write_text(
        f'{start}[detector]\nfile = "detector.onnx"\ndecode = "yolox"\ncolours = "bgr"\n'
        f'[pose]\nfile = "pose.onnx"\ndecode = "{head}"\n{_IMAGENET}'
    )
    return str(path)
