"""Networks in 8 bits: the same answers but for rounding, in the larger convolutions alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.errors import ModelError
from proxemetry.pose.litert import interpreter
from proxemetry.pose.onnx.network import Network
from proxemetry.pose.onnx.specification import READY, read_specification
from proxemetry.weights.conversion import tflite
from proxemetry.weights.conversion.eight_bits import LEAST_WEIGHTS, in_eight_bits
from proxemetry.weights.conversion.flatbuffer import Floats, Longs, Number, Table, Writer, written

SIDE = 4


def _answers(content: bytes, image: np.ndarray) -> list[np.ndarray]:
    network = interpreter(content, 1, "test")
    network.set_tensor(network.get_input_details()[0]["index"], image)
    network.invoke()
    return [network.get_tensor(detail["index"]) for detail in network.get_output_details()]


def _weights_of(content: bytes) -> list[dict]:
    """Return what the runtime reads of the tensors that are in 8 bits."""
    return [t for t in interpreter(content, 1, "test").get_tensor_details() if t["dtype"] is np.int8]


def _random(seed: int, *shape: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=shape).astype(np.float32)


def _one_layer(weights: np.ndarray, *, depthwise: bool = False) -> bytes:
    network = tflite.Network()
    image = network.input((1, SIDE, SIDE, weights.shape[3]))
    bias = np.zeros(weights.shape[3] if depthwise else weights.shape[0], np.float32)
    return network.written([network.convolution(image, weights, bias, depthwise=depthwise)])


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 1000), st.sampled_from([1, 3]), st.integers(4, 40), st.integers(-6, 6))
def test_answers_differ_by_no_more_than_rounding(seed, kernel, channels, power):
    weights = _random(seed, channels, kernel, kernel, 64) * 10.0**power
    weights *= np.geomspace(0.01, 100, channels, dtype=np.float32)[:, None, None, None]
    image = _random(seed + 1, 1, SIDE, SIDE, 64)
    content = _one_layer(weights)
    exact, rounded = (_answers(form, image)[0].astype(float) for form in (content, in_eight_bits(content)))
    # half a step of each weight, half a step of each number that comes in, and both
    weight_step = np.abs(weights).reshape(channels, -1).max(axis=1) / 127
    step = (max(image.max(), 0) - min(image.min(), 0)) / 255
    of_weights = 0.5 * weight_step * np.abs(image).sum()
    of_image = 0.5 * step * (np.abs(weights).reshape(channels, -1).sum(axis=1) + 0.5 * weight_step * weights[0].size)
    assert (np.abs(rounded - exact).max(axis=(0, 1, 2)) <= of_weights + 1.02 * of_image).all()
    # and on the whole by far less
    usual = np.sqrt((weights.astype(float) ** 2).sum(axis=(1, 2, 3)) * (image**2).mean())
    assert np.sqrt((((rounded - exact) / usual) ** 2).mean()) < 0.02
    assert not np.array_equal(rounded, exact)


def test_each_output_channel_has_its_own_scale():
    weights = _random(1, 40, 3, 3, 36)
    weights[7] = 0
    (narrow,) = _weights_of(in_eight_bits(_one_layer(weights)))
    scales = narrow["quantization_parameters"]["scales"]
    expected = np.abs(weights).reshape(40, -1).max(axis=1) / 127
    expected[7] = 1
    assert narrow["shape"].tolist() == [40, 3, 3, 36]
    assert scales == pytest.approx(expected, rel=1e-6)
    assert (narrow["quantization_parameters"]["zero_points"] == 0).all()
    assert narrow["quantization_parameters"]["quantized_dimension"] == 0


@pytest.mark.parametrize("shape", [(64, 1, 1, LEAST_WEIGHTS - 1), (64, 3, 3, LEAST_WEIGHTS // 9)])
def test_small_convolutions_stay_to_the_byte(shape):
    content = _one_layer(_random(2, *shape))
    assert in_eight_bits(content) == content


def test_depthwise_convolutions_stay_to_the_byte():
    content = _one_layer(_random(2, 1, 3, 3, 64), depthwise=True)
    assert in_eight_bits(content) == content


@pytest.mark.parametrize("shape", [(8, 1, 1, LEAST_WEIGHTS), (8, 3, 3, LEAST_WEIGHTS // 9 + 1)])
def test_larger_ones_do_not(shape):
    assert len(_weights_of(in_eight_bits(_one_layer(_random(2, *shape))))) == 1


def test_weights_that_two_layers_share_stay():
    class Sharing(tflite.Network):
        """Two layers with one tensor of weights."""

        def constant(self, values):
            if values.ndim < 4:
                return super().constant(values)
            self.shared = getattr(self, "shared", None) or super().constant(values)
            return self.shared

    network, weights, bias = Sharing(), _random(3, 64, 1, 1, 64), np.zeros(64)
    x = network.convolution(network.input((1, SIDE, SIDE, 64)), weights, bias)
    content = network.written([network.convolution(x, weights, bias)])
    assert in_eight_bits(content) == content


def test_weights_stored_in_sixteen_bits_and_widened_are_the_same_network(monkeypatch):
    weights = _random(4, 2, 64, 1, 1, 64).astype(np.float16).astype(np.float32)
    image = _random(5, 1, SIDE, SIDE, 64)
    monkeypatch.setitem(tflite.TYPES, "float16", 1)
    monkeypatch.setitem(tflite.OPERATORS, "dequantize", (6, 0))

    class Halved(tflite.Network):
        """Its weights are stored as upstream's float16 files have them."""

        def constant(self, values):
            if values.ndim < 4:
                return super().constant(values)
            return self._one("dequantize", [super().constant(values.astype(np.float16))], values.shape, None, "float32")

    def network(kind: type[tflite.Network]) -> bytes:
        made = kind()
        x = made.input((1, SIDE, SIDE, 64))
        for one in weights:
            x = made.convolution(x, one, np.ones(64), activation="relu")
        return in_eight_bits(made.written([x, made.function("sigmoid", x)]))

    plain, halved = network(tflite.Network), network(Halved)
    assert len(_weights_of(plain)) == len(_weights_of(halved)) == 2
    assert "DEQUANTIZE" not in {op["op_name"] for op in interpreter(halved, 1, "test")._get_ops_details()}
    for one, other in zip(_answers(plain, image), _answers(halved, image), strict=True):
        assert np.array_equal(one, other)


@pytest.mark.parametrize("content", [b"", b"TFL3", b"\0" * 8 + b"\xff" * 40, written(Table({0: Number(3)}), b"TFL3")])
def test_another_file_is_said_to_be_none(content):
    with pytest.raises(ModelError, match="TensorFlow Lite"):
        in_eight_bits(content)


def test_a_damaged_file_is_named_and_takes_no_memory(tmp_path: Path):
    content = bytearray(_one_layer(_random(8, 8, 1, 1, 64)))
    path = tmp_path / "network.tflite"
    for place in range(8, min(len(content), 600), 4):
        damaged = content.copy()
        damaged[place : place + 4] = b"\xff\xff\xff\x7f"
        path.write_bytes(damaged)
        try:
            with np.errstate(invalid="ignore"):  # weights that are no numbers
                in_eight_bits(bytes(damaged))
        except ModelError:
            with pytest.raises(ModelError, match=r"network\.tflite"):
                Network(path, eight_bits=True)


def test_the_runtime_computes_in_eight_bits_where_the_specification_asks_for_it(tmp_path: Path):
    path, image = tmp_path / "network.tflite", _random(6, 1, SIDE, SIDE, 64)
    path.write_bytes(_one_layer(_random(7, 40, 1, 1, 64)))
    full, narrow = Network(path), Network(path, eight_bits=True)
    assert (full.provider, narrow.provider) == ("LiteRT CPU", "LiteRT CPU, 8 bits")
    assert full.sha256 == narrow.sha256
    assert np.array_equal(full.run_one(image)[0], _answers(path.read_bytes(), image)[0])
    assert np.array_equal(narrow.run_one(image)[0], _answers(in_eight_bits(path.read_bytes()), image)[0])


def test_nanodet_and_movenet_alone_compute_in_eight_bits():
    asked = {name: read_specification(name).in_eight_bits for name in READY}
    assert {name: files for name, files in asked.items() if files} == {
        "nanodet-movenet": {"nanodet_g.tflite", "movenet_thunder.tflite"}
    }


def test_vectors_of_wide_numbers_lie_where_they_are_wanted():
    for before in range(1, 9):
        writer = Writer(b"\0" * before)
        begin = writer.value(Longs([5, -6])) + 4
        assert begin % 8 == 0
        assert np.frombuffer(bytes(writer.content[begin:]), "<i8").tolist() == [5, -6]
        begin = writer.value(Floats([0.5])) + 4
        assert np.frombuffer(bytes(writer.content[begin:]), "<f4").tolist() == [0.5]
