"""Our YOLOX + RTMPose-type pipeline and rtmlib's, on the same network files, in one run.

    python -m venv DIR && DIR/bin/pip install . rtmlib onnx onnxruntime
    DIR/bin/python benchmarks/rtmlib_side_by_side.py --photos DIR --models DIR

rtmlib and onnx are needed for this script alone. The models' folder holds yolox_nano.onnx and tinypose_256x192.onnx;
the latter's heatmaps are turned into RTMPose's form, two SimCC vectors a joint, by nodes added to its graph, so that
both libraries decode what RTMPose networks answer. A ready RTMPose file is taken with --pose FILE instead.

rtmlib counts positions from the middle of a pixel and we from its corner: half a pixel is taken off before comparing.
It is given BGR for the detector and RGB for the pose network, as these networks want, and people's boxes alone.
"""

from __future__ import annotations

import argparse
import dataclasses
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import rtmlib
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from proxemetry.photo import EXTENSIONS, Photo
from proxemetry.pose import PoseOptions
from proxemetry.pose.heads import HEADS
from proxemetry.pose.onnx_backend import OnnxBackend
from proxemetry.pose.specification import Specification, read_specification

FloatArray = NDArray[np.float64]

_SIZE, _DETECTOR_SIZE = (192, 256), (416, 416)
_SCORE, _OVERLAP = 0.3, 0.5
#: A joint is compared where both give it at least this score.
_SEEN = 0.3


def with_simcc(heatmaps: Path, target: Path) -> Path:
    """Write a heatmap network whose answer is two SimCC vectors: maxima along rows and columns, eight bins a cell."""
    model = onnx.load(str(heatmaps))
    graph = model.graph
    maps = graph.output[0].name
    # cubic, as a straight line between two cells never is higher than both, and two axes for it is four-dimensional
    for name, axis, scale in (("simcc_x", 2, [1, 1, 1, 8]), ("simcc_y", 3, [1, 1, 8, 1])):
        graph.initializer.append(numpy_helper.from_array(np.array(scale, np.float32), f"{name}_scale"))
        graph.initializer.append(numpy_helper.from_array(np.array([axis], np.int64), f"{name}_axis"))
        nodes = (
            ("ReduceMax", [maps], f"{name}_cells", {"axes": [axis], "keepdims": 1}),
            (
                "Resize", [f"{name}_cells", "", f"{name}_scale"], f"{name}_bins",
                {"mode": "cubic", "coordinate_transformation_mode": "asymmetric"},
            ),
            ("Squeeze", [f"{name}_bins", f"{name}_axis"], name, {}),
        )  # fmt: skip
        for kind, inputs, output, attributes in nodes:
            graph.node.append(helper.make_node(kind, inputs, [output], **attributes))
    del graph.output[:]
    for name, bins in (("simcc_x", 384), ("simcc_y", 512)):
        graph.output.append(helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, 17, bins]))
    onnx.save(model, str(target))
    return target


def whole_bins(outputs: list[NDArray[np.float32]], size: tuple[int, int]) -> tuple[FloatArray, FloatArray]:
    """Decode SimCC as rtmlib does: the largest bin, half a pixel wide, and the mean of both heights."""
    tops = np.stack([outputs[0].argmax(axis=2), outputs[1].argmax(axis=2)], axis=-1)
    return tops / 2 + 0.5, (outputs[0].max(axis=2) + outputs[1].max(axis=2)).clip(0, 2) / 2


HEADS["simcc-whole-bins"] = whole_bins


def our_pipeline(folder: Path, decode: str = "simcc") -> OnnxBackend:
    """Return our pipeline over the folder's files, looking at the whole photo once, as rtmlib does."""
    ready = read_specification("yolox-tinypose")
    assert ready.pose is not None
    spec: Specification = dataclasses.replace(
        ready,
        folder=folder,
        detector=dataclasses.replace(ready.detector, score=_SCORE, overlap=_OVERLAP, tiles=(1.0,)),
        pose=dataclasses.replace(ready.pose, file="simcc.onnx", decode=decode),
    )
    return OnnxBackend(spec, PoseOptions(threads=2))


class TheirPipeline:
    """rtmlib's detector and pose network, chained as its own solutions chain them."""

    def __init__(self, folder: Path) -> None:
        self.detector = rtmlib.YOLOX(
            str(folder / "yolox_nano.onnx"), _DETECTOR_SIZE, det_mode="multiclass", nms_thr=_OVERLAP, score_thr=_SCORE,
            backend="onnxruntime",
        )  # fmt: skip
        self.pose = rtmlib.RTMPose(str(folder / "simcc.onnx"), _SIZE, backend="onnxruntime")

    def __call__(self, pixels: NDArray[np.uint8]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return boxes, joints and scores."""
        boxes, classes = self.detector(np.ascontiguousarray(pixels[..., ::-1]))
        people = [box for box, kind in zip(boxes, classes, strict=True) if kind == 0]
        return np.reshape(people, (-1, 4)), *self.joints(pixels, people)

    def joints(self, pixels: NDArray[np.uint8], boxes: Any) -> tuple[FloatArray, FloatArray]:
        """Return joints and scores of the boxes; of the whole photo where there are none, which is rtmlib's way."""
        points, scores = self.pose(pixels, list(boxes))
        return np.asarray(points, float), np.asarray(scores, float)


def milliseconds(task: Callable[[], Any], rounds: int) -> float:
    """Return the shortest time of several."""
    shortest = np.inf
    for _ in range(rounds):
        started = time.perf_counter()
        task()
        shortest = min(shortest, time.perf_counter() - started)
    return 1000 * shortest


def main() -> None:
    """Print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    parser.add_argument("--models", type=Path, default=Path("../shared/models"))
    parser.add_argument("--pose", type=Path, help="an RTMPose file for 256 x 192, instead of the converted one")
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shutil.copyfile(args.models / "yolox_nano.onnx", folder / "yolox_nano.onnx")
        if args.pose:
            shutil.copyfile(args.pose, folder / "simcc.onnx")
        else:
            with_simcc(args.models / "tinypose_256x192.onnx", folder / "simcc.onnx")
        compare(
            our_pipeline(folder),
            our_pipeline(folder, "simcc-whole-bins"),
            TheirPipeline(folder),
            args.photos,
            args.rounds,
        )


def compare(ours: OnnxBackend, coarse: OnnxBackend, theirs: TheirPipeline, folder: Path, rounds: int) -> None:
    """Print how the joints differ, on the same boxes and through both pipelines, how long both take, and phantoms."""
    same_reading: list[FloatArray] = []
    same_boxes: list[FloatArray] = []
    in_input: list[FloatArray] = []
    pipelines: list[FloatArray] = []
    our_ms, their_ms = [], []
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in EXTENSIONS):
        photo = Photo.open(path)
        photo = Photo.from_array(photo.pixels())  # decoding is not compared
        pixels = photo.pixels()
        people = ours.detect(photo)
        our_ms.append(milliseconds(lambda photo=photo: ours.detect(photo), rounds))
        their_ms.append(milliseconds(lambda pixels=pixels: theirs(pixels), rounds))
        if not len(people):
            continue
        points, scores = theirs.joints(pixels, people.boxes_px)
        gaps = np.linalg.norm(people.keypoints_px - 0.5 - points, axis=-1)
        seen = (people.scores >= _SEEN) & (scores >= _SEEN)
        sides = people.boxes_px[:, 2:] - people.boxes_px[:, :2]
        per_input_px = np.maximum(sides[:, 0] * 1.25 / _SIZE[0], sides[:, 1] * 1.25 / _SIZE[1])
        same_boxes.append(gaps[seen])
        read_alike = coarse.detect(photo)
        points, scores = theirs.joints(pixels, read_alike.boxes_px)
        alike = (read_alike.scores >= _SEEN) & (scores >= _SEEN)
        same_reading.append(np.linalg.norm(read_alike.keypoints_px - 0.5 - points, axis=-1)[alike])
        in_input.append((gaps / per_input_px[:, None])[seen])
        boxes, points, scores = theirs(pixels)
        for row, box in enumerate(people.boxes_px):
            near = np.abs(boxes - box).max(axis=1) if len(boxes) else np.array([np.inf])
            if near.min() < 0.02 * max(sides[row]):
                other = int(near.argmin())
                both = (people.scores[row] >= _SEEN) & (scores[other] >= _SEEN)
                pipelines.append(np.linalg.norm(people.keypoints_px[row] - 0.5 - points[other], axis=-1)[both])
    print("distance between both libraries' joints     n    median    95 %   within 1 px")
    for label, values in (
        ("same boxes, both read at whole bins", same_reading),
        ("same boxes, pixels of the photo", same_boxes),
        ("same boxes, pixels of the input", in_input),
        ("own boxes, pixels of the photo", pipelines),
    ):  # fmt: skip
        gaps = np.concatenate(values)
        figures = f"{np.median(gaps):9.2f} {np.quantile(gaps, 0.95):7.2f} {(gaps <= 1).mean():9.1%}"
        print(f"{label:38s} {len(gaps):6d} {figures}")
    print(f"milliseconds a photo: ours {np.mean(our_ms):.0f}, rtmlib {np.mean(their_ms):.0f}")
    empty = np.full((480, 640, 3), 128, np.uint8)
    _, phantoms, _ = theirs(empty)
    print(f"people on an empty photo: ours {len(ours.detect(Photo.from_array(empty)))}, rtmlib {len(phantoms)}")


if __name__ == "__main__":
    main()
