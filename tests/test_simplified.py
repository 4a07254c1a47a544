"""Networks in fewer layers: the same answers, layer by layer and for whole networks drawn at random."""

from __future__ import annotations

import random
import struct
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from proxemetry.errors import ModelError
from proxemetry.pose.litert import interpreter
from proxemetry.pose.onnx.network import Network as RunningNetwork
from proxemetry.weights.conversion import ncnn, tflite
from proxemetry.weights.conversion.flatbuffer import Number
from proxemetry.weights.conversion.graph import read_graph
from proxemetry.weights.conversion.simplified import simplified

MODELS = Path(__file__).parents[2] / "shared" / "models"
HEIGHT, WIDTH, CHANNELS = 4, 6, 8


def _answers(content: bytes, *images: np.ndarray) -> list[np.ndarray]:
    network = interpreter(content, 1, "test")
    for detail, image in zip(network.get_input_details(), images, strict=True):
        network.set_tensor(detail["index"], image.astype(np.float32))
    network.invoke()
    return [network.get_tensor(detail["index"]) for detail in network.get_output_details()]


def _layers(content: bytes) -> Counter[str]:
    graph = read_graph(content)
    assert graph is not None
    return Counter(operator.name for operator in graph.operators)


def _normal(rng: np.random.Generator, *shape: int) -> np.ndarray:
    return rng.normal(size=shape).astype(np.float32)


def _shuffled(network: tflite.Network, x: tflite.Tensor, groups: int) -> tflite.Tensor:
    one, height, width, channels = x.shape
    parted = network.reshape(x, (one, height, width, groups, channels // groups))
    return network.reshape(network.transpose(parted, (0, 1, 2, 4, 3)), x.shape)


def _convolved(
    network: tflite.Network, x: tflite.Tensor, rng: np.random.Generator, out: int = 0, activation: str = "relu", **more
) -> tflite.Tensor:
    out = out or x.shape[3]
    return network.convolution(x, _normal(rng, out, 1, 1, x.shape[3]), _normal(rng, out), activation=activation, **more)


# --- closed forms


@pytest.mark.parametrize("groups", [2, 3, 4])
def test_a_shuffle_of_groups_takes_one_channel_of_each_in_turn(groups):
    network = tflite.Network()
    parts = [network.input((1, 1, 2, 3)) for _ in range(groups)]
    content = network.written([_shuffled(network, network.concatenation(parts, 3), groups)])
    images = [np.array([[[[1, 2, 3], [4, 5, 6]]]]) * 10**power for power in range(groups)]
    (found,) = _answers(simplified(content), *images)
    assert found[0, 0, 0].tolist() == [digit * 10**power for digit in (1, 2, 3) for power in range(groups)]
    assert found[0, 0, 1].tolist() == [digit * 10**power for digit in (4, 5, 6) for power in range(groups)]


def test_pictures_of_three_sizes_are_added_before_they_are_enlarged():
    network = tflite.Network()
    x, a, b = (network.input((1, side, side, 2)) for side in (4, 2, 1))
    total = network.arithmetic("add", x, network.doubled(a))
    total = network.arithmetic("add", total, network.doubled(network.doubled(b)))
    content = network.written([total])
    images = [np.arange(side * side * 2.0).reshape(1, side, side, 2) for side in (4, 2, 1)]
    (found,) = _answers(simplified(content), *images)
    expected = images[0] + images[1].repeat(2, 1).repeat(2, 2) + images[2].repeat(4, 1).repeat(4, 2)
    assert np.array_equal(found, expected)
    assert _layers(content)["depth_to_space"] == 3
    # one addition a size, neither with a picture four times as large written before
    assert _layers(simplified(content)) == {"add": 2, "reshape": 6}


def test_a_sum_that_is_needed_twice_is_written_once():
    network = tflite.Network()
    x, a = network.input((1, 4, 4, 2)), network.input((1, 2, 2, 2))
    total = network.arithmetic("add", x, network.doubled(a))
    content = network.written([total, network.arithmetic("add", total, x)])
    images = [np.arange(32.0).reshape(1, 4, 4, 2), np.arange(8.0).reshape(1, 2, 2, 2)]
    found, with_more = _answers(simplified(content), *images)
    expected = images[0] + images[1].repeat(2, 1).repeat(2, 2)
    assert np.array_equal(found, expected) and np.array_equal(with_more, expected + images[0])
    assert _layers(simplified(content))["add"] == 2


def test_a_sum_with_an_activation_keeps_it():
    network, relu = tflite.Network(), Number(tflite.ACTIVATIONS["relu"], "b")
    x = network.input((1, 2, 2, 2))
    (total,) = network.layer("add", [x, x], [x.shape], {0: relu}, "float32")
    content = network.written([_shuffled(network, network.arithmetic("add", total, x), 2)])
    image = np.array([-3, 2, 5, -7, 1, -1, 4, -2.0]).reshape(1, 2, 2, 2)
    assert simplified(content) is not content
    assert np.array_equal(_answers(simplified(content), image)[0], np.maximum(2 * image, 0) + image)


def test_a_large_maximum_is_taken_of_the_next_smaller():
    network, image = tflite.Network(), np.random.default_rng(1).integers(-99, 99, (1, 9, 8, 2))
    x = network.input(image.shape)
    content = network.written([network.max_pool(x, size) for size in (3, 5, 9)])
    before, after = (_answers(form, image) for form in (content, simplified(content)))
    assert all(np.array_equal(one, other) for one, other in zip(before, after, strict=True))
    graph = read_graph(simplified(content))
    assert graph is not None
    assert [operator.option(3) for operator in graph.operators] == [3, 3, 5]
    assert [operator.inputs[0] for operator in graph.operators[1:]] == [o.outputs[0] for o in graph.operators[:2]]


def test_a_shuffle_between_convolutions_costs_no_transposition():
    rng, network = np.random.default_rng(2), tflite.Network()
    x = network.input((1, HEIGHT, WIDTH, CHANNELS))
    # one block of ShuffleNet, whose second half goes on
    kept, changed = network.halves(x)
    joined = network.concatenation([kept, _convolved(network, changed, rng)], 3)
    _, second = network.halves(_shuffled(network, joined, 2))
    content = network.written([_convolved(network, second, rng)])
    assert _layers(content)["transpose"] == 1
    assert not _layers(simplified(content)) & Counter(["transpose", "split", "reshape"])
    image = _normal(rng, *x.shape)
    for one, other in zip(_answers(content, image), _answers(simplified(content), image), strict=True):
        assert other == pytest.approx(one, rel=1e-5, abs=1e-5)


def test_two_blocks_of_shufflenet_need_one_transposition():
    rng, network = np.random.default_rng(2), tflite.Network()
    x = image = network.input((1, HEIGHT, WIDTH, 5 * CHANNELS))
    for _ in range(2):
        kept, changed = network.halves(x)
        x = _shuffled(network, network.concatenation([kept, _convolved(network, changed, rng)], 3), 2)
    content = network.written([network.arithmetic("add", x, x)])
    layers = _layers(simplified(content))
    assert (_layers(content)["transpose"], layers["transpose"], layers["split"]) == (2, 1, 0)
    image = _normal(rng, *image.shape)
    for one, other in zip(_answers(content, image), _answers(simplified(content), image), strict=True):
        assert other == pytest.approx(one, rel=1e-5, abs=1e-5)


# --- laws


def _random_network(seed: int) -> tuple[bytes, tuple[int, ...]]:
    """Return a network of layers of all kinds in any order, and its input's shape."""
    choice, rng = random.Random(seed), np.random.default_rng(seed)
    network = tflite.Network()
    shape = (1, HEIGHT, WIDTH, CHANNELS)
    pictures = [network.input(shape)]
    activations = ["", "relu", "relu6"]

    def convolution(x: tflite.Tensor) -> tflite.Tensor:
        return _convolved(network, x, rng, choice.choice([4, 8, 12]), choice.choice(activations))

    def larger(x: tflite.Tensor) -> tflite.Tensor:
        weights = _normal(rng, 8, 3, 3, x.shape[3])
        return network.convolution(x, weights, _normal(rng, 8), pad=(1, 1, 1, 1), activation=choice.choice(activations))

    def depthwise(x: tflite.Tensor) -> tflite.Tensor:
        weights = _normal(rng, 1, 3, 3, x.shape[3])
        return network.convolution(x, weights, _normal(rng, x.shape[3]), pad=(1, 1, 1, 1), depthwise=True)

    def smaller(x: tflite.Tensor) -> tflite.Tensor:
        if min(x.shape[1:3]) % 2:
            return x
        weights = _normal(rng, 1, 3, 3, x.shape[3])
        return network.convolution(x, weights, _normal(rng, x.shape[3]), stride=2, pad=(1, 1, 1, 1), depthwise=True)

    def block(x: tflite.Tensor) -> tflite.Tensor:
        first, second = network.halves(x)
        changed = choice.choice([convolution, depthwise, larger])(second)
        order = [first, changed] if choice.random() < 0.7 else [changed, first]
        return network.concatenation(order, 3)

    def shuffle(x: tflite.Tensor) -> tflite.Tensor:
        return _shuffled(network, x, choice.choice([n for n in (1, 2, 4) if x.shape[3] % n == 0]))

    def like(x: tflite.Tensor) -> tflite.Tensor:
        return choice.choice([other for other in pictures if other.shape == x.shape] or [x])

    def added(x: tflite.Tensor) -> tflite.Tensor:
        return network.arithmetic("add", *choice.sample([x, like(x)], 2))

    def multiplied(x: tflite.Tensor) -> tflite.Tensor:
        return network.arithmetic("multiply", x, network.function("sigmoid", like(x)))

    def doubled(x: tflite.Tensor) -> tflite.Tensor:
        large = network.doubled(x)
        return network.arithmetic("add", *choice.sample([large, like(large)], 2))

    def pooled(x: tflite.Tensor) -> tflite.Tensor:
        sizes = choice.sample([3, 5, 7], 2)
        return network.arithmetic("add", *(network.max_pool(x, size) for size in sizes))

    kinds = [
        convolution, larger, depthwise, smaller, block, block, shuffle, shuffle, added, added, multiplied, doubled,
        doubled, pooled, lambda x: network.function("relu", x),
    ]  # fmt: skip
    for _ in range(choice.randint(3, 14)):
        recent = pictures[-choice.randint(1, 3) :][0]
        if recent.shape[3] % 4 == 0 and recent.shape[3] <= 48 and recent.shape[1] <= 32:
            pictures.append(choice.choice(kinds)(recent))
    outputs = [pictures[-1], *choice.sample(pictures, choice.randint(0, 2))]
    return network.written(list({tensor.index: tensor for tensor in outputs}.values())), shape


@settings(max_examples=120, deadline=None)
@given(st.integers(0, 10**6))
def test_answers_are_the_same_but_for_rounding(seed):
    content, shape = _random_network(seed)
    image = _normal(np.random.default_rng(seed + 1), *shape)
    before, after = (_answers(form, image) for form in (content, simplified(content)))
    for one, other in zip(before, after, strict=True):
        assert one.shape == other.shape
        # sums whose terms cancel keep their terms' rounding
        assert np.abs(one - other).max() <= 1e-3 * max(1.0, float(np.abs(one).max()))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_the_same_file_becomes_the_same_bytes_and_is_as_simple_as_it_gets(seed):
    content, _ = _random_network(seed)
    once = simplified(content)
    assert simplified(content) == once
    assert sum(_layers(simplified(once)).values()) <= sum(_layers(once).values())


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, 10**6), st.integers(0, 255))
def test_a_damaged_file_is_the_runtimes_to_complain_of(seed, place, byte):
    content = bytearray(_random_network(seed % 50)[0])
    content[place % len(content)] = byte
    assert isinstance(simplified(bytes(content)), bytes)
    assert isinstance(simplified(bytes(content[: place % len(content)])), bytes)


def test_channels_without_number_take_no_memory():
    network = tflite.Network()
    x = network.input((1, 1, 1, 1 << 20))
    content = network.written([_shuffled(network, x, 2)])
    assert simplified(content) is content


def test_a_shape_that_no_network_has_is_the_runtimes_to_complain_of():
    network = tflite.Network()
    content = network.written([_shuffled(network, network.input((1, 2, 2, 24)), 2)])
    shape = struct.pack("<4i", 1, 2, 2, 24)
    assert content.count(shape) > 1 and simplified(content) is not content
    for damaged in ((1, 2, 2, 0), (1, 2, 2, -24), (1, 2, 2, (1 << 31) - 1)):
        broken = content.replace(shape, struct.pack("<4i", *damaged))
        assert simplified(broken) is broken


# --- what is left alone


def test_a_network_with_nothing_to_gain_is_its_file():
    network, rng = tflite.Network(), np.random.default_rng(3)
    x = network.input((1, HEIGHT, WIDTH, CHANNELS))
    content = network.written([network.max_pool(network.function("relu", _convolved(network, x, rng)), 3)])
    assert simplified(content) is content


def test_a_network_with_unknown_layers_is_its_file():
    network = tflite.Network()
    x = network.input((1, HEIGHT, WIDTH, CHANNELS))
    content = network.written([network.argmax(_shuffled(network, x, 2), -1)])
    assert read_graph(content) is None
    assert simplified(content) is content


def test_the_network_that_runs_is_the_simplified_one_under_the_files_hash(tmp_path: Path, monkeypatch):
    network = tflite.Network()
    x = network.input((1, HEIGHT, WIDTH, CHANNELS))
    path = tmp_path / "shuffling.tflite"
    path.write_bytes(network.written([_shuffled(network, network.concatenation([x, x], 3), 2)]))
    run: list[bytes] = []
    monkeypatch.setattr(
        "proxemetry.pose.onnx.network.interpreter",
        lambda content, threads, name: run.append(content) or interpreter(content, threads, name),
    )
    running = RunningNetwork(path)
    image = np.arange(HEIGHT * WIDTH * CHANNELS, dtype=np.float32).reshape(x.shape)
    assert np.array_equal(running.run_one(image)[0], image.repeat(2, axis=3))
    assert run == [simplified(path.read_bytes())] != [path.read_bytes()]
    path.write_bytes(b"damaged")
    with pytest.raises(ModelError, match=r"shuffling\.tflite"):
        RunningNetwork(path)


def test_pp_tinypose_answers_the_same_without_half_of_its_shuffles():
    parts = [MODELS / "tinypose_ncnn" / f"tinypose_256x192.{ending}" for ending in ("param", "bin")]
    if not all(part.is_file() for part in parts):
        pytest.skip("the networks are not beside this checkout")
    content = ncnn.converted(*(part.read_bytes() for part in parts), (192, 256))
    before, after = _layers(content), _layers(simplified(content))
    assert (before["transpose"], after["transpose"]) == (50, 26)
    assert (before["depth_to_space"], after["depth_to_space"], after["split"]) == (38, 0, 0)
    image = _normal(np.random.default_rng(4), 1, 256, 192, 3)
    (one,), (other,) = _answers(content, image), _answers(simplified(content), image)
    assert np.abs(one - other).max() < 3e-6 * np.abs(one).max()
