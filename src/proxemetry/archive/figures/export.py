"""Results for other programs: SPSS files with labels, and keypoints in COCO's form."""

from __future__ import annotations

import importlib.util
import json
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from ...distances import UNCERTAIN
from ...errors import OutputError, SettingsError
from ...people.skeleton import COCO_17
from ...scene import Scene
from ...tables import Column, all_columns
from ..store.duck import named, quoted
from ..store.folder import Folder
from ..store.queries import attributes_in, table_query
from ..store.results import Results

COCO_FILE = "coco_keypoints.json"

#: The number that stands for "uncertain", declared missing: SPSS leaves it out of statistics.
_UNCERTAIN_CODE = 9

#: What SPSS takes for a variable's name, whatever its language.
_SPSS_NAME = re.compile(r"[a-z][A-Za-z0-9_.]{0,63}")

#: Rows of one SPSS file, as DuckDB hands them over: a little under a million.
_ROWS_A_VECTOR, _VECTORS_A_FILE = 2048, 488


def write_spss(results: Results, target: Folder, safe_distance_m: float | None = None) -> list[str]:
    """Write photos, people and pairs as .sav files with the codebook's meanings as variable labels; return their names.

    A file is made in memory, half a gigabyte for a million rows: a longer table comes in several files, pairs_1.sav
    and so on, and pairs.sps, SPSS syntax that joins them. Raises SettingsError where pyreadstat is missing,
    OutputError where a file cannot be written.
    """
    duck = results.view()
    attributes = attributes_in(duck)
    tables = {
        table: (columns, table_query(table, safe_distance_m, attributes))
        for table, columns in all_columns(attributes).items()
    }
    return write_sav_files(duck, tables, target)


def write_sav_files(duck: Any, tables: Mapping[str, tuple[Sequence[Column], str]], target: Folder) -> list[str]:
    """Write tables, each with its columns and the query that gives its rows, as `write_spss` does."""
    if any(importlib.util.find_spec(package) is None for package in ("pandas", "pyreadstat")):
        raise SettingsError("SPSS files need an extra: pip install 'proxemetry[spss]'")
    written: list[str] = []
    for table, (columns, rows) in tables.items():
        names_of = spss_names(columns)
        values = ", ".join(_spss_value(c, name) for c, name in zip(columns, names_of, strict=True))
        query = f"SELECT {values} FROM ({rows})"
        columns = [replace(c, name=name) for c, name in zip(columns, names_of, strict=True)]
        names, longest = _extent(duck, query, table, columns)
        _forget_spss(target, table)
        duck.execute(query)
        for name in names:
            with target.writing(name) as temporary:
                _write_sav(duck.fetch_df_chunk(_VECTORS_A_FILE), temporary, table, columns, longest)
        if len(names) > 1:
            target.write(f"{table}.sps", _joining_syntax(table, names).encode())
        written += names
    return written


def spss_names(columns: Sequence[Column]) -> list[str]:
    """Return how SPSS calls columns: as they are; attributes with other signs in their names are numbered."""
    return [
        c.name if _SPSS_NAME.fullmatch(c.name) else f"attribute_{number}" for number, c in enumerate(columns, start=1)
    ]


def _spss_value(column: Column, name: str) -> str:
    """Return the SQL of a column as SPSS has it under that name: a text, or a number where missing is missing.

    A categorical column is the number of its level, from 1, with the level as the value's label; "uncertain", which is
    no level of an order, is a missing value that has a label.
    """
    own, called = named(column.name), named(name)
    if column.levels:
        codes = " ".join(f"WHEN {quoted(level)} THEN {code}" for code, level in _codes(column).items())
        return f"(CASE {own} {codes} END)::DOUBLE AS {called}"
    if column.kind == "VARCHAR":
        return f"coalesce({own}, '') AS {called}"
    return f"{own}::{'INTEGER::' if column.kind == 'BOOLEAN' else ''}DOUBLE AS {called}"


def _codes(column: Column) -> dict[int, str]:
    """Return the number that stands for each level of a categorical column."""
    return {_UNCERTAIN_CODE if level == UNCERTAIN else k + 1: level for k, level in enumerate(column.levels)}


def _value_labels(column: Column) -> dict[float, str]:
    if column.kind == "BOOLEAN":
        return {0.0: "no", 1.0: "yes"}
    return {float(code): level for code, level in _codes(column).items()}


def _missing(column: Column) -> list[Any]:
    """Return the values that are declared missing; a number or a level that is missing needs none."""
    if column.levels:
        return [_UNCERTAIN_CODE] if UNCERTAIN in column.levels else []
    return [""] if column.kind == "VARCHAR" else []  # SPSS would count it as a valid text


def _measure(column: Column) -> str:
    """Return SPSS's level of measurement."""
    if column.levels:
        return "ordinal" if column.ordered else "nominal"
    return "nominal" if column.identifies or column.kind in ("VARCHAR", "BOOLEAN") else "scale"


def _extent(duck: Any, query: str, table: str, columns: Sequence[Column]) -> tuple[list[str], dict[str, int]]:
    """Return the names of a table's files, and how many bytes each text column needs."""
    texts = [c.name for c in columns if c.kind == "VARCHAR" and not c.levels]
    longest = ", ".join(f"coalesce(max(strlen({named(name)})), 0)" for name in texts)
    rows, *widths = duck.execute(f"SELECT count(*), {longest} FROM ({query})").fetchone()
    count = max(1, -(-rows // (_VECTORS_A_FILE * _ROWS_A_VECTOR)))
    names = [f"{table}.sav"] if count == 1 else [f"{table}_{k + 1}.sav" for k in range(count)]
    return names, dict(zip(texts, widths, strict=True))


def _forget_spss(target: Folder, table: str) -> None:
    """Remove an earlier export: fewer files of another length would be joined with these."""
    for name in target.names():
        if re.fullmatch(rf"{table}(_\d+)?\.sav|{table}\.sps", name):
            target.remove(name)


def _write_sav(frame: Any, path: str, table: str, columns: Sequence[Column], longest: Mapping[str, int]) -> None:
    import pyreadstat

    for name, width in longest.items():
        if len(frame):
            # SPSS joins files only where texts have one width, and a column is as wide as its widest value; blanks
            # at a text's end mean nothing there.
            first = frame[name].iloc[0]
            frame.loc[0, name] = first + " " * (width - len(first.encode()))
    try:
        pyreadstat.write_sav(
            frame, path, file_label=f"proxemetry: {table}", row_compress=True,
            column_labels={c.name: _label(c) for c in columns},
            variable_value_labels={c.name: labels for c in columns if (labels := _value_labels(c))},
            missing_ranges={c.name: missing for c in columns if (missing := _missing(c))},
            variable_measure={c.name: _measure(c) for c in columns},
            variable_format={c.name: "F8.0" for c in columns if c.kind in ("INTEGER", "BOOLEAN") or c.levels},
        )  # fmt: skip
        # On a full disk the writer reports nothing: what is there is read again, by its first column.
        back: Any = pyreadstat.read_sav(path, usecols=[str(frame.columns[0])])[0]
    except pyreadstat.ReadstatError as error:
        raise OutputError(f"{table}.sav: cannot be written ({error}); is there no space left on the disk?") from error
    if len(back) != len(frame):
        raise OutputError(f"{table}.sav: cannot be written whole; is there no space left on the disk?")


def _joining_syntax(table: str, names: Sequence[str]) -> str:
    files = "\n".join(f"  /FILE='{name}'" for name in names)
    return (
        f"* proxemetry: joins the files of the table {table}. CD to their folder first, or open this file from there.\n"
        f"ADD FILES\n{files}.\nEXECUTE.\nSAVE OUTFILE='{table}.sav' /COMPRESSED.\n"
    )


def _label(column: Column) -> str:
    meaning = column.meaning
    if column.kind == "BOOLEAN":  # the values' own labels
        meaning = meaning.replace("true:", "yes:").replace("false:", "no:")
    return f"{meaning} [{column.unit}]" if column.unit else meaning


def write_coco(results: Results, target: Folder) -> None:
    """Write all people's keypoints, corrections applied, as COCO keypoint annotations with scores.

    Joints that COCO does not name are left out; joints that a skeleton lacks or that were not seen have visibility 0.
    Raises OutputError where the file cannot be written.
    """
    edges = [[a, b] for a, b in ((COCO_17.index(x), COCO_17.index(y)) for x, y in COCO_17.bones) if None not in (a, b)]
    category = {
        "id": 1, "name": "person", "supercategory": "person", "keypoints": list(COCO_17.joints),
        "skeleton": [[a + 1, b + 1] for a, b in edges if a is not None and b is not None],
    }  # fmt: skip
    with target.writing(COCO_FILE) as temporary, open(temporary, "w", encoding="utf-8") as file:
        file.write('{"info": {"description": "keypoints by proxemetry"},\n"categories": ')
        json.dump([category], file)
        for name, items in (("images", _images(results)), ("annotations", _annotations(results))):
            file.write(f',\n"{name}": [')
            for number, item in enumerate(items):
                file.write((",\n" if number else "\n") + json.dumps(item, allow_nan=False))
            file.write("]")
        file.write("}\n")


def _readable(results: Results) -> Iterator[tuple[int, Scene]]:
    """Yield the photos that could be read, numbered from 1."""
    yield from enumerate((s for s in results.scenes() if s.status != "failed"), start=1)


def _images(results: Results) -> Iterator[dict[str, Any]]:
    for number, scene in _readable(results):
        yield {"id": number, "file_name": scene.photo, "width": scene.width_px, "height": scene.height_px}


def _annotations(results: Results) -> Iterator[dict[str, Any]]:
    identity = 0
    for number, scene in _readable(results):
        for person in range(len(scene)):
            identity += 1
            yield {"id": identity, "image_id": number, "category_id": 1, **_annotation(scene, person)}


def _carried(scene: Scene, person: int) -> dict[str, Any]:
    """Return what else the recording said about a person, as recordings spell it."""
    found: dict[str, Any] = {}
    people = scene.people
    if math.isfinite(people.depth_m[person]):
        found = {"depth_m": float(people.depth_m[person]), "depth_sd_m": float(people.depth_sd_m[person])}
    return {**found, "attributes": dict(people.attributes[person])} if people.attributes[person] else found


def _annotation(scene: Scene, person: int) -> dict[str, Any]:
    keypoints: list[float] = []
    scores: list[float] = []
    for joint in COCO_17.joints:
        x, y = (float(v) for v in scene.people.joint(joint)[person])
        seen = math.isfinite(x)
        keypoints += [round(x, 2), round(y, 2), 2] if seen else [0, 0, 0]
        scores.append(round(float(scene.people.joint_score(joint)[person]), 4))
    x0, y0, x1, y1 = (float(v) if math.isfinite(v) else 0.0 for v in scene.people.boxes_px[person])
    return {
        **_carried(scene, person),
        "keypoints": keypoints,
        "keypoint_scores": scores,
        "num_keypoints": sum(v > 0 for v in keypoints[2::3]),
        "bbox": [round(v, 2) for v in (x0, y0, x1 - x0, y1 - y0)],
        "area": round((x1 - x0) * (y1 - y0), 1),
        "iscrowd": 0,
        "score": round(float(scene.people.person_scores[person]), 4),
    }
