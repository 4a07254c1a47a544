"""What is to be known of a network to run it, as a TOML file: the generic back end `onnx:SPEC.toml` reads one.

The package's own files in `specifications/` are the examples; docs/backends.md explains every key.
"""

from __future__ import annotations

import dataclasses
import importlib.resources
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from ... import weights
from ...errors import ModelError, SettingsError
from ...files import read_text, reason_of
from ...people.skeleton import Skeleton, skeleton_named
from ..detections import DECODERS
from .one_stage import ONE_STAGE
from .pose_decoders import HEADS

#: The ready ones, by name.
READY = tuple(
    sorted(
        entry.name.removesuffix(".toml")
        for entry in importlib.resources.files(__package__ or "").joinpath("specifications").iterdir()
        if entry.name.endswith(".toml")
    )
)

COLOURS = ("rgb", "bgr")


@dataclass(frozen=True)
class Input:
    """What a network wants to see, and how it computes.

    file: an absolute path, a file next to the specification, or a name of the model table. size: (width, height);
    (0, 0) where the file itself fixes it. colours: "rgb" or "bgr". mean, std: per channel in that order, of values
    0..255. eight_bits: LiteRT computes its larger convolutions in 8 bits; ONNX Runtime and OpenVINO pay no heed.
    """

    file: str
    decode: str
    size: tuple[int, int] = (0, 0)
    colours: str = "rgb"
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    std: tuple[float, float, float] = (1.0, 1.0, 1.0)
    eight_bits: bool = False


@dataclass(frozen=True)
class DetectorInput(Input):
    """A network that looks at the photo: a detector, or a one-stage network.

    fill, centred: how the photo is letterboxed. person: the class. score: boxes below are no people. overlap: boxes
    overlapping a better one by more are dropped. least_support: so are boxes that fewer of the network's cells see, in
    all looks together; 1 where it suppresses its own. tiles: the parts that are looked at, as fractions of the photo's
    sides (1 is the whole photo, and comes first); fast_tiles, thorough_tiles the same for those efforts. suspicion:
    where above 0, tiles lie only around boxes of the whole photo that score at least this; effort thorough asks for
    no suspicion.
    """

    fill: int = 114
    centred: bool = False
    person: int = 0
    score: float = 0.3
    overlap: float = 0.5
    least_support: int = 1
    suspicion: float = 0.0
    tiles: tuple[float, ...] = (1.0,)
    fast_tiles: tuple[float, ...] = (1.0,)
    thorough_tiles: tuple[float, ...] = ()


@dataclass(frozen=True)
class PoseInput(Input):
    """A network that looks at one person: padding is how much the box is grown."""

    padding: float = 1.25


@dataclass(frozen=True)
class Specification:
    """One back end: a detector with a top-down pose network, or a one-stage network alone.

    keypoint_score: joints below are missing. person_score: people below it are dropped. most_similar: of skeletons more
    alike than this the best one stays. least_inside: people less of whose nose, shoulders and hips lie in their own box
    are dropped. folder: where the files are looked for first.
    """

    name: str
    skeleton: Skeleton
    detector: DetectorInput
    pose: PoseInput | None
    keypoint_score: float = 0.2
    person_score: float = 0.3
    most_similar: float = 0.5
    least_inside: float = 0.5
    folder: Path = field(default_factory=Path)

    @property
    def files(self) -> tuple[str, ...]:
        """The networks, as the specification calls them."""
        return (self.detector.file, *((self.pose.file,) if self.pose else ()))

    @property
    def in_eight_bits(self) -> frozenset[str]:
        """Those of the networks that compute in 8 bits where LiteRT runs them."""
        parts = (self.detector, *((self.pose,) if self.pose else ()))
        return frozenset(part.file for part in parts if part.eight_bits)

    def path_of(self, file: str, device: str = "cpu") -> Path:
        """Return where a network's file lies, checked where the model table knows it; raises ModelError.

        For another device than the processor it is the network's ONNX form, where the table has one and it is here.
        """
        own = self.folder / file
        if own.is_file():
            return own
        try:
            forms = weights.model_named(file).same_as if device != "cpu" else ()
            onnx = [form for form in forms if form.endswith(".onnx") and weights.locate(form) is not None]
            return weights.verify(onnx[0]).path if onnx else weights.obtain(file).path
        except SettingsError as error:
            raise ModelError(
                f"{self.name}: {file} is neither next to the specification nor in the model table"
            ) from error


def read_specification(source: str) -> Specification:
    """Return a ready specification by its name, or the one in a TOML file.

    Raises SettingsError where there is neither, or where a key is unknown, missing or makes no sense.
    """
    if source in READY:
        text = importlib.resources.files(__package__ or "").joinpath("specifications", f"{source}.toml").read_text()
        return _parsed(text, source, Path())
    path = Path(source)
    try:
        text = read_text(path)
    except FileNotFoundError as error:
        raise SettingsError(f"specification {source!r}: no such file, nor one of {', '.join(READY)}") from error
    except (OSError, ValueError) as error:
        raise SettingsError(f"{path}: cannot be read ({reason_of(error)})") from error
    return _parsed(text, path.name, path.parent)


def _parsed(text: str, source: str, folder: Path) -> Specification:
    try:
        table = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SettingsError(f"{source}: not TOML ({error})") from error
    one_stage = "one_stage" in table
    if one_stage == ("pose" in table) or one_stage == ("detector" in table):
        raise SettingsError(f"{source}: give [detector] and [pose], or [one_stage] alone")
    detector = _section(DetectorInput, table.pop("one_stage" if one_stage else "detector"), source)
    pose = None if one_stage else _section(PoseInput, table.pop("pose"), source)
    _check(source, "decode", detector.decode, ONE_STAGE if one_stage else DECODERS)
    if pose:
        _check(source, "decode", pose.decode, HEADS)
    for part in (detector, *([pose] if pose else [])):
        _check(source, "colours", part.colours, COLOURS)
        if min(part.std) <= 0:
            raise SettingsError(f"{source}: std must be positive, not {list(part.std)}")
    try:
        skeleton = skeleton_named(str(table.pop("skeleton")))
        name = str(table.pop("name", source.removesuffix(".toml")))
        return _made(
            Specification, source, table, name=name, skeleton=skeleton, detector=detector, pose=pose, folder=folder
        )
    except KeyError as error:
        raise SettingsError(f"{source}: {error.args[0]} is missing") from error


_T = TypeVar("_T")


def _section(kind: type[_T], table: Any, source: str) -> _T:
    if not isinstance(table, dict):
        raise SettingsError(f"{source}: a section was expected, not {table!r}")
    return _made(kind, source, {key: tuple(v) if isinstance(v, list) else v for key, v in table.items()})


def _made(kind: type[_T], source: str, table: dict[str, Any], **given: Any) -> _T:
    """Return the dataclass made of a table's keys, each checked by the type of its default."""
    fields = {f.name: f for f in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for key, value in table.items():
        if key not in fields or key in given:
            raise SettingsError(f"{source}: {key!r} is unknown: use {', '.join(sorted(set(fields) - set(given)))}")
        default = fields[key].default
        if not _fits(value, default):
            raise SettingsError(f"{source}: {key} = {value!r} does not fit; an example is {default!r}")
    missing = [
        n for n, f in fields.items()
        if f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING and n not in {**table, **given}
    ]  # fmt: skip
    if missing:
        raise SettingsError(f"{source}: {', '.join(missing)} is missing")
    return kind(**table, **given)


def _fits(value: Any, default: Any) -> bool:
    if default is dataclasses.MISSING:
        return isinstance(value, str)
    if isinstance(default, tuple):
        numbers = isinstance(value, tuple) and all(isinstance(v, (int, float)) for v in value)
        return numbers and (len(value) == len(default) or len(default) in (0, 1)) and len(value) > 0
    if isinstance(default, float):
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, type(default))


def _check(source: str, key: str, value: str, known: Any) -> None:
    if value not in known:
        raise SettingsError(f"{source}: {key} = {value!r} is unknown: use one of {', '.join(known)}")
