"""Our YOLOX + RTMPose-type pipeline and rtmlib's, on the same network files, in one run.

    python -m venv DIR && DIR/bin/pip install . rtmlib onnx onnxruntime
    DIR/bin/python -m benchmarks.networks.rtmlib_side_by_side --photos DIR --models DIR

Only this script needs rtmlib and onnx. The models' folder holds yolox_nano.onnx and tinypose_256x192.onnx;
the latter's heatmaps are turned into RTMPose's form, two SimCC vectors a joint, by nodes added to its graph, so that
both libraries decode RTMPose's form of output. --pose FILE takes a ready RTMPose file instead.

rtmlib counts positions from the middle of a pixel and we from its corner: half a pixel is subtracted before comparing.
It receives BGR for the detector and RGB for the pose network, as these networks need, and only people's boxes.
"""

from __future__ import annotations

import argparse
import dataclasses
import shutil
import tempfile
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import onnx
import rtmlib
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from proxemetry.arrays import FloatArray
from proxemetry.people import People
from proxemetry.photo import EXTENSIONS, Photo
from proxemetry.pose import PoseOptions
from proxemetry.pose.detections import Detections
from proxemetry.pose.onnx import letterbox
from proxemetry.pose.onnx.backend import OnnxBackend
from proxemetry.pose.onnx.letterbox import Placement
from proxemetry.pose.onnx.pose_decoders import HEADS
from proxemetry.pose.onnx.specification import Specification, read_specification

_SIZE, _DETECTOR_SIZE = (192, 256), (416, 416)
_SCORE, _OVERLAP = 0.3, 0.5
#: How far a box is moved, in pixels of the input.
_SHIFTS = ((0.0, 0.0), (0.5, 0.25), (0.25, 0.75), (0.75, 0.5))
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
        detector=dataclasses.replace(ready.detector, score=_SCORE, overlap=_OVERLAP, tiles=(1.0,), suspicion=0.0),
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


def plain_sampling() -> AbstractContextManager[object]:
    """Make our crops by one linear step, as rtmlib does, instead of averaging areas first."""

    def unshrunk(pixels: NDArray[np.uint8], region: Any, scale: Any) -> tuple[NDArray[np.uint8], Placement]:
        return pixels, Placement((0.0, 0.0), (1.0, 1.0))

    return mock.patch.object(letterbox, "_shrunk", unshrunk)


def gaps_on(people: People, theirs: TheirPipeline, pixels: NDArray[np.uint8]) -> tuple[FloatArray, FloatArray]:
    """Return how far our joints are from theirs on the same boxes, in pixels of the photo and of the input.

    Only where both see the joint. rtmlib's positions name pixels' middles: half a pixel is taken off ours.
    """
    points, scores = theirs.joints(pixels, people.boxes_px)
    gaps = np.linalg.norm(people.keypoints_px - 0.5 - points, axis=-1)
    seen = (people.scores >= _SEEN) & (scores >= _SEEN)
    return gaps[seen], (gaps / _per_input_px(people.boxes_px)[:, None])[seen]


def _per_input_px(boxes: FloatArray) -> FloatArray:
    sides = boxes[:, 2:] - boxes[:, :2]
    return np.maximum(sides[:, 0] * 1.25 / _SIZE[0], sides[:, 1] * 1.25 / _SIZE[1])


def wavering(joints: Callable[[FloatArray], FloatArray], people: People) -> FloatArray:
    """Return how far joints wander when their box is moved by parts of a pixel of the input, in such pixels.

    The answer is known: the photo stays, so the joints do. What they wander is what sampling the crop costs.
    """
    seen, unit = people.scores >= _SEEN, _per_input_px(people.boxes_px)[:, None]
    looks = [joints(people.boxes_px + np.tile(shift, 2) * unit) for shift in _SHIFTS]
    off = np.stack(looks) - np.mean(looks, axis=0)
    return (np.linalg.norm(off, axis=-1) / unit)[:, seen].ravel()


def compare(ours: OnnxBackend, coarse: OnnxBackend, theirs: TheirPipeline, folder: Path, rounds: int) -> None:
    """Print how the joints differ, on the same boxes and through both pipelines, how long both take, and phantoms."""
    rows: dict[str, list[FloatArray]] = {}
    our_ms, their_ms = [], []
    for path in sorted(p for p in folder.iterdir() if p.suffix.lower() in EXTENSIONS):
        photo = Photo.open(path)
        photo = Photo.from_array(photo.pixels())  # decoding is not compared
        pixels = photo.pixels()
        our_ms.append(milliseconds(lambda photo=photo: ours.detect(photo), rounds))
        their_ms.append(milliseconds(lambda pixels=pixels: theirs(pixels), rounds))
        with plain_sampling():
            alike = coarse.detect(photo)
        for label, people in (
            ("both read at whole bins, both skip pixels", alike),
            ("both read at whole bins", coarse.detect(photo)),
            ("ours as it is", ours.detect(photo)),
        ):
            if len(people):
                photo_px, input_px = gaps_on(people, theirs, pixels)
                rows.setdefault(f"{label}: pixels of the photo", []).append(photo_px)
                rows.setdefault(f"{label}: pixels of the input", []).append(input_px)
        people = ours.detect(photo)
        if len(people):
            for label, joints in (
                ("wandering with the box, rtmlib: pixels of the input", lambda b, p=pixels: theirs.joints(p, b)[0]),
                ("wandering with the box, ours: pixels of the input", lambda b, p=pixels: our_joints(ours, p, b)),
            ):
                rows.setdefault(label, []).append(wavering(joints, people))
    print(f"{'distance between joints':58s}      n   median    95 %   within 1 px")
    for label, values in rows.items():
        gaps = np.concatenate(values)
        figures = f"{np.median(gaps):8.3f} {np.quantile(gaps, 0.95):7.2f} {(gaps <= 1).mean():9.1%}"
        print(f"{label:58s} {len(gaps):6d} {figures}")
    print(f"milliseconds a photo, two threads: ours {np.mean(our_ms):.0f}, rtmlib {np.mean(their_ms):.0f}")
    empty = np.full((480, 640, 3), 128, np.uint8)
    _, phantoms, _ = theirs(empty)
    print(f"people on an empty photo: ours {len(ours.detect(Photo.from_array(empty)))}, rtmlib {len(phantoms)}")


def our_joints(ours: OnnxBackend, pixels: NDArray[np.uint8], boxes: FloatArray) -> FloatArray:
    """Return our joints of the boxes alone, whatever their scores."""
    return ours._keypoints(pixels, Detections(boxes, np.ones(len(boxes))))[0]  # pyright: ignore[reportPrivateUsage]


if __name__ == "__main__":
    main()
