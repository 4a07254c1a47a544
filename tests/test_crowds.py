"""Crowds: bounded time and memory, and the same answers as everywhere for pairs that can matter."""

import json
import subprocess
import sys

import numpy as np
import pytest

from benchmarks.robustness.crowds import F_PX, HEIGHT, WIDTH, crowd
from proxemetry import distances
from proxemetry.bodies import Bodies
from proxemetry.camera.from_people import focal_profile
from proxemetry.camera.from_people.self_calibration import focal_posterior
from proxemetry.distances import measure_distances
from proxemetry.scene import Scene

_ARRAYS = ("distance_m", "low_m", "high_m", "distance_3d_m", "zone_probability", "group_probability")


def _bodies(count: int, seed: int = 3) -> Bodies:
    """People on a floor of 24 by 24 metres whose places are known to a tenth of a metre or two."""
    generator = np.random.default_rng(seed)
    places = np.column_stack([generator.uniform(-12, 12, count), np.full(count, 1.5), generator.uniform(8, 32, count)])
    root = generator.normal(0, 0.08, (3 * count, 3 * count + 5)) / np.sqrt(count)
    covariance = root @ root.T + 0.02 * np.eye(3 * count)
    heading, none = generator.uniform(-3, 3, count), (None,) * count
    return Bodies(
        places, covariance, "scene", ("torso",) * count, none, up=np.array([0.0, -1.0, 0.0]), heading_rad=heading,
        heading_sd_rad=np.full(count, 0.3),
    )  # fmt: skip


def test_near_pairs_of_a_crowd_have_the_answers_of_any_photo(monkeypatch: pytest.MonkeyPatch) -> None:
    bodies = _bodies(50)
    every = measure_distances(bodies)
    assert every.reach_m is None
    assert len(every.pairs()) == 50 * 49 // 2
    monkeypatch.setattr(distances, "CROWD", 49)
    near = measure_distances(bodies)
    listed = near.pairs()
    gap = np.linalg.norm(bodies.positions_m[:, None] - bodies.positions_m[None], axis=-1)
    assert listed == [(a, b) for a, b in every.pairs() if gap[a, b] <= distances.CROWD_REACH_M]
    assert 100 < len(listed) < 800
    a, b = np.array(listed).T
    for name in _ARRAYS:
        np.testing.assert_array_equal(getattr(near, name)[a, b], getattr(every, name)[a, b])
    assert near.below(8) == every.below(8)


def test_who_may_be_near_in_any_explanation_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    from proxemetry.bodies import Mode

    bodies = _bodies(4)
    far = bodies.positions_m * (1, 1, 10)
    both = Bodies(
        far, bodies.covariance_m2, "scene", bodies.basis, bodies.reasons, up=bodies.up,
        modes=(Mode(0.7, far, bodies.covariance_m2), Mode(0.3, bodies.positions_m / (9, 1, 9), bodies.covariance_m2)),
    )  # fmt: skip
    monkeypatch.setattr(distances, "CROWD", 3)
    assert len(measure_distances(both).pairs()) == 6


def test_600_people_take_seconds_and_little_memory_and_2000_are_no_end_of_the_process() -> None:
    command = [sys.executable, "-m", "benchmarks.robustness.crowds", "--one", "600"]
    row = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    assert row["placed"] > 500
    assert row["all_s"] < 15  # 6 on a quiet machine
    assert row["peak_mb"] < 1000


def test_a_crowd_s_focal_length_needs_no_list_of_all_triples() -> None:
    found = focal_posterior(crowd(2000), WIDTH, HEIGHT)  # 1.3 billion triples
    assert not isinstance(found, str)
    assert found.low_px < F_PX < found.high_px
    assert found.f_px == pytest.approx(F_PX, rel=0.1)


@pytest.mark.parametrize("count", [3, 9, 10, 50])
def test_triples_of_few_people_are_drawn_from_all(count: int) -> None:
    triples = focal_profile._triples(count)
    every = count * (count - 1) * (count - 2) // 6
    assert len(triples) == min(every, 120)
    assert len({tuple(t) for t in triples.tolist()}) == len(triples)
    many = focal_profile._triples(1000)
    assert many.shape == (120, 3)
    assert all(len(set(t)) == 3 for t in many.tolist())


def test_a_crowd_s_scene_is_read_back_as_it_was_written(monkeypatch: pytest.MonkeyPatch) -> None:
    from proxemetry import scene_json as module
    from proxemetry.camera import Camera, CameraEstimate
    from proxemetry.measure import place
    from proxemetry.settings import Settings

    people = crowd(8)
    camera = CameraEstimate(Camera.centred(F_PX, WIDTH, HEIGHT))
    scene = place("a.jpg", "", WIDTH, HEIGHT, people, camera, Settings())
    plain = Scene.from_json(scene.to_json())
    monkeypatch.setattr(module, "_MOST_AS_NUMBERS", 3)
    assert '"covariance_m2":"' in scene.to_json()
    packed = Scene.from_json(scene.to_json())
    np.testing.assert_allclose(packed.bodies.covariance_m2, plain.bodies.covariance_m2, rtol=1e-6)
    np.testing.assert_allclose(packed.distances_m, plain.distances_m, rtol=1e-6)
