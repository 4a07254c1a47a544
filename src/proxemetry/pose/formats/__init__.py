"""Keypoint files of every common kind, recognised by their content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

from ...errors import KeypointsError
from ...files import parse_json, read_text, reason_of
from . import coco, label_studio, mot, openpose, own, toolboxes
from .beside import EXTRA_JOINTS, Beside
from .recording import RecordedPhoto, naming, refuse_fractions

__all__ = ["EXTRA_JOINTS", "Beside", "RecordedPhoto", "Recordings", "read"]

_KINDS = (
    "our own, COCO annotations or results, OpenPose, MMPose, ViTPose, Ultralytics, Label Studio and MOT files are "
    "known; "
    "docs/detectors.md shows them"
)


@dataclass(frozen=True, eq=False)
class Recordings:
    """The content of a file or folder. lists_empty: whether a photo without people would be in it too."""

    photos: tuple[RecordedPhoto, ...]
    lists_empty: bool = True


def read(path: str | Path) -> Recordings:
    """Return the content of a keypoint file, or of a folder of one file a photo.

    Raises KeypointsError, naming file and entry, where there is no such file or it is malformed.
    """
    path = Path(path)
    if path.is_dir():
        return _folder(path)
    if path.suffix.lower() == ".txt":
        text = _text(path)
        if mot.is_mot(text):
            return Recordings(tuple(mot.read_mot(path, text)), lists_empty=False)
        return Recordings((toolboxes.read_ultralytics_text(str(path), path.stem, text),))
    recordings = _file(path)
    with naming(str(path)):
        for recording in recordings.photos:
            refuse_fractions(recording)
    return recordings


def _folder(folder: Path) -> Recordings:
    endings = (openpose.ENDING, ".json", ".txt")
    # a Mac leaves a file ._NAME next to each NAME on other systems' disks
    kinds = (sorted(p for p in folder.glob(f"*{ending}") if not p.name.startswith(".")) for ending in endings)
    files = next((found for found in kinds if found), None)
    if not files:
        raise KeypointsError(f"{folder}: no keypoint files in it; {_KINDS}")
    found = [read(file) for file in files]
    lists_empty = all(one.lists_empty for one in found) and files[0].suffix.lower() != ".txt"
    return Recordings(tuple(photo for one in found for photo in one.photos), lists_empty)


def _file(path: Path) -> Recordings:
    where = str(path)
    try:
        content: Any = parse_json(_text(path))
    except ValueError as error:
        raise KeypointsError(f"{where}: not JSON ({error})") from error
    if isinstance(content, Mapping):
        return _mapping(where, path, cast(Mapping[str, Any], content))
    if isinstance(content, list):
        return _list(where, path, cast(list[Any], content))
    raise KeypointsError(f"{where}: no keypoints in it; {_KINDS}")


def _mapping(where: str, path: Path, content: Mapping[str, Any]) -> Recordings:
    for name in ("images", "annotations", "people", "preds", "image_paths", "instance_info"):
        if name in content and not isinstance(content[name], list):
            raise KeypointsError(f"{where}: {name!r} must be a list")
    if "images" in content and "annotations" in content:
        return Recordings(tuple(coco.read_annotations(where, content)))
    if "images" in content:
        return Recordings(tuple(own.read_own(where, content)))
    if "people" in content:
        return Recordings((openpose.read_openpose(where, _photo(path, openpose.ENDING), content),))
    if "preds" in content and "image_paths" in content:
        return Recordings(tuple(toolboxes.read_preds(where, content)), lists_empty=False)
    if "instance_info" in content:
        return Recordings((toolboxes.read_mmpose(where, _photo(path, "results_"), content),))
    if "keypoints" in content and "skeleton" in content:
        return Recordings((toolboxes.read_easy_vitpose(where, _photo(path, "_result.json"), content),))
    raise KeypointsError(f"{where}: no keypoints in it; {_KINDS}")


def _list(where: str, path: Path, content: Sequence[Any]) -> Recordings:
    for number, entry in enumerate(content):
        if not isinstance(entry, Mapping):
            raise KeypointsError(f"{where}, entry {number}: not an object; {_KINDS}")
    first: Mapping[str, Any] = content[0] if content else {}
    if not content or "image_id" in first:
        return Recordings(tuple(coco.read_results(where, content)), lists_empty=False)
    if label_studio.is_label_studio(first):
        return Recordings(tuple(label_studio.read_label_studio(where, content)))
    if "box" in first:
        return Recordings((toolboxes.read_ultralytics(where, path.stem, content),))
    if "keypoints" in first:
        return Recordings((toolboxes.read_mmpose(where, path.stem, content),))
    raise KeypointsError(f"{where}, entry 0: 'keypoints' is missing; {_KINDS}")


def _photo(path: Path, affix: str) -> str:
    """Return the photo's name without its ending, from the name of its file."""
    return path.name.removesuffix(affix).removesuffix(".json").removeprefix(affix)


def _text(path: Path) -> str:
    try:
        return read_text(path)
    except FileNotFoundError as error:
        raise KeypointsError(f"{path}: no such file or folder") from error
    except (OSError, ValueError) as error:
        raise KeypointsError(f"{path}: cannot be read ({reason_of(error)})") from error
