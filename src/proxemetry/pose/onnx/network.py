"""A network file and what runs it: ONNX Runtime on the processor or a GPU, OpenVINO, or LiteRT."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError, SettingsError
from ...files import reason_of, sha256_of
from ...weights.conversion.eight_bits import in_eight_bits
from ...weights.conversion.simplified import simplified
from .. import DEVICES
from ..litert import interpreter

Floats = NDArray[np.float32]
Run = Callable[[Floats], list[Floats]]

#: ONNX Runtime's providers that are a GPU, best first.
_GPU_PROVIDERS = ("CUDAExecutionProvider", "ROCMExecutionProvider", "MIGraphXExecutionProvider", "DmlExecutionProvider")
_OWN_MESSAGES_ONLY = 3  # ONNX Runtime's log level for errors


class Network:
    """One network with one image input; thread-safe.

    path: the .onnx file, or a .tflite file, which LiteRT runs on the processor. device: one of `DEVICES`. threads: how
    many inputs run side by side, each on one thread; a GPU takes whole batches instead. eight_bits: LiteRT computes the
    larger convolutions in 8 bits; ONNX Runtime and OpenVINO pay no heed. `provider` is what really runs it,
    `channels_last` whether an input has shape (B, H, W, 3) instead of (B, 3, H, W). Raises ModelError where the file
    cannot be loaded or the device was asked for and cannot be had: there is no falling back in silence.
    """

    def __init__(self, path: str | Path, *, device: str = "cpu", threads: int = 2, eight_bits: bool = False) -> None:
        self.path = Path(path)
        if device not in DEVICES:
            raise SettingsError(f"device {device!r} is unknown: use one of {', '.join(DEVICES)}")
        if not self.path.is_file():
            raise ModelError(f"{self.path}: no such network file; `proxemetry models list` shows which there are")
        try:
            self.sha256 = sha256_of(self.path)
        except OSError as error:
            raise ModelError(f"{self.path}: cannot be read ({reason_of(error)})") from error
        self.channels_last = self.path.suffix == ".tflite"
        of_onnx = _load_openvino if device == "openvino" else _load_onnx_runtime
        loader = partial(_load_litert, eight_bits=eight_bits) if self.channels_last else of_onnx
        self._run, shape, self.provider = loader(self.path, device)
        if len(shape) != 4:
            raise ModelError(f"{self.path.name}: the input has shape {shape}, not (batch, 3, height, width)")
        if self.channels_last:
            shape = [shape[0], shape[3], shape[1], shape[2]]
        self._fixed_batch = shape[0] if isinstance(shape[0], int) and shape[0] > 0 else None
        self.input_size = _input_size(shape)
        self._takes_batches = device == "gpu" and self._fixed_batch is None
        self._pool = ThreadPoolExecutor(threads, "network") if threads > 1 and device != "gpu" else None

    def run(self, inputs: Floats) -> list[Floats]:
        """Return the outputs for B inputs of shape (B, 3, H, W), or (B, H, W, 3), each with B rows.

        A GPU gets them all at once; a processor one at a time, or so does a network that is made for one. Batches are
        no faster there: a larger one leaves the processor's cache between two layers (PP-TinyPose takes 22 % longer a
        person in batches of four).
        """
        batches = self._batches(inputs)
        if len(batches) == 1:
            return self._run(batches[0])
        answers = list(self._pool.map(self._run, batches)) if self._pool else [self._run(b) for b in batches]
        return [np.concatenate(parts) for parts in zip(*answers, strict=True)]

    def each(self, tasks: list[Callable[[], Any]]) -> list[Any]:
        """Return what the tasks return, in order, run side by side on this network's threads."""
        return list(self._pool.map(lambda task: task(), tasks)) if self._pool else [task() for task in tasks]

    def run_made(self, inputs: list[Callable[[], Floats]]) -> list[Floats]:
        """Return the outputs for inputs, each of a batch of one, that are made when their turn comes.

        No more inputs are in memory at once than threads: those of a crowd of 600 would fill 350 MB.
        """
        if self._takes_batches or self._fixed_batch not in (None, 1):
            return self.run(np.concatenate(self.each(inputs)))
        answers = self.each([lambda make=make: self._run(make()) for make in inputs])
        return [np.concatenate(parts) for parts in zip(*answers, strict=True)]

    def run_one(self, image: Floats) -> list[Floats]:
        """Return the outputs for one input, a batch of one, on the calling thread."""
        return self._run(image)

    def _batches(self, inputs: Floats) -> list[Floats]:
        if self._takes_batches:
            return [inputs]
        if self._fixed_batch not in (None, 1, len(inputs)):
            raise ModelError(
                f"{self.path.name}: the input's batch is fixed to {self._fixed_batch}: export it with 1 or a free one"
            )
        step = self._fixed_batch or 1
        return [inputs[i : i + step] for i in range(0, len(inputs), step)]


def _input_size(shape: list[Any]) -> tuple[int, int] | None:
    height, width = shape[2], shape[3]
    return (width, height) if isinstance(width, int) and isinstance(height, int) and width > 0 < height else None


def _load_onnx_runtime(path: Path, device: str) -> tuple[Run, list[Any], str]:
    try:
        import onnxruntime as ort
    except ImportError as error:
        extra = "gpu" if device == "gpu" else "onnx"
        raise ModelError(f"ONNX Runtime is not installed: pip install 'proxemetry[{extra}]'") from error
    ort.disable_telemetry_events()  # on Windows the environment alone does not (`telemetry`)
    wanted = ["CPUExecutionProvider"]
    if device == "gpu":
        wanted = [p for p in _GPU_PROVIDERS if p in ort.get_available_providers()][:1]
        if not wanted:
            raise ModelError(
                "a GPU was asked for, and this ONNX Runtime has none "
                f"(it has {', '.join(ort.get_available_providers())}): pip install 'proxemetry[gpu]', or use cpu"
            )
    options = ort.SessionOptions()
    options.log_severity_level = _OWN_MESSAGES_ONLY
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    # Buffers handed from layer to layer make small networks slower, and need no less memory than fresh ones: 10 % of
    # PP-TinyPose's time, 4 % of YOLOX-Nano's, nothing of a network as large as RTMPose-M.
    options.enable_mem_reuse = False
    try:
        session = ort.InferenceSession(str(path), options, providers=wanted)
    except Exception as error:  # the runtime raises its own types, none of them documented
        raise ModelError(f"{path}: ONNX Runtime cannot load it ({_first_line(error)})") from error
    got = session.get_providers()[0]
    if got != wanted[0]:
        raise ModelError(
            f"a GPU was asked for, and ONNX Runtime runs {path.name} by {got}: check the driver's libraries"
        )
    name = session.get_inputs()[0].name

    def run(inputs: Floats) -> list[Floats]:
        return [np.asarray(answer) for answer in session.run(None, {name: inputs})]

    return run, list(session.get_inputs()[0].shape), got


def _load_openvino(path: Path, device: str) -> tuple[Run, list[Any], str]:
    try:
        import openvino  # pyright: ignore[reportMissingImports]
    except ImportError as error:
        raise ModelError("OpenVINO is not installed: pip install 'proxemetry[openvino]'") from error
    try:
        core = openvino.Core()
        # newer processors would compute in bfloat16 by default: keypoints then move by whole pixels
        settings = {"INFERENCE_PRECISION_HINT": "f32", "INFERENCE_NUM_THREADS": 1}
        compiled = core.compile_model(core.read_model(str(path)), "CPU", settings)
    except Exception as error:  # likewise
        raise ModelError(f"{path}: OpenVINO cannot load it ({_first_line(error)})") from error

    def run(inputs: Floats) -> list[Floats]:
        answers = compiled.create_infer_request().infer([inputs])
        return [np.asarray(answers[i], np.float32) for i in range(len(compiled.outputs))]

    sides = compiled.input(0).get_partial_shape()
    return run, [s.get_length() if s.is_static else "free" for s in sides], "OpenVINO CPU f32"


def _load_litert(path: Path, device: str, eight_bits: bool) -> tuple[Run, list[Any], str]:
    if device != "cpu":
        raise ModelError(f"{path.name} runs on the processor alone, not on {device!r}: a GPU needs an ONNX file")
    content = simplified(path.read_bytes())
    if eight_bits:
        try:
            content = in_eight_bits(content)
        except ModelError as error:
            raise ModelError(f"{path}: {error}") from error
    of_thread = threading.local()  # an interpreter's buffers are its own

    def loaded() -> Any:
        if not hasattr(of_thread, "interpreter"):
            of_thread.interpreter = interpreter(content, 1, str(path))
        return of_thread.interpreter

    given = loaded().get_input_details()[0]
    outputs = [detail["index"] for detail in loaded().get_output_details()]

    def run(inputs: Floats) -> list[Floats]:
        network = loaded()
        network.set_tensor(given["index"], inputs.astype(given["dtype"], copy=False))
        network.invoke()
        return [network.get_tensor(index) for index in outputs]

    return run, [int(side) for side in given["shape"]], "LiteRT CPU, 8 bits" if eight_bits else "LiteRT CPU"


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
