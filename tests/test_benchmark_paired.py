"""Two methods on the same photos: the difference of their errors, photo by photo."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path

import pytest

from proxemetry.benchmark import Score, difference, read_labels, read_predictions, score
from proxemetry.benchmark.report import comparison
from proxemetry.cli import main
from proxemetry.errors import SettingsError

#: So many photos of two people 1, 2, 3 ... metres apart.
N = 12


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Photo k shows people k and k + 1 metres along."""
    photos = [f"{k}.jpg" for k in range(N)]
    body = [f"P{k + i},Shoulder,{200 + 300 * i},100,{n},1000,800" for k, n in enumerate(photos) for i in (0, 1)]
    (tmp_path / "body_pixel_locations.csv").write_text("\n".join(body) + "\n")
    places = ["0,C0,0,0,0", *(f"0,P{k},{1000 * k},0,5000" for k in range(N + 1))]
    (tmp_path / "ground_truth_locations.csv").write_text("\n".join(places) + "\n")
    (tmp_path / "camera_locations_photoshoot_identifiers.csv").write_text("".join(f"0,C0,{n}\n" for n in photos))
    return tmp_path


def answered(folder: Path, errors_pct: Sequence[float | None], protocol: str = "v1", name: str = "m") -> Score:
    """Score a method that is so many per cent too long in each photo, or does not answer."""
    path = folder / f"{name}.json"
    images = [
        {"filename": f"{k}.jpg", "distances_mm": [[0, 1, 1000 * (1 + e / 100)]],
         "people": [{"points": {"Shoulder": [200 + 300 * i, 100]}} for i in (0, 1)]}
        for k, e in enumerate(errors_pct) if e is not None
    ]  # fmt: skip
    path.write_text(json.dumps({"images": images}))
    return score(read_labels(folder), read_predictions(path), protocol)


def test_a_method_that_is_always_a_little_better_is_surely_so_however_the_photos_differ(folder: Path) -> None:
    hard = [5.0 * k for k in range(N)]
    worse, better = answered(folder, [e + 3 for e in hard]), answered(folder, hard)
    apart = difference(worse, better)
    assert apart.n_images == N
    assert apart.pair_error_pct_mean_over_images == pytest.approx(3)
    assert apart.ci95 == pytest.approx((3, 3))
    assert worse.overall.ci95["pair_error_pct_mean_over_images"][0] < better.overall.pair_error_pct_mean_over_images
    back = difference(better, worse)
    assert back.pair_error_pct_mean_over_images == pytest.approx(-3)
    same = difference(worse, worse)
    assert (same.pair_error_pct_mean_over_images, same.ci95) == (0, (0, 0))


def test_the_interval_is_that_of_a_mean(folder: Path) -> None:
    ups_and_downs = [10.0 if k % 2 else 0.0 for k in range(N)]
    apart = difference(answered(folder, ups_and_downs), answered(folder, [0.0] * N))
    half = 1.96 * 5 / math.sqrt(N)
    assert apart.pair_error_pct_mean_over_images == pytest.approx(5)
    assert apart.ci95 == pytest.approx((5 - half, 5 + half), abs=0.6)


@pytest.mark.parametrize("protocol", ["v1", "seker2021"])
def test_photos_that_one_does_not_score_count_for_neither(folder: Path, protocol: str) -> None:
    some = answered(folder, [50.0] * 3 + [None] * (N - 3), protocol)
    whole = answered(folder, [20.0] * N, protocol)
    apart = difference(some, whole)
    assert apart.n_images == 3
    assert apart.pair_error_pct_mean_over_images == pytest.approx(30)
    back = difference(whole, some)
    assert (back.n_images, back.pair_error_pct_mean_over_images) == (3, pytest.approx(-30))
    nothing = difference(answered(folder, [None] * N, protocol), whole)
    assert nothing.n_images == 0
    assert nothing.to_dict() == {"n_images": 0, "pair_error_pct_mean_over_images": None, "ci95": [None, None]}


def test_scores_of_two_protocols_or_of_other_photos_are_not_compared(folder: Path) -> None:
    one = answered(folder, [0.0] * N)
    with pytest.raises(SettingsError, match="one protocol and on the same labels"):
        difference(one, answered(folder, [0.0] * N, "seker2021"))


def test_the_comparison_says_against_whom(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hard = [5.0 * k for k in range(N)]
    scores = {"mine": answered(folder, hard, name="mine"), "old": answered(folder, [e + 3 for e in hard], name="old")}
    lines = comparison(scores, 200).splitlines()
    assert lines[1].split()[-3:] == ["against", "mine", "%"]
    assert lines[2].split()[-1] == "-"
    assert lines[3].endswith("+3.0 [+3.0, +3.0]")
    assert max(map(len, comparison(scores).splitlines())) <= 100
    assert "against" not in comparison({"mine": scores["mine"]})
    files = [f"{name}={folder / f'{name}.json'}" for name in scores]
    assert main(["score", *files, "--labels", str(folder)]) == 0
    assert capsys.readouterr().out.endswith(comparison(scores))


@pytest.mark.parametrize("option", [["--json", "x.json"], ["--csv", "x.csv"], ["--plot", "x.png"]])
@pytest.mark.parametrize("command", ["score", "benchmark"])
def test_what_is_for_one_score_is_refused_for_two_before_anything_is_done(
    folder: Path, capsys: pytest.CaptureFixture[str], command: str, option: list[str]
) -> None:
    what = ["a.json", "b.json"] if command == "score" else ["--keypoints", "labels", "--method", "scene,torso"]
    assert main([command, *what, "--labels", str(folder), *option]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert "are for one prediction or method" in err
