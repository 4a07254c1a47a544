"""Networks converted on the user's machine: LiteRT then computes what the original says, and it is always one file."""

from __future__ import annotations

import base64
import hashlib
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from proxemetry import weights
from proxemetry.errors import ModelError
from proxemetry.pose.litert import interpreter
from proxemetry.weights.conversion import ncnn, onnx, tfjs, tflite
from proxemetry.weights.conversion.flatbuffer import Bytes, Ints, Number, Table, Tables, written
from synthetic.network_files import Graph

MODELS = Path(__file__).resolve().parents[2] / "shared" / "models"
RNG = np.random.default_rng(3)


def _run(content: bytes, image: np.ndarray) -> list[np.ndarray]:
    network = interpreter(content, 1, "test")
    network.set_tensor(network.get_input_details()[0]["index"], image.astype(np.float32))
    network.invoke()
    return [network.get_tensor(detail["index"]) for detail in network.get_output_details()]


def _convolved(x: np.ndarray, weights_: np.ndarray, bias: np.ndarray, stride: int, pad: int, groups: int) -> np.ndarray:
    """The textbook convolution of (C, H, W) by (out, in, k, k)."""
    x = np.pad(x, ((0, 0), (pad, pad), (pad, pad)))
    out, per_group, kernel, _ = weights_.shape
    sides = [(side - kernel) // stride + 1 for side in x.shape[1:]]
    answer = np.empty((out, *sides))
    for o in range(out):
        first = o // (out // groups) * per_group
        for i in range(sides[0]):
            for j in range(sides[1]):
                part = x[first : first + per_group, i * stride : i * stride + kernel, j * stride : j * stride + kernel]
                answer[o, i, j] = (part * weights_[o]).sum() + bias[o]
    return answer


# --- FlatBuffers and the schema


def test_the_layout_is_that_of_the_encoding_to_the_byte():
    table = Table({0: Number(7, "b"), 2: Ints([1, -1]), 3: Bytes(b"abc")})
    content = written(table, b"TEST")
    assert content[4:8] == b"TEST"
    root = struct.unpack_from("<I", content)[0]
    layout = root - struct.unpack_from("<i", content, root)[0]
    size, table_size, *offsets = struct.unpack_from("<6H", content, layout)
    assert (size, table_size) == (12, 16)
    assert content[root + offsets[0]] == 7
    assert offsets[1] == 0  # left out: the default
    at = root + offsets[2]
    vector = at + struct.unpack_from("<I", content, at)[0]
    assert struct.unpack_from("<I2i", content, vector) == (2, 1, -1)
    at = root + offsets[3]
    vector = at + struct.unpack_from("<I", content, at)[0]
    assert content[vector : vector + 7] == struct.pack("<I", 3) + b"abc"


@pytest.mark.parametrize("alignment", [4, 16])
def test_bytes_lie_where_they_are_wanted(alignment):
    content = written(Table({0: Tables([Table({0: Bytes(b"x" * n, alignment)}) for n in range(1, 6)])}), b"TEST")
    for count in range(1, 6):
        at = content.index(struct.pack("<I", count) + b"x" * count)
        assert (at + 4) % alignment == 0


def test_numbers_of_operators_are_those_of_the_schema():
    schema = pytest.importorskip("ai_edge_litert.schema_py_generated")
    names = {
        "add": "ADD", "concatenation": "CONCATENATION", "conv": "CONV_2D", "depthwise": "DEPTHWISE_CONV_2D",
        "depth_to_space": "DEPTH_TO_SPACE", "sigmoid": "LOGISTIC", "max_pool": "MAX_POOL_2D", "multiply": "MUL",
        "relu": "RELU", "reshape": "RESHAPE", "bilinear": "RESIZE_BILINEAR", "pad": "PAD", "transpose": "TRANSPOSE",
        "subtract": "SUB", "divide": "DIV", "split": "SPLIT", "cast": "CAST", "argmax": "ARG_MAX", "squareroot": "SQRT",
        "pack": "PACK", "unpack": "UNPACK", "floor_divide": "FLOOR_DIV", "squared_difference": "SQUARED_DIFFERENCE",
        "slice": "SLICE", "leaky_relu": "LEAKY_RELU", "gather_nd": "GATHER_ND", "pad_with": "PADV2",
    }  # fmt: skip
    assert set(names) == set(tflite.OPERATORS)
    options = {
        "conv": "Conv2D", "depthwise": "DepthwiseConv2D", "max_pool": "Pool2D", "bilinear": "ResizeBilinear",
        "multiply": "Mul", "subtract": "Sub", "divide": "Div", "argmax": "ArgMax", "pad_with": "PadV2",
        "leaky_relu": "LeakyRelu", "floor_divide": "FloorDiv",
    }  # fmt: skip
    for ours, (code, kind) in tflite.OPERATORS.items():
        assert getattr(schema.BuiltinOperator, names[ours]) == code, ours
        if kind:
            name = options.get(ours) or "".join(word.capitalize() for word in ours.split("_"))
            assert getattr(schema.BuiltinOptions, f"{name}Options") == kind, ours


# --- ncnn


def _ncnn_weights(values: np.ndarray, half: bool) -> bytes:
    if not half:
        return struct.pack("<I", 0) + values.astype("<f4").tobytes()
    content = values.astype("<f2").tobytes()
    return struct.pack("<I", 0x01306B47) + content + b"\0" * (-len(content) % 4)


_NCNN = """7767517
13 15
Input image 0 1 image
Convolution c1 1 1 image a 0=4 1=3 3=2 4=1 5=1 6=108 9=1
Split s0 1 2 a a0 a1
ConvolutionDepthWise c2 1 1 a0 b 0=4 1=3 4=1 5=1 6=36 7=4
Slice s1 1 2 b b0 b1 -23300=2,-233,-233
Concat j 2 1 b1 b0 c
Reshape r1 1 1 c d 0=12 1=2 2=2
Permute p 1 1 d e 0=2
Reshape r2 1 1 e f 0=4 1=3 2=4
BinaryOp add 2 1 f a1 g
ReLU relu 1 1 g h
Interp up 1 1 h i 0=1 1=4.0 2=4.0
Convolution c3 1 1 i out 0=2 1=1 5=1 6=8
"""


def _ncnn_network(half: bool) -> tuple[bytes, list[np.ndarray]]:
    def numbers(*shape: int) -> np.ndarray:
        return RNG.normal(size=shape).astype(np.float16).astype(np.float32)

    parts = [numbers(4, 3, 3, 3), numbers(4), numbers(4, 1, 3, 3), numbers(4), numbers(2, 4, 1, 1), numbers(2)]
    content = b"".join(
        _ncnn_weights(w, half) + b.astype("<f4").tobytes() for w, b in zip(parts[::2], parts[1::2], strict=True)
    )
    return content, parts


@pytest.mark.parametrize("half", [True, False])
def test_ncnn_layers_are_the_textbooks(half):
    content, (w1, b1, w2, b2, w3, b3) = _ncnn_network(half)
    image = RNG.normal(size=(3, 6, 8))
    a = np.maximum(_convolved(image, w1, b1, 2, 1, 1), 0)
    b = _convolved(a, w2, b2, 1, 1, 4)
    shuffled = b[[2, 0, 3, 1]]  # halves exchanged (2, 3, 0, 1), then first and second of each group in turn
    up = np.maximum(shuffled + a, 0).repeat(4, axis=1).repeat(4, axis=2)
    expected = _convolved(up, w3, b3, 1, 0, 1)
    (found,) = _run(ncnn.converted(_NCNN.encode(), content, (8, 6)), image.transpose(1, 2, 0)[None])
    assert found.shape == (1, 2, 12, 16)
    assert np.allclose(found[0], expected, atol=1e-4)


def test_ncnn_files_that_are_damaged_or_of_another_kind_are_one_line():
    content, _ = _ncnn_network(True)
    for param, bin_ in (
        (_NCNN.replace("ReLU relu", "Sigmoid relu"), content), (_NCNN.replace("0=2\nReshape", "0=1\nReshape"), content),
        ("7767516\n" + _NCNN, content), (_NCNN, content[:-4]), (_NCNN, content + b"more"), ("", content),
    ):  # fmt: skip
        with pytest.raises(ModelError, match="ncnn"):
            ncnn.converted(param.encode(), bin_, (8, 6))


# --- ONNX


def test_an_onnx_detectors_slices_pools_and_heads_are_kept(tmp_path):
    ort = pytest.importorskip("onnxruntime")
    graph = Graph([1, 3, 16, 24])

    def every_other(row: int, column: int) -> str:
        rows = graph.op("Slice", graph.image, *(graph.whole(v) for v in (row, 1 << 60, 2, 2)))
        return graph.op("Slice", rows, *(graph.whole(v) for v in (column, 1 << 60, 3, 2)))

    focus = graph.op("Concat", *(every_other(r, c) for r, c in ((0, 0), (1, 0), (0, 1), (1, 1))), axis=1)
    w, b = graph.constant(RNG.normal(size=(6, 12, 3, 3))), graph.constant(RNG.normal(size=6))
    x = graph.op("Conv", focus, w, b, kernel_shape=[3, 3], pads=[1] * 4, strides=[1, 1])
    x = graph.op("Mul", x, graph.op("Sigmoid", x))
    dw, db = graph.constant(RNG.normal(size=(6, 1, 3, 3))), graph.constant(RNG.normal(size=6))
    small = graph.op("Conv", x, dw, db, kernel_shape=[3, 3], pads=[1] * 4, strides=[2, 2], group=6)
    pooled = graph.op("MaxPool", small, kernel_shape=[5, 5], pads=[2] * 4, strides=[1, 1])
    up = graph.op("Resize", pooled, "", graph.constant([1, 1, 2, 2]), mode="nearest", coordinate_transformation_mode="asymmetric", nearest_mode="floor")  # noqa: E501  # fmt: skip
    joined = graph.op("Concat", graph.op("Add", up, x), x, axis=1)
    flat = [graph.op("Reshape", t, graph.whole(1, c, -1)) for t, c in ((joined, 12), (graph.op("Concat", small, small, axis=1), 12))]  # noqa: E501  # fmt: skip
    answer = graph.op("Transpose", graph.op("Concat", *flat, axis=2), perm=[0, 2, 1])
    path = graph.save(tmp_path / "detector.onnx", [answer])
    image = RNG.normal(size=(1, 3, 16, 24)).astype(np.float32)
    (expected,) = ort.InferenceSession(str(path)).run(None, {"image": image})
    (found,) = _run(onnx.converted(path.read_bytes(), (24, 16)), image.transpose(0, 2, 3, 1))
    assert found.shape == expected.shape == (1, 96 + 24, 12)
    assert np.allclose(found, expected, atol=1e-4)


def test_an_onnx_layer_that_is_not_known_is_named(tmp_path):
    graph = Graph([1, 3, 16, 16])
    path = graph.save(tmp_path / "other.onnx", [graph.op("Softplus", graph.image)])
    with pytest.raises(ModelError, match="Softplus"):
        onnx.converted(path.read_bytes(), (16, 16))
    for content in (b"", b"no protocol buffer", path.read_bytes()[:-20]):
        with pytest.raises(ModelError, match="ONNX"):
            onnx.converted(content, (16, 16))


# --- TensorFlow.js


def _node(op: str, name: str, *inputs: str, **attributes: object) -> dict[str, object]:
    return {"op": op, "name": name, "input": list(inputs), "attr": attributes}


def _ints(*values: int) -> dict[str, object]:
    return {"list": {"i": [str(v) for v in values]}}


def _texts(*values: str) -> dict[str, object]:
    return {"list": {"s": [base64.b64encode(v.encode()).decode() for v in values]}}


def _tfjs(nodes: list[dict], constants: dict[str, np.ndarray], output: str) -> tuple[bytes, bytes]:
    table = [
        {"name": n, "shape": list(v.shape), "dtype": str(v.dtype)}
        | ({"quantization": {"dtype": "float16"}} if v.dtype == np.float32 else {})
        for n, v in constants.items()
    ]
    content = b"".join((v.astype("<f2") if v.dtype == np.float32 else v).tobytes() for v in constants.values())
    nodes = [*nodes, *({"op": "Const", "name": n} for n in constants)]
    graph = {
        "modelTopology": {"node": nodes}, "weightsManifest": [{"weights": table}],
        "signature": {"outputs": {"answer": {"name": output}}},
    }  # fmt: skip
    return json.dumps(graph).encode(), content


def _placeholder(*shape: int) -> dict[str, object]:
    return _node("Placeholder", "x", shape={"shape": {"dim": [{"size": str(s)} for s in shape]}})


def test_tensorflow_js_layers_are_the_textbooks():
    w = RNG.normal(size=(3, 3, 3, 2)).astype(np.float16).astype(np.float32)
    b = RNG.normal(size=2).astype(np.float16).astype(np.float32)
    padding = {"s": base64.b64encode(b"SAME").decode()}
    nodes = [
        _placeholder(1, 5, 7, 3),
        _node("_FusedConv2D", "conv", "x", "w", "b", strides=_ints(1, 1, 1, 1), padding=padding,
              fused_ops=_texts("BiasAdd", "Relu6")),
        _node("Reshape", "flat", "conv", "shape"),
        _node("ArgMax", "best", "flat", "axis", output_type={"type": "DT_INT32"}),
        _node("Cast", "number", "best", DstT={"type": "DT_FLOAT"}),
        _node("Identity", "out", "number"),
    ]  # fmt: skip
    constants = {"w": w, "b": b, "shape": np.array([1, 35, 2], np.int32), "axis": np.array(1, np.int32)}
    image = RNG.normal(size=(3, 5, 7))
    expected = np.clip(_convolved(image, w.transpose(3, 2, 0, 1), b, 1, 1, 1), 0, 6).reshape(2, 35).argmax(axis=1)
    (found,) = _run(tfjs.converted(*_tfjs(nodes, constants, "out")), image.transpose(1, 2, 0)[None])
    assert found.tolist() == [expected.tolist()]


def test_transpositions_to_and_fro_go():
    """A graph that takes (1, 3, H, W) and turns it around every layer, as NanoDet's does."""
    w = RNG.normal(size=(3, 3, 3, 4)).astype(np.float16).astype(np.float32)
    b = RNG.normal(size=4).astype(np.float16).astype(np.float32)
    padding = {"s": base64.b64encode(b"VALID").decode()}
    nodes = [
        _placeholder(1, 3, 6, 8),
        _node("Pad", "padded", "x", "pads"),
        _node("Transpose", "there", "padded", "last"),
        _node("Conv2D", "conv", "there", "w", strides=_ints(1, 2, 2, 1), padding=padding),
        _node("Add", "sum", "conv", "b"),
        _node("Transpose", "back", "sum", "first"),
        _node("LeakyRelu", "leaky", "back", alpha={"f": 0.1}),
        _node("PadV2", "around", "leaky", "pads", "least"),
        _node("Transpose", "there2", "around", "last"),
        _node("MaxPool", "pool", "there2", ksize=_ints(1, 3, 3, 1), strides=_ints(1, 1, 1, 1), padding=padding),
        _node("Transpose", "back2", "pool", "first"),
        _node("SplitV", "split", "back2", "lengths", "one"),
        _node("ConcatV2", "joined", "split:1", "split", "one"),
        _node("Reshape", "flat", "joined", "shape"),
        _node("Transpose", "out", "flat", "exchanged"),
    ]
    pads = np.array([[0, 0], [0, 0], [1, 1], [1, 1]], np.int32)
    constants = {
        "w": w, "b": b, "pads": pads, "last": np.array([0, 2, 3, 1], np.int32), "shape": np.array([1, 4, 12], np.int32),
        "first": np.array([0, 3, 1, 2], np.int32), "least": np.array(-60000, np.float32), "one": np.array(1, np.int32),
        "lengths": np.array([1, 3], np.int32), "exchanged": np.array([0, 2, 1], np.int32),
    }  # fmt: skip
    image = RNG.normal(size=(3, 6, 8))
    a = _convolved(image, w.transpose(3, 2, 0, 1), b, 2, 1, 1)
    a = np.where(a > 0, a, 0.1 * a)
    around = np.pad(a, ((0, 0), (1, 1), (1, 1)), constant_values=-np.inf)
    pooled = np.max([around[:, i : i + 3, j : j + 4] for i in range(3) for j in range(3)], axis=0)
    expected = pooled[[1, 2, 3, 0]].reshape(4, 12).T
    (found,) = _run(tfjs.converted(*_tfjs(nodes, constants, "out")), image.transpose(1, 2, 0)[None])
    assert np.allclose(found[0], expected, atol=1e-4)


def test_tensorflow_js_files_that_are_damaged_or_of_another_kind_are_one_line():
    graph, content = _tfjs([_placeholder(1, 4, 4, 3), _node("Tanh", "out", "x")], {}, "out")
    with pytest.raises(ModelError, match="Tanh"):
        tfjs.converted(graph, content)
    for damaged in (b"{", b"[]", graph[:-5], b'{"modelTopology": {}}'):
        with pytest.raises(ModelError, match=r"TensorFlow\.js"):
            tfjs.converted(damaged, content)
    with pytest.raises(ModelError, match="bytes"):
        tfjs.converted(graph, content + b"more")


# --- the real ones


def _real(*names: str) -> list[bytes]:
    paths = [MODELS / name for name in names]
    if not all(path.is_file() for path in paths):
        pytest.skip("the networks are not beside this checkout")
    return [path.read_bytes() for path in paths]


def _is_the_tables(content: bytes, name: str) -> bool:
    return hashlib.sha256(content).hexdigest() == weights.MODELS[name].sha256


def test_pp_tinypose_converted_is_the_tables_and_answers_as_its_onnx_file_does():
    param, content, _ = _real(
        "tinypose_ncnn/tinypose_256x192.param", "tinypose_ncnn/tinypose_256x192.bin", "tinypose_256x192.onnx"
    )
    made = ncnn.converted(param, content, (192, 256))
    assert _is_the_tables(made, "tinypose_256x192.tflite")
    _assert_alike(made, MODELS / "tinypose_256x192.onnx", RNG.normal(size=(1, 3, 256, 192)), 1e-5)


def test_yolox_converted_is_the_tables_and_answers_as_its_onnx_file_does():
    (content,) = _real("yolox_nano.onnx")
    made = onnx.converted(content, (416, 416))
    assert _is_the_tables(made, "yolox_nano.tflite")
    _assert_alike(made, MODELS / "yolox_nano.onnx", RNG.uniform(0, 255, size=(1, 3, 416, 416)), 1e-3)


def _assert_alike(made: bytes, original: Path, image: np.ndarray, tolerance: float) -> None:
    ort = pytest.importorskip("onnxruntime")
    session = ort.InferenceSession(str(original), providers=["CPUExecutionProvider"])
    (expected,) = session.run(None, {session.get_inputs()[0].name: image.astype(np.float32)})
    (found,) = _run(made, image.transpose(0, 2, 3, 1))
    assert np.abs(found - expected).max() < tolerance


def test_movenet_converted_is_the_tables():
    graph, content = _real("movenet/movenet-thunder.json", "movenet/movenet-thunder.bin")
    made = tfjs.converted(graph, content)
    assert _is_the_tables(made, "movenet_thunder.tflite")
    (points,) = _run(made, np.zeros((1, 256, 256, 3)))
    assert points.shape == (1, 1, 17, 3)
