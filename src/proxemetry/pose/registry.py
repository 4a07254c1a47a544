"""The pose back ends by name: what each needs, what it takes, and whether it can run here."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping
from dataclasses import dataclass

from .. import weights
from ..errors import SettingsError

EFFORTS = ("fast", "normal", "thorough")


DEVICES = ("cpu", "gpu", "openvino")


@dataclass(frozen=True)
class PoseOptions:
    """What the user states of finding people, for every back end.

    effort: "fast", "normal" or "thorough". threads: how many a network may use (1 where photos run in parallel).
    offline: nothing may be fetched. device: one of `DEVICES`. flip: average with the mirrored photo. A back end that
    has no use for one of the last two refuses it (`Entry.takes`); the others are for those that can use them. pupils:
    the eyes' distance will be measured, so that pupils are worth looking for.
    """

    effort: str = "normal"
    threads: int = 2
    offline: bool = False
    device: str = "cpu"
    flip: bool = False
    pupils: bool = False

    def __post_init__(self) -> None:
        if self.effort not in EFFORTS:
            raise SettingsError(f"effort {self.effort!r} is unknown: use one of {', '.join(EFFORTS)}")
        if self.threads < 1:
            raise SettingsError(f"threads is {self.threads}: it must be 1 or more")
        if self.device not in DEVICES:
            raise SettingsError(f"device {self.device!r} is unknown: use one of {', '.join(DEVICES)}")


@dataclass(frozen=True)
class Entry:
    """One back end: `target` is "module:factory", called as factory(argument, options) -> PoseBackend.

    models: names of the networks it needs. runtime: the package that runs them, "" for none. summary: for the list.
    argument: what the factory gets where the name carries none. takes: which of `device` and `flip` it heeds. wants:
    names of networks that it finds more people with, and runs without.
    """

    target: str
    models: tuple[str, ...]
    runtime: str
    summary: str
    argument: str = ""
    takes: tuple[str, ...] = ()
    wants: tuple[str, ...] = ()


_ANY = ("device", "flip")


def _ready(name: str, models: tuple[str, ...], summary: str) -> Entry:
    return Entry("onnx.backend:open_backend", models, "onnxruntime", summary, name, _ANY)


def _on_litert(name: str, models: tuple[str, ...], summary: str) -> Entry:
    return Entry("onnx.backend:open_backend", models, "ai_edge_litert", summary, name, _ANY)


_PAPER_MODELS = ("yolov4.cfg", "yolov4.weights", "body_25_pose_deploy.prototxt", "pose_iter_584000.caffemodel")


BACKENDS: dict[str, Entry] = {
    "yolox-tinypose": _on_litert(
        "yolox-tinypose", ("yolox_nano.tflite", "tinypose_256x192.tflite"), "17 joints, small and quick: the default"
    ),
    "nanodet-movenet": _on_litert(
        "nanodet-movenet",
        ("nanodet_g.tflite", "movenet_thunder.tflite"),
        "17 joints, from package registries: the default where GitHub cannot be reached",
    ),
    "blazepose": Entry(
        "blazepose:open_backend",
        weights.EMBEDDED,
        "ai_edge_litert",
        "33 joints, from the Python package index alone: where neither of the others is available",
        takes=("flip",),  # it always does
        wants=(weights.EMBEDDED_FINDER,),
    ),
    "rtmdet-rtmpose-halpe26": _ready(
        "rtmdet-rtmpose-halpe26", ("rtmdet_m_person.onnx", "rtmpose_m_halpe26.onnx"), "26 joints, neck and hip seen"
    ),
    "yolox-rtmpose": _ready(
        "yolox-rtmpose", ("yolox_m_humanart.onnx", "rtmpose_m_body7.onnx"), "17 joints, strong and slow"
    ),
    "yolox-vitpose": _ready(
        "yolox-vitpose", ("yolox_m_humanart.onnx", "vitpose_b_coco.onnx"), "17 joints, strongest and slowest"
    ),
    "rtmo": _ready("rtmo", ("rtmo_s_body7.onnx",), "17 joints, one network: its time hardly grows with the people"),
    "onnx": Entry(
        "onnx.backend:open_backend", (), "onnxruntime", "onnx:SPEC.toml runs any detector and pose network", takes=_ANY
    ),
    "yolov4-openpose": Entry(
        "paper.yolov4_openpose:open_backend",
        _PAPER_MODELS,
        "cv2",
        "the paper's pair; yolov4-openpose:FOLDER holds its files",
    ),
    "yolov4-openpose-published": Entry(
        "paper.yolov4_openpose:open_published", _PAPER_MODELS, "cv2", "the same with all that the authors' code does"
    ),
    "cross-check": Entry(
        "cross_check:open_backend", (), "", "cross-check:A+B keeps A's people that B finds too", takes=_ANY
    ),
    "recorded": Entry("recorded:open_backend", (), "", "recorded:FILE replays a keypoint file or folder"),
    "python": Entry("callables:open_backend", (), "", "python:MODULE:FUNCTION calls your own detector"),
}


def is_available(name: str) -> bool:
    """Return whether a back end's networks and runtime are there, without loading any.

    Raises ModelError where something else than a file has the name of one of its networks.
    """
    entry = BACKENDS[name]
    runtime_is_there = not entry.runtime or importlib.util.find_spec(entry.runtime) is not None
    here = [weights.is_here(model) for model in entry.models]
    return runtime_is_there and all(here)


def available() -> list[str]:
    """Return the back ends whose networks and runtime are there, in the order of `BACKENDS`."""
    return [name for name, entry in BACKENDS.items() if entry.models and is_available(name)]


def replays(name: str) -> bool:
    """Return whether a back end knows photos without their files: a recording, or one that another only confirms."""
    key, _, argument = name.partition(":")
    return key == "recorded" or (key == "cross-check" and replays(argument.partition("+")[0]))


def lacking(name: str, models: Mapping[str, str]) -> tuple[str, ...]:
    """Return the networks that a back end would use but loaded its others without."""
    entry = BACKENDS.get(name)
    return () if entry is None else tuple(model for model in entry.wants if model not in models)
