"""Small networks with known answers, written byte by byte: ONNX graphs and Caffe weights are protocol buffers.

Nothing but numpy is needed, so that the tests depend on no model-building library.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

# Field numbers and types of onnx.proto and caffe.proto.
_VARINT, _LENGTH, _FIXED32 = 0, 2, 5
_FLOAT, _INT64 = 1, 7
_ATTRIBUTE_TYPES = {float: 1, int: 2, str: 3, "ints": 7}


def varint(value: int) -> bytes:
    value &= (1 << 64) - 1
    out = bytearray()
    while value > 0x7F:
        out.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*out, value])


def field(number: int, value: int | bytes | str | float) -> bytes:
    """One field of a message: whole numbers as varints, floats as fixed32, everything else with its length."""
    if isinstance(value, int):
        return varint(number << 3 | _VARINT) + varint(value)
    if isinstance(value, float):
        return varint(number << 3 | _FIXED32) + struct.pack("<f", value)
    content = value.encode() if isinstance(value, str) else value
    return varint(number << 3 | _LENGTH) + varint(len(content)) + content


def _joined(parts: Iterable[bytes]) -> bytes:
    return b"".join(parts)


class Graph:
    """An ONNX graph under construction: `op` adds a node and returns the name of its output."""

    def __init__(self, shape: Sequence[int | str], name: str = "image") -> None:
        self.image, self._shape = name, shape
        self._nodes: list[bytes] = []
        self._constants: list[bytes] = []
        self._count = 0

    def _name(self) -> str:
        self._count += 1
        return f"t{self._count}"

    def constant(self, values: object, dtype: type = np.float32) -> str:
        array, name = np.ascontiguousarray(values, dtype), self._name()
        self._constants.append(
            _joined(field(1, int(d)) for d in array.shape)
            + field(2, _FLOAT if array.dtype == np.float32 else _INT64)
            + field(8, name)
            + field(9, array.tobytes())
        )
        return name

    def whole(self, *values: int) -> str:
        return self.constant(np.array(values), np.int64)

    def op(self, kind: str, *inputs: str, **attributes: float | int | str | Sequence[int]) -> str:
        output = self._name()
        node = _joined(field(1, i) for i in inputs) + field(2, output) + field(4, kind)
        for key, value in attributes.items():
            node += field(5, field(1, key) + _attribute(value))
        self._nodes.append(node)
        return output

    def save(self, path: Path, outputs: Sequence[str], whole_numbers: Sequence[str] = ()) -> Path:
        graph = _joined(field(1, node) for node in self._nodes) + field(2, "test")
        graph += _joined(field(5, c) for c in self._constants)
        graph += field(11, _value(self.image, _FLOAT, self._shape))
        graph += _joined(field(12, _value(o, _INT64 if o in whole_numbers else _FLOAT, None)) for o in outputs)
        path.write_bytes(field(1, 8) + field(2, "tests") + field(8, field(2, 13)) + field(7, graph))
        return path


def _attribute(value: float | int | str | Sequence[int]) -> bytes:
    if isinstance(value, str):
        return field(4, value) + field(20, _ATTRIBUTE_TYPES[str])
    if isinstance(value, float):
        return field(2, value) + field(20, _ATTRIBUTE_TYPES[float])
    if isinstance(value, int):
        return field(3, value) + field(20, _ATTRIBUTE_TYPES[int])
    return _joined(field(8, int(v)) for v in value) + field(20, _ATTRIBUTE_TYPES["ints"])


def _value(name: str, kind: int, shape: Sequence[int | str] | None) -> bytes:
    tensor = field(1, kind)
    if shape is not None:
        dims = _joined(field(1, field(2, d) if isinstance(d, str) else field(1, d)) for d in shape)
        tensor += field(2, dims)
    return field(1, name) + field(2, field(1, tensor))


# A world of coloured dots: a dot of `PERSON` in the middle of each person, and one dot for each of the 17 joints.
SKY = (90, 90, 90)
PERSON = (255, 0, 255)
JOINT_COLOURS = np.array([(r, g, b) for r in (30, 140, 250) for g in (30, 140, 250) for b in (30, 250)][:17])
_TOLERANCE = 20.0


def dots(size: tuple[int, int], people: Sequence[np.ndarray], radius: float = 5.0) -> np.ndarray:
    """Draw people as joints of shape (17, 2), pixels, over an even background, sampled finely so that dots are round.

    A `PERSON` dot marks the middle of each person's joints' bounds.
    """
    import cv2

    fine = 4
    photo = np.full((size[1] * fine, size[0] * fine, 3), SKY, np.uint8)
    for joints in people:
        middle = (joints.min(axis=0) + joints.max(axis=0)) / 2
        for colour, at in [(PERSON, middle), *zip(JOINT_COLOURS.tolist(), joints, strict=True)]:
            # cv2 draws around the middle of a pixel: continuous position - 0.5, in 1/16 of a pixel
            centre = tuple(round((c * fine - 0.5) * 16) for c in at)
            cv2.circle(photo, centre, int(radius * fine * 16), colour, -1, cv2.LINE_AA, 4)
    return cv2.resize(photo, size, interpolation=cv2.INTER_AREA)


def _match(graph: Graph, image: str, colours: np.ndarray) -> str:
    """Return a map per colour, shape (B, K, H, W): 1 where the image has it, falling off as a Gaussian."""
    squares = graph.op("ReduceSum", graph.op("Mul", image, image), graph.whole(1), keepdims=1)
    weights = graph.constant(-2 * colours[:, :, None, None])
    products = graph.op("Conv", image, weights, graph.constant((colours**2).sum(axis=1)), kernel_shape=[1, 1])
    distance2 = graph.op("Add", products, squares)
    return graph.op("Exp", graph.op("Mul", distance2, graph.constant(np.float32(-0.5 / _TOLERANCE**2))))


def yolox_detector(path: Path, size: int, person_px: tuple[float, float], colours: str = "bgr") -> Path:
    """Write a detector with YOLOX's raw head: a box of `person_px` around each cell whose middle shows `PERSON`."""
    graph = Graph([1, 3, size, size])
    wanted = np.array([PERSON[::-1] if colours == "bgr" else PERSON], float)
    shown = _match(graph, graph.image, wanted)
    heads = []
    for stride in (8, 16, 32):
        ends = np.iinfo(np.int64).max
        at = graph.op(
            "Slice", shown, graph.whole(stride // 2, stride // 2), graph.whole(ends, ends), graph.whole(2, 3),
            graph.whole(stride, stride),
        )  # fmt: skip
        cells = (size // stride) ** 2
        seen = graph.op("Reshape", at, graph.whole(1, cells, 1))
        seen = graph.op("Mul", seen, graph.constant(np.float32(1.0 if stride == 8 else 0.0)))
        where = np.concatenate(
            [np.full((1, cells, 2), 0.5), np.log(np.full((1, cells, 2), person_px) / stride)], axis=2
        )
        classes = np.zeros((1, cells, 80))
        classes[..., 0], classes[..., 14] = 0.9, 0.18  # a person, and a bird a fifth as likely
        heads.append(graph.op("Concat", graph.constant(where), seen, graph.constant(classes), axis=2))
    return graph.save(path, [graph.op("Concat", *heads, axis=1)])


def joints_network(path: Path, head: str, batch: int | str = 1, size: tuple[int, int] = (192, 256)) -> Path:
    """Write a top-down network that finds `JOINT_COLOURS` in ImageNet-normalised RGB; head as in `heads.HEADS`."""
    graph = Graph([batch, 3, size[1], size[0]])
    std, mean = ([58.395, 57.12, 57.375], [123.675, 116.28, 103.53])
    image = graph.op("Mul", graph.image, graph.constant(np.reshape(std, (1, 3, 1, 1))))
    image = graph.op("Add", image, graph.constant(np.reshape(mean, (1, 3, 1, 1))))
    shown = _match(graph, image, JOINT_COLOURS.astype(float))
    if head == "heatmap-msra":  # cell j looks at pixels 4 j - 4 ... 4 j + 4: its middle is pixel 4 j
        return graph.save(path, [_blurred(graph, shown, 9, stride=4)])
    soft = _blurred(graph, _blurred(graph, shown, 9), 5)
    if head == "heatmap-udp":
        cells = graph.op(
            "Resize", soft, "", graph.constant([1, 1, 0.25, 0.25]), mode="linear",
            coordinate_transformation_mode="align_corners",
        )  # fmt: skip
        return graph.save(path, [cells])
    across = graph.op("ReduceMax", soft, axes=[2], keepdims=0)
    down = graph.op("ReduceMax", soft, axes=[3], keepdims=0)
    doubled = [
        graph.op("Resize", v, "", graph.constant([1, 1, 2]), mode="linear", coordinate_transformation_mode="asymmetric")
        for v in (across, down)
    ]
    return graph.save(path, doubled)


def _blurred(graph: Graph, maps: str, width: int, stride: int = 1) -> str:
    half = width // 2
    return graph.op(
        "AveragePool", maps, kernel_shape=[width, width], strides=[stride, stride], pads=[half] * 4, count_include_pad=1
    )


def constant_network(path: Path, size: tuple[int, int], *answers: np.ndarray) -> Path:
    """Write a network that answers the same whatever it sees; whole-numbered answers stay so."""
    graph = Graph([1, 3, size[1], size[0]])
    nothing = graph.op("Mul", graph.op("ReduceMean", graph.image, keepdims=0), graph.constant(np.float32(0)))
    outputs, whole = [], []
    for answer in answers:
        if answer.dtype == np.int64:
            outputs.append(graph.op("Identity", graph.constant(answer, np.int64)))
            whole.append(outputs[-1])
        else:
            outputs.append(graph.op("Add", graph.constant(answer), nothing))
    return graph.save(path, outputs, whole)


def one_stage_network(path: Path, decode: str, size: int = 416, people: int = 3) -> Path:
    """Write a network that finds people and joints in one look: one person in each of so many upright strips.

    decode: "rtmo" or "ultralytics-pose". A strip without a `PERSON` dot answers with a score near 0.
    """
    graph = Graph([1, 3, size, size])
    joints = _blurred(graph, _match(graph, graph.image, JOINT_COLOURS.astype(float)), 5)
    middles = _match(graph, graph.image, np.array([PERSON], float))
    boxes, points = [], []
    for number in range(people):
        left, right = (round(size * k / people) for k in (number, number + 1))

        def strip(maps: str, left: int = left, right: int = right) -> str:
            return graph.op("Slice", maps, graph.whole(left), graph.whole(right), graph.whole(3))

        seen = strip(joints)
        places = []
        for axis, offset in ((2, left), (3, 0)):  # the largest along the other axis leaves x, then y
            line = graph.op("ReduceMax", seen, axes=[axis], keepdims=0)
            best = graph.op("Cast", graph.op("ArgMax", line, axis=2, keepdims=1), to=_FLOAT)
            places.append(graph.op("Add", best, graph.constant(np.float32(offset))))
        joint_scores = graph.op("ReduceMax", graph.op("ReduceMax", seen, axes=[3], keepdims=0), axes=[2], keepdims=1)
        at = graph.op("Concat", *places, axis=2)
        score = graph.op("ReduceMax", strip(middles), axes=[1, 2, 3], keepdims=0)
        corners = [graph.op(kind, at, axes=[1], keepdims=0) for kind in ("ReduceMin", "ReduceMax")]
        if decode == "ultralytics-pose":
            low, high = corners
            half = graph.constant(np.float32(0.5))
            corners = [
                graph.op("Mul", graph.op("Add", low, high), half),
                graph.op("Sub", high, low),
            ]
        boxes.append(graph.op("Concat", *corners, graph.op("Reshape", score, graph.whole(1, 1)), axis=1))
        points.append(graph.op("Concat", at, joint_scores, axis=2))
    if decode == "rtmo":
        rows = [graph.op("Reshape", b, graph.whole(1, 1, 5)) for b in boxes]
        bodies = [graph.op("Reshape", p, graph.whole(1, 1, len(JOINT_COLOURS), 3)) for p in points]
        return graph.save(path, [graph.op("Concat", *rows, axis=1), graph.op("Concat", *bodies, axis=1)])
    columns = []
    for box, person in zip(boxes, points, strict=True):
        flat = graph.op("Reshape", person, graph.whole(1, 3 * len(JOINT_COLOURS)))
        columns.append(graph.op("Reshape", graph.op("Concat", box, flat, axis=1), graph.whole(1, -1, 1)))
    return graph.save(path, [graph.op("Concat", *columns, axis=2)])
