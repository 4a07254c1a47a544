"""Whole back ends over small networks of every head type, whose answers are known from what was drawn."""

from __future__ import annotations

import dataclasses
import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from proxemetry import weights
from proxemetry.cli import main
from proxemetry.errors import ModelError, SettingsError
from proxemetry.photo import Photo, RGBArray
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.detections import Detections
from proxemetry.pose.onnx import tiled_detector as looking
from proxemetry.pose.onnx.backend import OnnxBackend
from proxemetry.pose.onnx.letterbox import Placement, Region, letterbox
from proxemetry.pose.onnx.network import Network
from proxemetry.pose.onnx.specification import READY, read_specification
from synthetic.dotted_world import FIGURE, PEOPLE, PHOTO_SIZE, specification
from synthetic.network_files import constant_network, dots, joints_network, yolox_detector

ort = pytest.importorskip("onnxruntime")

IMAGENET = "mean = [123.675, 116.28, 103.53]\nstd = [58.395, 57.12, 57.375]\n"


@pytest.mark.parametrize("head", ["heatmap-msra", "heatmap-udp", "simcc"])
def test_every_head_finds_every_joint_where_it_was_drawn(tmp_path: Path, head: str) -> None:
    backend = backend_named(f"onnx:{specification(tmp_path, head)}")
    people = backend.detect(Photo.from_array(dots(PHOTO_SIZE, PEOPLE)))
    assert len(people) == 3
    people = people[np.argsort(people.boxes_px[:, 0])]
    for person, joints in enumerate(PEOPLE):
        bounds = np.concatenate([joints.min(axis=0), joints.max(axis=0)])
        assert people.boxes_px[person] == pytest.approx(bounds, abs=1e-3)
        # 250 px drawn 1.25 times as large on 256: a pixel of the photo is 0.82 of the input's
        assert np.abs(people.keypoints_px[person] - joints).max() < 0.6
        assert np.abs((people.keypoints_px[person] - joints).mean(axis=0)).max() < 0.1


def test_a_photo_with_nobody_has_nobody(tmp_path: Path) -> None:
    backend = backend_named(f"onnx:{specification(tmp_path)}")
    assert len(backend.detect(Photo.from_array(dots(PHOTO_SIZE, [])))) == 0


def test_batches_and_threads_change_nothing(tmp_path: Path) -> None:
    photo = Photo.from_array(dots(PHOTO_SIZE, PEOPLE))
    found = []
    for batch, threads in ((1, 1), (1, 2), ("batch", 1), ("batch", 2)):
        source = specification(tmp_path, "simcc", batch)
        found.append(backend_named(f"onnx:{source}", PoseOptions(threads=threads)).detect(photo))
    for other in found[1:]:
        assert np.allclose(found[0].keypoints_px, other.keypoints_px, atol=1e-3)


def test_inputs_are_made_when_their_turn_comes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    specification(tmp_path, "simcc")
    pose = next(path for path in tmp_path.glob("*.onnx") if "pose" in path.name)
    network, events = Network(pose, threads=1), []
    image = np.zeros((1, 3, *reversed(network.input_size or (0, 0))), np.float32)

    def make(number: int) -> np.ndarray:
        events.append(f"made {number}")
        return image + number

    real = network._run
    monkeypatch.setattr(network, "_run", lambda inputs: events.append(f"run {inputs[0, 0, 0, 0]:.0f}") or real(inputs))
    answers = network.run_made([lambda number=number: make(number) for number in range(3)])
    assert events == ["made 0", "run 0", "made 1", "run 1", "made 2", "run 2"]
    for one, other in zip(answers, network.run(np.concatenate([image, image + 1, image + 2])), strict=True):
        assert np.array_equal(one, other)


def test_a_person_on_a_seam_of_tiles_is_one_person(tmp_path: Path) -> None:
    source = specification(tmp_path)
    text = Path(source).read_text().replace('colours = "bgr"', 'colours = "bgr"\ntiles = [1.0, 0.7]')
    Path(source).write_text(text)
    assert len(backend_named(f"onnx:{source}").detect(Photo.from_array(dots(PHOTO_SIZE, PEOPLE)))) == 3


def test_tiles_are_laid_where_somebody_is_suspected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first person is found, the second suspected, the third too unsure even for that: one tile, not four."""
    source = specification(tmp_path)
    text = (
        Path(source).read_text().replace('colours = "bgr"', 'colours = "bgr"\ntiles = [1.0, 0.7]\nsuspicion = 0.1', 1)
    )
    Path(source).write_text(text)
    shown: list[tuple[int, int, int, int]] = []
    scores = np.array([0.8, 0.2, 0.05])

    def decode(outputs: object, size: object, person: int, least: float) -> Detections:
        whole = len(shown) == 1
        boxes = np.array([[46, 37, 121, 162], [300, 200, 340, 280], [10, 200, 30, 250]], float)
        return Detections(boxes, scores)[(scores >= least) & whole]

    def remember(pixels: RGBArray, region: Region, *rest: Any, **more: Any) -> tuple[RGBArray, Placement]:
        shown.append(region)
        return letterbox(pixels, region, *rest, **more)

    monkeypatch.setattr(looking, "letterbox", remember)
    for effort, number in (("normal", 2), ("fast", 1), ("thorough", 5)):
        backend = OnnxBackend(read_specification(source), PoseOptions(effort=effort, threads=1))
        monkeypatch.setattr(backend._photo_network, "_decode", decode)
        shown.clear()
        people = backend._photo_network.detect(dots(PHOTO_SIZE, PEOPLE))
        assert len(shown) == number and people.scores.tolist() == [0.8]
    scores[1] = 0.05
    backend = OnnxBackend(read_specification(source), PoseOptions(threads=1))
    monkeypatch.setattr(backend._photo_network, "_decode", decode)
    shown.clear()
    backend._photo_network.detect(dots(PHOTO_SIZE, PEOPLE))
    assert len(shown) == 1


def test_what_one_cell_of_several_looks_sees_is_nobody(tmp_path: Path) -> None:
    source = specification(tmp_path)
    Path(source).write_text(
        Path(source).read_text().replace('colours = "bgr"', 'colours = "bgr"\nleast_support = 2', 1)
    )
    boxes = np.array([[0, 0, 50, 100], [2, 0, 52, 100], [200, 0, 250, 100]], float)
    found = Detections(boxes, np.array([0.5, 0.6, 0.7]))
    for effort, left in (("normal", [0.6]), ("thorough", [0.6]), ("fast", [0.7, 0.6])):
        backend = OnnxBackend(read_specification(source), PoseOptions(effort=effort, threads=1))
        assert backend._distinct(found).scores.tolist() == left


def test_colours_in_the_wrong_order_are_not_found(tmp_path: Path) -> None:
    """The order of the channels matters to these networks, as to real ones: the tests above would notice."""
    source = specification(tmp_path)
    Path(source).write_text(Path(source).read_text().replace(IMAGENET, f'colours = "bgr"\n{IMAGENET}'))
    people = backend_named(f"onnx:{source}").detect(Photo.from_array(dots(PHOTO_SIZE, PEOPLE)))
    assert len(people) == 0 or np.nanmax(np.abs(people.keypoints_px[0] - PEOPLE[0])) > 5


def test_a_detector_that_suppresses_by_itself(tmp_path: Path) -> None:
    """MMDeploy's form: boxes with scores, and a class each; only class 0 is a person."""
    source = specification(tmp_path)
    boxes = np.array([[[46.5, 37.5, 121.5, 162.5, 0.9], [10, 10, 60, 60, 0.9], [0, 0, 5, 5, 0.1]]], np.float32)
    constant_network(tmp_path / "detector.onnx", (416, 416), boxes, np.array([[0, 7, 0]]))
    Path(source).write_text(Path(source).read_text().replace('"yolox"', '"boxes"'))
    people = backend_named(f"onnx:{source}").detect(Photo.from_array(dots(PHOTO_SIZE, PEOPLE)))
    assert people.boxes_px == pytest.approx(np.array([[93, 75, 243, 325]]))
    assert np.abs(people.keypoints_px[0] - PEOPLE[0]).max() < 0.6


def test_a_one_stage_network_comes_back_to_the_photo(tmp_path: Path) -> None:
    """640 wide for 1280: one pixel of the input is two of the photo, and a whole number names a pixel's middle."""
    boxes = np.array([[[100, 50, 200, 350, 0.8], [100, 50, 201, 351, 0.7], [300, 50, 400, 300, 0.1]]], np.float32)
    joints = np.zeros((1, 3, 17, 3), np.float32)
    joints[..., :2] = (FIGURE * (100, 300) + (100, 50)).astype(np.float32)
    joints[..., 2] = 0.9
    constant_network(tmp_path / "one.onnx", (640, 640), boxes, joints)
    spec = tmp_path / "one.toml"
    spec.write_text('skeleton = "coco17"\n[one_stage]\nfile = "one.onnx"\ndecode = "rtmo"\nscore = 0.3\n')
    people = backend_named(f"onnx:{spec}").detect(Photo.from_array(np.full((720, 1280, 3), 50, np.uint8)))
    assert len(people) == 1, "the second is the first seen again, the third too unsure"
    assert people.boxes_px[0] == pytest.approx([200, 100, 400, 700])
    assert people.keypoints_px[0] == pytest.approx((FIGURE * (100, 300) + (100, 50) + 0.5) * 2, abs=1e-3)
    assert people.scores == pytest.approx(0.9)
    # the geometric mean of the box's score and of the joints'
    assert people.person_scores[0] == pytest.approx(np.sqrt(0.8 * 0.9))


def test_joints_beyond_the_photo_and_unsure_ones_are_missing(tmp_path: Path) -> None:
    boxes = np.array([[[0, 0, 100, 640, 0.8]]], np.float32)
    joints = np.full((1, 1, 17, 3), 50.0, np.float32)
    joints[..., 2] = 0.9
    joints[0, 0, 5, 0], joints[0, 0, 6, 2] = -3.0, 0.1
    constant_network(tmp_path / "one.onnx", (640, 640), boxes, joints)
    spec = tmp_path / "one.toml"
    spec.write_text('skeleton = "coco17"\n[one_stage]\nfile = "one.onnx"\ndecode = "rtmo"\n')
    people = backend_named(f"onnx:{spec}").detect(Photo.from_array(np.full((640, 640, 3), 50, np.uint8)))
    assert np.flatnonzero(people.scores[0] == 0).tolist() == [5, 6]
    assert np.isnan(people.keypoints_px[0, [5, 6]]).all()


def test_a_skeleton_of_another_size_is_refused(tmp_path: Path) -> None:
    source = specification(tmp_path)
    Path(source).write_text(Path(source).read_text().replace("coco17", "halpe26"))
    with pytest.raises(ModelError, match="17 joints, and halpe26 has 26"):
        backend_named(f"onnx:{source}").detect(Photo.from_array(dots(PHOTO_SIZE, PEOPLE)))


def test_a_head_that_is_none_is_refused(tmp_path: Path) -> None:
    source = specification(tmp_path)
    constant_network(tmp_path / "detector.onnx", (416, 416), np.zeros((1, 100, 85), np.float32))
    with pytest.raises(ModelError, match="not a YOLOX head for an input of 416 x 416"):
        backend_named(f"onnx:{source}").detect(Photo.from_array(dots(PHOTO_SIZE, [])))


def test_a_gpu_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    if set(ort.get_available_providers()) & {"CUDAExecutionProvider", "ROCMExecutionProvider"}:
        pytest.skip("this machine has a GPU runtime")
    path = yolox_detector(tmp_path / "detector.onnx", 416, (75, 125))
    with pytest.raises(ModelError, match="a GPU was asked for, and this ONNX Runtime has none"):
        Network(path, device="gpu")


def test_a_gpu_that_falls_back_to_the_processor_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The runtime is built for CUDA, but the driver's libraries are absent: it warns and computes on the processor."""
    path = yolox_detector(tmp_path / "detector.onnx", 416, (75, 125))
    session = ort.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    monkeypatch.setattr(ort, "get_available_providers", lambda: ["CUDAExecutionProvider", "CPUExecutionProvider"])
    monkeypatch.setattr(ort, "InferenceSession", lambda *_, **__: session)
    with pytest.raises(ModelError, match=r"runs detector\.onnx by CPUExecutionProvider"):
        Network(path, device="gpu")


def test_openvino_says_the_same_as_onnx_runtime(tmp_path: Path) -> None:
    pytest.importorskip("openvino")
    path = joints_network(tmp_path / "pose.onnx", "heatmap-msra")
    crop = np.random.default_rng(1).normal(size=(2, 3, 256, 192)).astype(np.float32)
    ours, theirs = Network(path), Network(path, device="openvino")
    assert theirs.provider == "OpenVINO CPU f32"
    assert np.allclose(ours.run(crop)[0], theirs.run(crop)[0], atol=1e-5)


def test_a_damaged_network_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "broken.onnx"
    path.write_bytes(b"nothing that could be a network")
    with pytest.raises(ModelError, match=r"broken.onnx: ONNX Runtime cannot load it") as caught:
        Network(path)
    assert "\n" not in str(caught.value)
    with pytest.raises(ModelError, match="no such network file"):
        Network(tmp_path / "absent.onnx")
    with pytest.raises(SettingsError, match="device 'tpu' is unknown"):
        Network(path, device="tpu")


@pytest.mark.parametrize("name", READY)
def test_the_ready_specifications_are_sound(name: str) -> None:
    spec = read_specification(name)
    assert spec.name == name
    assert spec.pose is None or spec.pose.size[0] <= spec.pose.size[1]
    for part in (spec.detector, spec.pose):
        if part is not None and part.mean != (0.0, 0.0, 0.0):  # ImageNet's, in the order of the network's channels
            in_rgb = slice(None) if part.colours == "rgb" else slice(None, None, -1)
            assert part.mean[in_rgb] == (123.675, 116.28, 103.53) and part.std[in_rgb] == (58.395, 57.12, 57.375)


MISTAKES = {
    "no TOML": ("skeleton = ", "not TOML"),
    "no sections": ('skeleton = "coco17"', r"give \[detector\] and \[pose\], or \[one_stage\] alone"),
    "unknown skeleton": ('skeleton = "squid"\n[one_stage]\nfile = "a"\ndecode = "rtmo"', "skeleton 'squid' is unknown"),
    "no skeleton": ('[one_stage]\nfile = "a"\ndecode = "rtmo"', "skeleton is missing"),
    "no file": ('skeleton = "coco17"\n[one_stage]\ndecode = "rtmo"', "file is missing"),
    "unknown decoder": (
        'skeleton = "coco17"\n[one_stage]\nfile = "a"\ndecode = "magic"',
        "decode = 'magic' is unknown",
    ),
    "unknown key": ('skeleton = "coco17"\n[one_stage]\nfile = "a"\ndecode = "rtmo"\nsigma = 2', "'sigma' is unknown"),
    "wrong type": (
        'skeleton = "coco17"\n[one_stage]\nfile = "a"\ndecode = "rtmo"\nsize = 640',
        "size = 640 does not fit",
    ),
    "zero std": (
        'skeleton = "coco17"\n[one_stage]\nfile = "a"\ndecode = "rtmo"\nstd = [1, 0, 1]',
        "std must be positive",
    ),
    "a section that is none": ('skeleton = "coco17"\none_stage = 3', "a section was expected"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_in_a_specification_is_one_line_that_names_it(tmp_path: Path, mistake: str) -> None:
    text, message = MISTAKES[mistake]
    path = tmp_path / "spec.toml"
    path.write_text(text)
    with pytest.raises(SettingsError, match=message) as caught:
        read_specification(str(path))
    assert "\n" not in str(caught.value)


def test_an_unknown_specification_and_an_absent_file(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="no such file, nor one of"):
        read_specification("no-such")
    path = tmp_path / "spec.toml"
    path.write_text('skeleton = "coco17"\n[one_stage]\nfile = "absent.onnx"\ndecode = "rtmo"')
    with pytest.raises(ModelError, match="neither next to the specification nor in the model table"):
        OnnxBackend(read_specification(str(path)))


@pytest.mark.parametrize("name", ["blazepose", "recorded:x.json", "python:a:b", "yolov4-openpose"])
def test_a_back_end_without_a_say_in_the_device_refuses_it(name: str) -> None:
    with pytest.raises(SettingsError, match="runs on the processor alone, not on 'gpu'"):
        backend_named(name, PoseOptions(device="gpu", offline=True))


def test_a_mirror_is_refused_where_nothing_would_look_into_it(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match="cannot look at a mirrored photo"):
        backend_named("recorded:x.json", PoseOptions(flip=True))
    constant_network(tmp_path / "one.onnx", (640, 640), np.zeros((1, 1, 5)), np.zeros((1, 1, 17, 3)))
    spec = tmp_path / "one.toml"
    spec.write_text('skeleton = "coco17"\n[one_stage]\nfile = "one.onnx"\ndecode = "rtmo"\n')
    with pytest.raises(SettingsError, match="leave flip out"):
        backend_named(f"onnx:{spec}", PoseOptions(flip=True))
    with pytest.raises(SettingsError, match="device 'tpu' is unknown"):
        PoseOptions(device="tpu")


def test_a_gpu_that_is_not_there_is_an_error_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if {"CUDAExecutionProvider", "ROCMExecutionProvider", "DmlExecutionProvider"} & set(ort.get_available_providers()):
        pytest.skip("this ONNX Runtime has a GPU")
    photo = tmp_path / "grey.png"
    Image.new("RGB", (64, 48)).save(photo)
    pose = f"onnx:{specification(tmp_path)}"
    code = main(["measure", str(photo), "--out", str(tmp_path / "out"), "--pose", pose, "--device", "gpu", "--flip"])
    assert code == 2
    assert "a GPU was asked for, and this ONNX Runtime has none" in capsys.readouterr().err


def test_another_device_takes_the_onnx_form_where_it_is_here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path))
    spec = read_specification("yolox-tinypose")
    for model, content in ((spec.detector.file, b"for LiteRT"), ("yolox_nano.onnx", b"for a GPU")):
        (tmp_path / model).write_bytes(content)
        known = dataclasses.replace(weights.MODELS[model], sha256=hashlib.sha256(content).hexdigest())
        monkeypatch.setitem(weights.MODELS, model, known)
    assert spec.path_of(spec.detector.file).name == "yolox_nano.tflite"
    assert spec.path_of(spec.detector.file, "gpu").name == "yolox_nano.onnx"
    (tmp_path / "yolox_nano.onnx").unlink()
    assert spec.path_of(spec.detector.file, "gpu").name == "yolox_nano.tflite"  # which says that it cannot


def test_a_litert_network_refuses_another_device_and_a_damaged_file(tmp_path: Path) -> None:
    path = tmp_path / "net.tflite"
    path.write_bytes(b"no network")
    with pytest.raises(ModelError, match=r"net\.tflite runs on the processor alone, not on 'gpu'"):
        Network(path, device="gpu")
    with pytest.raises(ModelError, match="LiteRT cannot load it"):
        Network(path)
