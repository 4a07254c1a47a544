"""The published protocol against an independent scorer written from its description, list by list."""

from __future__ import annotations

import csv
import itertools
import json
import math
import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proxemetry.benchmark import Labels, Prediction, Predictions, read_labels, read_predictions, score, score_files
from proxemetry.benchmark.seker2021 import _nearest
from proxemetry.people import skeleton

KORTE = Path(__file__).parent.parent.parent / "shared" / "data" / "korte"
PARTS = ("Shoulder", "Eyes", "Torso", "Head")
needs_korte = pytest.mark.skipif(not KORTE.exists(), reason="the labels of the KORTE benchmark are not here")


class Reference:
    """Scores one photo after the description in METHOD, with lists and dictionaries and no numpy."""

    def __init__(self, folder: Path) -> None:
        def rows(name: str) -> list[list[str]]:
            return list(csv.reader((folder / name).read_text().splitlines()))

        self.marks = rows("body_pixel_locations.csv")
        self.shoot = {r[2]: r[0] for r in rows("camera_locations_photoshoot_identifiers.csv")}
        self.truth = {
            (r[0], r[1]): tuple(float(v) for v in r[2:]) for r in rows("ground_truth_locations.csv") if r[1][0] == "P"
        }

    def score(self, image: dict[str, Any]) -> tuple[float, float, float, float]:
        """Return (pair error, detection rate, false discovery rate, mean distance)."""
        name, people = image["filename"], image["people"]
        if "distances_mm" in image:
            return self._score_distances(image)
        locations = [tuple(p["position_mm"]) for p in people]
        between = [math.dist(a, b) for a, b in itertools.combinations(locations, 2)]
        mean = sum(between) / len(between) if between else 0.0
        tags = self._tags(image)
        error = 0.0
        if tags is not None:
            located = {t: locations[i] for i, t in enumerate(tags)}
            located = {t: p for t, p in located.items() if p != (0, 0, 0)}
            error = self._error(
                name, {(a, b): math.dist(located[a], located[b]) for a, b in itertools.combinations(located, 2)}
            )
        return error, *self._rates(name, len(people)), mean

    def _score_distances(self, image: dict[str, Any]) -> tuple[float, float, float, float]:
        count = len(image["people"])
        given = {(min(i, j), max(i, j)): d for i, j, d in image["distances_mm"]}
        order = list(itertools.combinations(range(count), 2))
        if count < 2 or any(pair not in given for pair in order):
            return 0.0, 0.0, 0.0, 0.0
        distances = [given[pair] for pair in order]
        tags = self._tags(image)
        if tags is None:
            return 0.0, 0.0, 0.0, 0.0
        taken = dict(zip(itertools.combinations(tags, 2), distances, strict=False))
        return (
            self._error(image["filename"], taken),
            *self._rates(image["filename"], count),
            sum(distances) / len(distances),
        )

    def _tags(self, image: dict[str, Any]) -> list[str] | None:
        name = image["filename"]
        marks = [m for m in self.marks if m[4] == name]
        sx, sy = int(marks[0][5]) / image["width"], int(marks[0][6]) / image["height"]
        claims: list[tuple[str, float]] = []
        for person in image["people"]:
            points = {part: person["points"].get(part, [0, 0]) for part in PARTS}
            if all(p == [0, 0] for p in points.values()):
                return None
            candidates = [
                (math.hypot(points[part][0] * sx - int(m[2]), points[part][1] * sy - int(m[3])), k, m[0])
                for k, part in enumerate(PARTS)
                for m in marks
                if m[1] == part and points[part][0] != 0 and points[part][1] != 0
            ]
            best = min(candidates, key=lambda c: (c[0], c[1]), default=(1e6, 0, f"?{len(claims)}"))
            claims.append((best[2] if best[2][0] != "?" else "?", best[0]))
        keep = [
            i
            for i, (tag, d) in enumerate(claims)
            if not any(t == tag and (e < d or (e == d and j < i)) for j, (t, e) in enumerate(claims))
        ]
        return [claims[i][0] for i in keep]

    def _error(self, name: str, estimates: dict[tuple[str, str], float]) -> float:
        shoot, errors = self.shoot[name], []
        for (a, b), estimate in estimates.items():
            if "?" not in (a, b):
                true = math.dist(self.truth[shoot, a], self.truth[shoot, b])
                errors.append(abs(estimate - true) / true * 100)
        return sum(errors) / len(errors) if errors else 0.0

    def _rates(self, name: str, detected: int) -> tuple[float, float]:
        annotated = len({m[0] for m in self.marks if m[4] == name})
        false = (detected - annotated) / detected if detected > annotated else 0.0
        return min(1.0, detected / annotated), false


def random_predictions(seed: int, kind: str) -> dict[str, Any]:
    """Make answers with everything that can happen: parts missing, duplicates, strangers, zeros, other sizes."""
    rng, images = random.Random(seed), []
    for label in read_labels(KORTE, errata=False):
        scale = rng.choice([1.0, 0.5, 0.37])
        people: list[dict[str, Any]] = []
        for k, tag in enumerate(label.tags):
            if rng.random() < 0.1:
                continue
            for _ in range(rng.choice([1, 1, 1, 1, 1, 1, 2, 3])):
                own = [m for m in label.marks if m.tag == tag and rng.random() < 0.7] or [
                    m for m in label.marks if m.tag == tag
                ][:1]
                noise = rng.choice([0, 3, 40, 300])
                points = {
                    m.part: [(m.x + rng.gauss(0, noise)) * scale, (m.y + rng.gauss(0, noise)) * scale] for m in own
                }
                if rng.random() < 0.03:
                    points[rng.choice(PARTS)] = rng.choice([[0, 0], [0, 200.0], [300.0, 0]])
                x, y, z = label.positions_mm[k] * rng.gauss(1, 0.2)
                people.append({"position_mm": [x + rng.gauss(0, 200), y, z], "points": points})
        if rng.random() < 0.1:
            people.append({"position_mm": [1.0, 2.0, 3.0], "points": {"Head": [5.0, 7.0]}})
        if people and rng.random() < 0.15:
            rng.choice(people)["position_mm"] = [0, 0, 0]
        if people and rng.random() < 0.05:
            rng.choice(people)["points"] = {"Eyes": [0, 0]}
        rng.shuffle(people)
        image = {
            "filename": label.filename,
            "width": label.width * scale,
            "height": label.height * scale,
            "people": people,
        }
        if kind == "distances":
            pairs = list(itertools.combinations(range(len(people)), 2))
            image["distances_mm"] = [[i, j, rng.uniform(300, 6000)] for i, j in pairs if rng.random() < 0.995]
            for person in people:
                del person["position_mm"]
        images.append(image)
    return {"images": images}


@needs_korte
@pytest.mark.parametrize("kind", ["positions", "distances"])
@pytest.mark.parametrize("seed", range(4))
def test_every_figure_of_every_photo_equals_the_reference(seed: int, kind: str, tmp_path: Path) -> None:
    content = random_predictions(seed, kind)
    path = tmp_path / "predictions.json"
    path.write_text(json.dumps(content))
    result = score_files(path, KORTE, "seker2021")
    reference = Reference(KORTE)
    assert len(result.images) == 96
    for image, given in zip(result.images, content["images"], strict=True):
        error, detection, false, mean = reference.score(given)
        assert image.pair_error_pct == pytest.approx(error, abs=1e-9), given["filename"]
        assert image.detection_rate == pytest.approx(detection, abs=1e-12)
        assert image.false_discovery_rate == pytest.approx(false, abs=1e-12)
        assert image.mean_distance_mm == pytest.approx(mean, abs=1e-6)
    overall = [reference.score(given)[0] for given in content["images"]]
    assert result.overall.pair_error_pct_mean_over_images == pytest.approx(sum(overall) / 96)


def small_benchmark(folder: Path) -> None:
    """Three people on a 3-4-5 triangle (metres), one photo of 1000 x 800 pixels, all four parts annotated."""
    parts = {"Eyes": 100, "Head": 110, "Shoulder": 160, "Torso": 220}
    body = [f"P{k},{part},{200 + 300 * k},{y},a.jpg,1000,800" for k in range(3) for part, y in parts.items()]
    (folder / "body_pixel_locations.csv").write_text("\n".join(body) + "\n")
    places = ["0,C0,0,0,0", "0,P0,0,0,5000", "0,P1,3000,0,5000", "0,P2,3000,0,9000"]
    (folder / "ground_truth_locations.csv").write_text("\n".join(places) + "\n")
    (folder / "camera_locations_photoshoot_identifiers.csv").write_text("0,C0,a.jpg\n")


def person(k: int, position: list[float], dx: float = 0.0) -> dict[str, Any]:
    return {"position_mm": position, "points": {"Shoulder": [200 + 300 * k + dx, 160]}}


TRUTH = [[0.0, 0.0, 5000.0], [3000.0, 0.0, 5000.0], [3000.0, 0.0, 9000.0]]


def scored(tmp_path: Path, people: list[dict[str, Any]], **image: Any) -> Any:
    small_benchmark(tmp_path)
    content = {"filename": "a.jpg", "width": 1000, "height": 800, "people": people, **image}
    path = tmp_path / "p.json"
    path.write_text(json.dumps({"images": [content]}))
    return score(read_labels(tmp_path, errata=False), read_predictions(path), "seker2021").images[0]


def test_a_triangle_answered_exactly_scores_zero(tmp_path: Path) -> None:
    result = scored(tmp_path, [person(k, TRUTH[k]) for k in range(3)])
    assert (result.pair_error_pct, result.detection_rate, result.false_discovery_rate) == (0, 1, 0)
    assert result.mean_distance_mm == pytest.approx((3000 + 4000 + 5000) / 3)


def test_a_dropped_duplicate_shifts_the_locations_of_those_after_it(tmp_path: Path) -> None:
    people = [person(0, TRUTH[0]), person(0, TRUTH[0], dx=5), person(1, TRUTH[1]), person(2, TRUTH[2])]
    result = scored(tmp_path, people)
    # P0 keeps its place, P1 gets P0's and P2 gets P1's: pairs 0 for 3 m, 3 for 5 m, 3 for 4 m.
    assert result.pair_error_pct == pytest.approx((100 + 40 + 25) / 3)
    assert result.false_discovery_rate == pytest.approx(1 / 4)
    assert result.detection_rate == 1


def test_a_location_at_the_origin_is_detected_but_left_out(tmp_path: Path) -> None:
    result = scored(tmp_path, [person(0, TRUTH[0]), person(1, [0, 0, 0]), person(2, TRUTH[2])])
    assert (result.n_detected, result.n_pairs, result.pair_error_pct) == (3, 1, 0)
    assert result.detection_rate == 1


def test_a_person_without_a_point_makes_the_error_zero(tmp_path: Path) -> None:
    wrong = person(1, [0.0, 0.0, 11000.0])
    result = scored(tmp_path, [person(0, TRUTH[0]), wrong, {"position_mm": TRUTH[2], "points": {}}])
    assert (result.pair_error_pct, result.n_detected) == (0, 3)
    assert scored(tmp_path, [person(0, TRUTH[0]), wrong]).pair_error_pct == pytest.approx(100)


def test_people_without_a_position_are_not_counted(tmp_path: Path) -> None:
    unplaced = {"points": {"Shoulder": [500, 160]}}
    result = scored(tmp_path, [person(0, TRUTH[0]), unplaced, person(2, TRUTH[2])])
    assert (result.n_detected, result.n_pairs, result.pair_error_pct) == (2, 1, 0)


def test_distances_are_consumed_in_order_after_a_drop(tmp_path: Path) -> None:
    people = [{"points": person(k, [])["points"]} for k in (0, 0, 1)]
    result = scored(tmp_path, people, distances_mm=[[0, 1, 3300], [0, 2, 1], [1, 2, 1]])
    # Tags shrink to P0, P1; their one pair takes the first distance, that between the two claimants of P0.
    assert result.pair_error_pct == pytest.approx(10)
    assert scored(tmp_path, people[:1], distances_mm=[]).detection_rate == 0
    assert scored(tmp_path, people, distances_mm=[[0, 1, 3300]]).detection_rate == 0


def test_a_distance_to_who_shows_no_annotated_part_is_no_pair(tmp_path: Path) -> None:
    """One shows eyes alone, and eyes are annotated nowhere: of three distances that between the others counts."""
    stranger = {"points": {"Eyes": [5, 5]}}
    others = [{"points": person(k, [])["points"]} for k in (0, 1)]
    for at, distances in ((0, [1, 1, 3300]), (2, [3300, 1, 1])):
        people = [*others[:at], stranger, *others[at:]]
        given = [[a, b, mm] for (a, b), mm in zip(((0, 1), (0, 2), (1, 2)), distances, strict=True)]
        small_benchmark(tmp_path)
        body = tmp_path / "body_pixel_locations.csv"
        body.write_text("".join(line for line in body.read_text().splitlines(True) if "Eyes" not in line))
        content = {"filename": "a.jpg", "width": 1000, "height": 800, "people": people, "distances_mm": given}
        (tmp_path / "p.json").write_text(json.dumps({"images": [content]}))
        answers = read_predictions(tmp_path / "p.json")
        (result,) = score(read_labels(tmp_path, errata=False), answers, "seker2021").images
        assert (result.n_pairs, result.pair_error_pct) == (1, pytest.approx(10))


def test_nobody_and_no_answer_score_zero_error(tmp_path: Path) -> None:
    nobody = scored(tmp_path, [])
    assert (nobody.pair_error_pct, nobody.detection_rate, nobody.false_discovery_rate) == (0, 0, 0)
    empty = tmp_path / "empty.json"
    empty.write_text('{"images": []}')
    result = score_files(empty, tmp_path, "seker2021")
    assert result.overall.pair_error_pct_mean_over_images == 0
    assert result.overall.n_unscored == 1


@needs_korte
def test_perfect_positions_with_duplicates_show_why_there_is_another_protocol(tmp_path: Path) -> None:
    """5 % of people found twice: METHOD quotes 12.7 % for one draw; the mean over draws is of that size."""
    labels, errors = read_labels(KORTE, errata=False), []
    for seed in range(5):
        answers = duplicated(labels, seed, tmp_path)
        errors.append(score(labels, answers, "seker2021").overall.pair_error_pct_mean_over_images)
        corrected = read_labels(KORTE)
        answers = duplicated(corrected, seed, tmp_path)
        assert score(corrected, answers, "v1").overall.pair_error_pct_mean_over_images == 0
    assert 5 < sum(errors) / len(errors) < 25


def duplicated(labels: Labels, seed: int, folder: Path) -> Predictions:
    """Return perfect answers in which one person in twenty appears twice."""
    rng, images = random.Random(seed), []
    for label in labels:
        people: list[dict[str, Any]] = []
        for k, tag in enumerate(label.tags):
            points = {m.part: [m.x, m.y] for m in label.marks if m.tag == tag}
            one = {"position_mm": label.positions_mm[k].tolist(), "points": points}
            people += [one] * (2 if rng.random() < 0.05 else 1)
        images.append({"filename": label.filename, "width": label.width, "height": label.height, "people": people})
    path = folder / "p.json"
    path.write_text(json.dumps({"images": images}))
    return read_predictions(path)


def test_stated_distances_are_scored_in_place_of_positions():
    """Positions 2 m apart, 1 m stated where the truth is 1 m: no error by what is stated, 100 % by positions."""
    truth = np.array([[0.0, 0, 0], [1000, 0, 0], [0, 0, 5000]])
    gaps = np.linalg.norm(truth[:, None] - truth[None], axis=-1)
    given = Prediction(
        "x.jpg", None, None, np.zeros((3, 4, 2)), 2 * truth, gaps, np.full((3, 3), np.nan), np.full((3, 3), np.nan)
    )
    stated = given.by_distances()
    assert not stated.has_positions and stated.distances_mm == pytest.approx(gaps)
    unplaced = replace(given, positions_mm=np.array([[0.0, 0, 0], [np.nan] * 3, [0, 0, 5000]]))
    assert len(unplaced.by_distances()) == 2  # who has no position is no answer there
    alone = replace(given, distances_mm=None)
    assert alone.by_distances() is alone


def test_of_equally_near_points_the_first_wins(tmp_path: Path) -> None:
    """The published loop compares with <: the parts in its own order, and the annotated people in theirs."""
    body = [
        "P0,Shoulder,100,100,a.jpg,1000,800",
        "P1,Shoulder,300,100,a.jpg,1000,800",
        "P1,Torso,500,300,a.jpg,1000,800",
    ]
    (tmp_path / "body_pixel_locations.csv").write_text("\n".join(body) + "\n")
    (tmp_path / "ground_truth_locations.csv").write_text("0,C0,0,0,0\n0,P0,0,0,5000\n0,P1,3000,0,5000\n")
    (tmp_path / "camera_locations_photoshoot_identifiers.csv").write_text("0,C0,a.jpg\n")
    image = next(iter(read_labels(tmp_path)))
    person = np.zeros((len(skeleton.PARTS), 2))
    person[skeleton.PARTS.index("Shoulder")] = 200, 100
    assert _nearest(person, image) == ("P0", 100.0)
    person[skeleton.PARTS.index("Torso")] = 500, 400
    assert _nearest(person, image) == ("P0", 100.0)
    person[skeleton.PARTS.index("Torso")] = 500, 399
    assert _nearest(person, image) == ("P1", 99.0)
