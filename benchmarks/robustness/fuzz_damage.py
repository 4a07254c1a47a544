"""How the fuzzer damages a file: as JSON, as lines of cells, or as bytes; seeded, so that a fault can be repeated."""

from __future__ import annotations

import copy
import json
import math
from typing import Any

import numpy as np

Rng = np.random.Generator


def pick(rng: Rng, items: Any) -> Any:
    """Return one of the items."""
    return items[int(rng.integers(len(items)))]


_ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 1e308, -1e308, 1e-308, math.nan, math.inf, -math.inf, 10**400, -(10**400), 2**63, 0.5,
    1e9, 3e9, "", "x", "0", "1e400", "nan", "a\x00b", "\ud800", "=1+1", "../../x", "ä\u202e", [], {}, [[]], [None],
    {"a": 1},
)  # fmt: skip


def mutated(rng: Rng, content: Any, times: int) -> Any:
    """Return a JSON value with some of its parts replaced, doubled or taken away."""
    for _ in range(times):
        content = _changed(rng, content)
    return content


def _changed(rng: Rng, content: Any) -> Any:
    places: list[tuple[Any, Any]] = []
    waiting = [content]
    while waiting:
        item = waiting.pop()
        keys = list(item) if isinstance(item, dict) else range(len(item)) if isinstance(item, list) else ()
        for key in keys:
            places.append((item, key))
            waiting.append(item[key])
    if not places or rng.random() < 0.02:
        return _odd(rng)
    parent, key = pick(rng, places)
    way = rng.random()
    if way < 0.6:
        parent[key] = _odd(rng)
    elif way < 0.75 and isinstance(parent[key], int | float) and abs(parent[key]) < 1e300:
        parent[key] = float(parent[key]) * float(pick(rng, [-1, 0, 1e-9, 1e6, 1e200, 1e-300, 1000]))
    elif way < 0.9:
        del parent[key]
    elif isinstance(parent, list):
        parent.insert(key, copy.deepcopy(parent[key]))
    else:
        parent[f"{key} "] = parent[key]
    return content


def _odd(rng: Rng) -> Any:
    way = rng.random()
    if way < 0.02:
        return "long " * 20_000
    if way < 0.03:
        return [0] * 30_000
    return copy.deepcopy(pick(rng, _ODD))


def broken_json(rng: Rng, content: Any) -> bytes:
    """Return a JSON text with something changed in it, or broken as a text."""
    way = rng.random()
    if way < 0.01:
        return b"[" * 100_000
    text = json.dumps(mutated(rng, content, int(rng.choice([1, 2, 3], p=(0.6, 0.3, 0.1)))))
    return text.encode() if way < 0.8 else broken_bytes(rng, text.encode())


def broken_text(rng: Rng, text: str) -> bytes:
    """Return lines of cells with cells or lines changed, or broken as a text."""
    lines = text.split("\n")
    for _ in range(int(rng.choice([1, 2, 3], p=(0.6, 0.3, 0.1)))):
        row = int(rng.integers(len(lines)))
        separator = "," if "," in lines[row] else " "
        cells = lines[row].split(separator)
        column, way = int(rng.integers(len(cells))), rng.random()
        if way < 0.6:
            odd = _odd(rng)
            cells[column] = str(odd if not isinstance(odd, int) or abs(odd) < 10**50 else "1" + "0" * 400)
        elif way < 0.75:
            del cells[column]
        elif way < 0.9:
            cells.insert(column, cells[column])
        else:
            lines.insert(row, lines[row])
        lines[row] = separator.join(cells)
    content = "\n".join(lines).encode("utf-8", "surrogatepass")
    return content if rng.random() < 0.8 else broken_bytes(rng, content)


def broken_bytes(rng: Rng, content: bytes, head: float = 0.0) -> bytes:
    """Return bytes that are cut, flipped, repeated or overwritten; `head`: how often only near their beginning."""
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 5))):
        if not changed:
            break
        end = min(len(changed), 600) if rng.random() < head else len(changed)
        at, way = int(rng.integers(end)), rng.random()
        if way < 0.4:
            changed[at] ^= 1 << int(rng.integers(8))
        elif way < 0.6:
            changed[at : at + 4] = rng.integers(0, 256, 4, dtype=np.uint8).tobytes()
        elif way < 0.75:
            changed[at:at] = changed[at : at + int(rng.integers(1, 40))]
        elif way < 0.9:
            del changed[at : at + int(rng.integers(1, 40))]
        else:
            del changed[at:]
    return bytes(changed)
