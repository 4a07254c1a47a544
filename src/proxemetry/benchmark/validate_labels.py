"""Every fault of a labels folder at once, with file, line and what was expected: for users who add photos to it."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ..errors import LabelsError
from ..files import csv_lines, read_bytes, read_text, reason_of
from ..people.skeleton import PARTS
from .errata import load_errata
from .labels import BODY_FILE, FOCAL_FILES, PHOTOS_FILE, SETTINGS_FILE, TRUTH_FILE

_COLUMNS = {
    BODY_FILE: ("person", "part", "x", "y", "filename", "width", "height"),
    TRUTH_FILE: ("shoot", "tag", "x", "y", "z"),
    PHOTOS_FILE: ("shoot", "camera", "filename"),
}
_PERSON, _PLACE = re.compile(r"P\d+"), re.compile(r"[PC]\d+")


@dataclass(frozen=True)
class Fault:
    """What is wrong on a line of a file (0: the file as a whole) and what was expected there.

    harmless: a note, which nothing has to be done about.
    """

    file: str
    line: int
    text: str
    harmless: bool = False

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}" if self.line else self.file
        return f"{where}: {'note: ' if self.harmless else ''}{self.text}"


@dataclass(frozen=True)
class _Line:
    number: int
    fields: tuple[str, ...]


def check_labels(folder: str | Path) -> list[Fault]:
    """Return every fault of a labels folder, none for a clean one.

    Known errata of KORTE and a whole file of CRLF line ends are harmless: the published labels have both.

    Raises LabelsError where `folder` is no folder.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise LabelsError(f"{folder}: no such folder; give the one that holds {', '.join(_COLUMNS)}")
    faults: list[Fault] = []
    lines = {name: _read(folder / name, len(columns), faults) for name, columns in _COLUMNS.items()}
    faults += _check_truth(lines[TRUTH_FILE])
    faults += _check_photos(lines[PHOTOS_FILE])
    faults += _check_marks(lines[BODY_FILE])
    faults += _check_together(lines)
    headers = {SETTINGS_FILE: ("shoot", "setting")} | dict.fromkeys(FOCAL_FILES, ("filename", "focal_length_mm"))
    for name, columns in headers.items():
        if (folder / name).exists():
            faults += _check_header(folder / name, columns)
    return sorted(faults, key=lambda fault: (fault.file, fault.line))


def _read(path: Path, columns: int, faults: list[Fault]) -> list[_Line]:
    """Return the lines with the right number of columns; what is wrong with the others, and the file, is a fault."""
    try:
        content = read_bytes(path)
    except OSError as error:
        if not isinstance(error, FileNotFoundError):
            faults.append(Fault(path.name, 0, f"cannot be read ({error.strerror})"))
            return []
        faults.append(Fault(path.name, 0, "no such file; all three label files are needed"))
        return []
    if content.startswith(b"\xef\xbb\xbf"):
        faults.append(Fault(path.name, 1, "starts with a byte order mark: save as UTF-8 without BOM"))
    faults += _check_line_ends(path.name, content)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        faults.append(Fault(path.name, content[: error.start].count(b"\n") + 1, "not UTF-8 text"))
        return []
    if not text.strip():
        faults.append(Fault(path.name, 0, f"empty; rows of {','.join(_COLUMNS[path.name])} are expected"))
    lines: list[_Line] = []
    try:
        rows = list(csv.reader(csv_lines(text)))
    except csv.Error as error:
        faults.append(Fault(path.name, 0, f"cannot be read as CSV ({error})"))
        return []
    for number, row in enumerate(rows, start=1):
        if not row:
            faults.append(Fault(path.name, number, "empty line"))
        elif len(row) != columns:
            expected = ",".join(_COLUMNS[path.name])
            faults.append(Fault(path.name, number, f"{len(row)} columns; {columns} are expected: {expected}"))
        else:
            if any(field != field.strip() for field in row):
                faults.append(Fault(path.name, number, "blanks around a field: names are compared as they stand"))
            lines.append(_Line(number, tuple(field.strip() for field in row)))
    return lines


def _check_line_ends(name: str, content: bytes) -> Iterator[Fault]:
    ends = [line.endswith(b"\r\n") for line in content.splitlines(keepends=True)]
    if not any(ends):
        return
    if all(ends):
        yield Fault(name, 1, "lines end with CRLF where LF is expected; read all the same", harmless=True)
        return
    odd = ends.index(not ends[0]) + 1
    yield Fault(
        name,
        odd,
        f"line ends with {'CRLF' if ends[odd - 1] else 'LF'}, unlike the lines before: one kind, LF, is expected",
    )


def _number_or_nan(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _check_truth(lines: list[_Line]) -> Iterator[Fault]:
    first: dict[tuple[str, str], int] = {}
    places: dict[tuple[str, tuple[str, ...]], int] = {}
    for line in lines:
        shoot, tag, *xyz = line.fields
        if not _PLACE.fullmatch(tag):
            yield Fault(TRUTH_FILE, line.number, f"tag {tag!r}; P and a number (a person) or C and a number (a camera)")
        if not shoot.isdigit():
            yield Fault(TRUTH_FILE, line.number, f"shoot {shoot!r}; a whole number is expected")
        for axis, text in zip("xyz", xyz, strict=True):
            if not math.isfinite(_number_or_nan(text)):
                yield Fault(TRUTH_FILE, line.number, f"{axis} is {text!r}; a number of millimetres is expected")
        if (shoot, tag) in first:
            yield Fault(
                TRUTH_FILE, line.number, f"{tag} of shoot {shoot} again; line {first[shoot, tag]} has it already"
            )
        elif tag.startswith("P") and (shoot, tuple(xyz)) in places:
            other = places[shoot, tuple(xyz)]
            yield Fault(TRUTH_FILE, line.number, f"{tag} stands where the person of line {other} stands")
        first.setdefault((shoot, tag), line.number)
        if tag.startswith("P"):
            places.setdefault((shoot, tuple(xyz)), line.number)


def _check_photos(lines: list[_Line]) -> Iterator[Fault]:
    first: dict[str, _Line] = {}
    for line in lines:
        _, camera, filename = line.fields
        if not re.fullmatch(r"C\d+", camera):
            yield Fault(PHOTOS_FILE, line.number, f"camera {camera!r}; C and a number is expected")
        if not filename:
            yield Fault(PHOTOS_FILE, line.number, "no filename")
        known = first.setdefault(filename.lower(), line)
        if known is not line:
            what = "again" if known.fields[2] == filename else "differs in case alone from another name"
            yield Fault(PHOTOS_FILE, line.number, f"photo {filename} {what}; line {known.number} has it already")


def _check_marks(lines: list[_Line]) -> Iterator[Fault]:
    seen: dict[tuple[str, str, str], int] = {}
    sizes: dict[str, tuple[str, str, int]] = {}
    for line in lines:
        tag, part, _, _, filename, width, height = line.fields
        if not _PERSON.fullmatch(tag):
            yield Fault(BODY_FILE, line.number, f"person {tag!r}; P and a number is expected")
        if part not in PARTS:
            yield Fault(BODY_FILE, line.number, f"part {part!r} is unknown; one of {', '.join(PARTS)} is expected")
        yield from _check_pixels(line)
        known = sizes.setdefault(filename, (width, height, line.number))
        if known[:2] != (width, height):
            text = f"photo {filename} is {width}x{height} here, {known[0]}x{known[1]} on line {known[2]}"
            yield Fault(BODY_FILE, line.number, f"{text}; one size a photo is expected")
        key = (filename, tag, part)
        if owner := _known_owner(line):
            yield Fault(BODY_FILE, line.number, f"{part} of {tag} in {filename} is {owner}'s: a known erratum", True)
        elif key in seen:
            yield Fault(BODY_FILE, line.number, f"{part} of {tag} in {filename} again; line {seen[key]} has it already")
        seen.setdefault(key, line.number)


def _check_pixels(line: _Line) -> Iterator[Fault]:
    for axis, text, side, extent in zip("xy", line.fields[2:4], ("width", "height"), line.fields[5:7], strict=True):
        if not extent.isdigit() or int(extent) == 0:
            yield Fault(BODY_FILE, line.number, f"{side} is {extent!r}; a positive whole number of pixels is expected")
        if not text.isdigit():
            yield Fault(BODY_FILE, line.number, f"{axis} is {text!r}; a whole number of pixels is expected")
        elif extent.isdigit() and int(text) >= int(extent):
            yield Fault(
                BODY_FILE, line.number, f"{axis} is {text}, outside the photo; 0 to {int(extent) - 1} is expected"
            )


def _known_owner(line: _Line) -> str | None:
    """Return whose point this is, where the published label is known to be wrong."""
    tag, part, x, y, filename, *_ = line.fields
    owners = (
        e.belongs_to
        for e in load_errata()
        if e.filename == filename and e.concerns(tag, part, _number_or_nan(x), _number_or_nan(y))
    )
    return next(owners, None)


def _check_together(lines: dict[str, list[_Line]]) -> Iterator[Fault]:
    """Yield what one file has of people, cameras and photos that another does not know."""
    places = {(line.fields[0], line.fields[1]) for line in lines[TRUTH_FILE]}
    photos = {line.fields[2]: line for line in lines[PHOTOS_FILE]}
    annotated = {line.fields[4] for line in lines[BODY_FILE]}
    for line in lines[PHOTOS_FILE]:
        shoot, camera, filename = line.fields
        if (shoot, camera) not in places:
            yield Fault(PHOTOS_FILE, line.number, f"shoot {shoot} has no camera {camera} in {TRUTH_FILE}")
        if filename not in annotated:
            yield Fault(PHOTOS_FILE, line.number, f"photo {filename} has no person in {BODY_FILE}; one point at least")
    reported: set[tuple[str, str]] = set()
    for line in lines[BODY_FILE]:
        tag, filename = line.fields[0], line.fields[4]
        if (tag, filename) in reported:
            continue
        reported.add((tag, filename))
        if filename not in photos:
            yield Fault(BODY_FILE, line.number, f"photo {filename} has no row in {PHOTOS_FILE}")
        elif (photos[filename].fields[0], tag) not in places:
            shoot = photos[filename].fields[0]
            yield Fault(
                BODY_FILE, line.number, f"{tag} is in {filename}, but shoot {shoot} has no {tag} in {TRUTH_FILE}"
            )


def _check_header(path: Path, columns: tuple[str, ...]) -> Iterator[Fault]:
    try:
        rows = csv.DictReader(csv_lines(read_text(path)))
        listed, fields = list(rows), rows.fieldnames or ()
    except (OSError, ValueError, csv.Error) as error:
        yield Fault(path.name, 0, f"cannot be read as text ({reason_of(error)})")
        return
    for column in columns:
        if column not in fields:
            yield Fault(path.name, 1, f"no column {column!r} in the header; {','.join(columns)} are expected")
            return
    for line, row in enumerate(listed, start=2):
        value = row[columns[1]]
        if value is None or row[columns[0]] is None:
            yield Fault(path.name, line, f"{','.join(columns)} are expected")
        elif columns[1] == "focal_length_mm" and not 0 < _number_or_nan(value) < math.inf:
            yield Fault(path.name, line, f"focal_length_mm is {value[:40]!r}; millimetres are expected")
        for side in ("sensor_width_mm", "sensor_height_mm"):
            if (value := row.get(side)) and not 0 < _number_or_nan(value) < math.inf:
                yield Fault(path.name, line, f"{side} is {value[:40]!r}; millimetres are expected, or nothing")
