"""A short run of the fuzzer over every kind of file, and what it must notice."""

import numpy as np
import pytest

from benchmarks.robustness.fuzz import Outcome, _judged, check_scene, fuzz, plan
from benchmarks.robustness.fuzz_files import WHOLE, _scene_whole


@pytest.mark.parametrize("seed", [1, 2])
def test_damaged_files_give_a_result_or_one_line(seed: int) -> None:
    outcomes, peak = fuzz(120, seed, list(WHOLE))
    assert [o for o in outcomes if o.is_fault] == []
    assert peak < 1_000_000_000
    assert {o.what for o in outcomes} == {"result", "line"}
    assert {o.kind for o in outcomes} == set(WHOLE)


def test_every_kind_has_its_share() -> None:
    listed = list(plan(1000, list(WHOLE)))
    assert abs(len(listed) - 1000) < 10
    assert sum(kind == "recording" for kind, _ in listed) > 300


def test_wrong_answers_are_noticed() -> None:
    scene = _scene_whole()
    check_scene(scene)
    for name, change in (("low_m", 2.0), ("high_m", 0.1), ("distance_m", np.nan)):
        found = scene.distances
        array = getattr(found, name).copy()
        array[0, 1] = array[1, 0] = change * array[0, 1]
        broken = _with_distances(scene, name, array)
        with pytest.raises(AssertionError):
            check_scene(broken)


def _with_distances(scene, name, array):
    from dataclasses import replace

    changed = replace(scene)
    changed.__dict__["distances"] = replace(scene.distances, **{name: array})
    return changed


def test_what_is_no_line_is_noticed() -> None:
    assert _judged("a.json: not JSON") == ("line", "a.json: not JSON")
    assert [_judged(text)[0] for text in ("", "a\nb", "x" * 2000)] == ["no line"] * 3
    assert Outcome("labels", 0, "traceback").is_fault
    assert not Outcome("labels", 0, "line").is_fault
