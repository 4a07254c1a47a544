"""Boxes in MOT Challenge's text: frame, id, left, top, width, height, score and more, a line each."""

from __future__ import annotations

import configparser
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from ...errors import KeypointsError
from ...people.skeleton import BOX
from .recording import Person, RecordedPhoto, box_person, naming, people_of

_FEWEST = 6


def is_mot(text: str) -> bool:
    """Return whether a text's first line is one of MOT's: six numbers or more with commas between."""
    first = next((line for line in text.splitlines() if line.strip()), "")
    cells = first.split(",")
    try:
        return len([float(cell) for cell in cells]) >= _FEWEST
    except ValueError:
        return False


def read_mot(path: Path, text: str) -> Iterator[RecordedPhoto]:
    """Yield the frames of a text, called by their numbers in six digits as MOT calls its pictures.

    The pictures' size is that of `seqinfo.ini` next to the file or above it, where there is one. Raises KeypointsError
    with the line that is wrong.
    """
    frames: dict[int, list[Person]] = defaultdict(list)
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        with naming(f"{path}, line {number}"):
            cells = [float(cell) for cell in line.split(",")]
            if len(cells) < _FEWEST or cells[0] != int(cells[0]):
                raise KeypointsError("it must be frame, id, left, top, width, height")
            left, top, width, height = cells[2:6]
            score = cells[6] if len(cells) > _FEWEST and 0 <= cells[6] <= 1 else None
            if score != 0:  # ground truth marks with 0 what is not to be counted
                frames[int(cells[0])].append(box_person((left, top, left + width, top + height), score))
    size = _size(path)
    for frame, persons in sorted(frames.items()):
        yield RecordedPhoto(f"{frame:06d}", people_of(BOX, persons), *size, number=frame)


def _size(path: Path) -> tuple[float | None, float | None]:
    for folder in (path.parent, path.parent.parent):
        info = configparser.ConfigParser()
        if info.read(folder / "seqinfo.ini") and info.has_section("Sequence"):
            return info.getfloat("Sequence", "imWidth"), info.getfloat("Sequence", "imHeight")
    return None, None
