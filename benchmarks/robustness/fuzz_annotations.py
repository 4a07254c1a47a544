"""Annotations that the fuzzer damages: what is clicked, typed and taped, and a log that something else wrote into."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.robustness.fuzz_damage import Rng, broken_bytes, mutated
from benchmarks.robustness.fuzz_recordings import HandIn
from proxemetry.annotate.project import LOG_FILE, NO_POSE, Project
from proxemetry.errors import ProxemetryError
from proxemetry.scene import Scene
from synthetic.small_photos import write_photos

#: Of one photo in order; "scope" stands for the photos that are meant.
_ACTIONS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("add_person", {"points": {"Torso": [20, 40], "Head": [20, 10], "Eyes": [20, 9], "Shoulder": [20, 20]}}),
    ("add_person", {"points": {"Torso": [60, 40], "Head": [60, 10]}}),
    ("name_people", {"names": [{"person": 0, "tag": "P1"}, {"person": 1, "tag": "P2"}]}),
    ("set_point", {"person": 0, "part": "Torso", "to": [21, 41]}),
    ("set_lens", {"scope": "all", "lens": {"focal_mm": 50, "sensor_mm": [36, 24]}}),
    ("place_photos", {"scope": "all", "shoot": 0, "camera": "C0"}),
    ("set_spot", {"shoot": 0, "tag": "C0", "at": [0, 0]}),
    ("set_spot", {"shoot": 0, "tag": "P1", "at": [0, 3], "sd_m": 0.02}),
    ("set_tape", {"shoot": 0, "a": "P1", "b": "P2", "metres": 1.5}),
    ("set_tape", {"shoot": 0, "a": "C0", "b": "P2", "metres": 3.2, "sd_m": 0.05}),
    ("name_shoot", {"shoot": 0, "name": "hall"}), ("name_tag", {"tag": "P1", "name": "Ada"}),
    ("finish", {"done": True}),
)  # fmt: skip


@cache
def _photos_whole(folder: str) -> str:
    write_photos(Path(folder) / "own", 2)
    return str(Path(folder) / "own")


def annotations(rng: Rng, folder: Path) -> HandIn:
    """Prepare damaged annotations of two photos, and return what keeps, writes and checks them."""
    photos = _photos_whole(str(folder.parent))
    values = [(action, copy.deepcopy(value)) for action, value in _ACTIONS]
    for _ in range(int(rng.integers(1, 4))):
        at = int(rng.integers(len(values)))
        changed = mutated(rng, values[at][1], 1)
        values[at] = (values[at][0], changed if isinstance(changed, dict) else {})
    if rng.random() < 0.2:
        rng.shuffle(values)  # type: ignore[arg-type]
    breaks_log = rng.random() < 0.15

    def hand_in() -> Iterator[Scene]:
        refused: Exception | None = None
        project = Project([photos], str(folder / "labels"), pose=NO_POSE)
        for action, value in values:
            try:
                project.act(0, action, value)
            except ProxemetryError as error:
                refused = error
        faults = project.check()
        assert all("\n" not in str(fault) for fault in faults), "a fault of several lines"
        project.close()
        log = folder / "labels" / LOG_FILE
        if breaks_log:
            log.write_bytes(broken_bytes(rng, log.read_bytes()))
        again = Project([photos], str(folder / "labels"), pose=NO_POSE)
        assert breaks_log or again.now == project.now, "annotations differ after they were closed"
        again.undo()
        again.check()
        again.close()
        if refused is not None:
            raise refused
        yield from ()

    return hand_in
