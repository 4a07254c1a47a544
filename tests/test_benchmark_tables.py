"""Tables, score files, drawings, and methods run on annotated points."""

from __future__ import annotations

import csv
import io
import json
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from proxemetry.benchmark import (
    Labels,
    Prediction,
    Predictions,
    Score,
    read_labels,
    read_predictions,
    score,
    score_files,
    write_predictions,
)
from proxemetry.benchmark.figures import plot_score, plot_table
from proxemetry.benchmark.metrics import error_by_distance, f1, zone_confusion
from proxemetry.benchmark.report import comparison, to_text
from proxemetry.benchmark.scenes import prediction_of
from proxemetry.benchmark.tables import TABLES, make_table, published_figures
from proxemetry.bodies import Bodies
from proxemetry.camera import Camera
from proxemetry.cli import main
from proxemetry.errors import LabelsError, SettingsError
from proxemetry.evaluate import camera_of_labels, people_of_labels, predict_labels, scenes_of_labels
from proxemetry.locate import LocateSettings
from proxemetry.people import People
from proxemetry.settings import Settings

KORTE = Path(__file__).parent.parent.parent / "shared" / "data" / "korte"
needs_korte = pytest.mark.skipif(not KORTE.exists(), reason="the labels of the KORTE benchmark are not here")


@pytest.fixture(scope="module")
def perfect() -> dict[str, Score]:
    """A method that is always right, under both protocols."""
    answer = {}
    for protocol, errata in (("v1", True), ("seker2021", False)):
        labels = read_labels(KORTE, errata=errata)
        none = [np.full((len(i), len(i)), np.nan) for i in labels]
        images = tuple(
            Prediction(i.filename, i.width, i.height, i.parts_px, i.positions_mm, None, n, n)
            for i, n in zip(labels, none, strict=True)
        )
        answer[protocol] = score(labels, Predictions(images, "perfect"), protocol)
    return answer


@needs_korte
def test_tables_have_the_papers_rows_counts_and_figures(perfect: dict[str, Score]) -> None:
    table = make_table("all", {"combined": perfect["seker2021"]})
    assert [(row.name, row.n_images) for row in table.rows] == [
        ("16", 11), ("24", 12), ("35", 15), ("50", 18), ("105", 25), ("200", 7), ("300", 8), ("all", 96)
    ]  # fmt: skip
    assert [row.n_images for row in make_table("indoor", {"m": perfect["v1"]}).rows] == [4, 4, 4, 7, 14, 33]
    assert [row.n_images for row in make_table("outdoor", {"m": perfect["v1"]}).rows] == [7, 8, 11, 11, 11, 7, 8, 63]
    assert [row.n_images for row in make_table("elevated", {"m": perfect["v1"]}).rows] == [16, 23]
    last = table.rows[-1].cells["combined"]
    assert (last.published_rate, last.published_value, last.value) == (0.92, 28.88, 0)
    assert math.isnan(published_figures()["all", "300", "torso"][1])
    counted = [
        n for (name, row, _), n in zip(published_figures(), csv_counts(), strict=True) if (name, row) == ("all", "all")
    ]
    assert counted == [96] * 4


def csv_counts() -> list[int]:
    from importlib.resources import files

    text = (files("proxemetry.benchmark") / "published.csv").read_text()
    return [int(row["n_images"]) for row in csv.DictReader(text.splitlines())]


@needs_korte
def test_published_tables_agree_with_one_another() -> None:
    """The paper's means over all photos are those over outdoor and indoor ones, weighted by their numbers.

    Its torso and shoulder columns do not all obey (photos without an estimate were left out in some); detection
    rates and the combined method do, to rounding.
    """
    figures = published_figures()
    for k, methods in ((0, ("shoulder", "pupil", "torso", "combined")), (1, ("combined",))):
        for method in methods:
            both = 63 * figures["outdoor", "all", method][k] + 33 * figures["indoor", "all", method][k]
            assert both / 96 == pytest.approx(figures["all", "all", method][k], abs=0.011), method


@needs_korte
@pytest.mark.parametrize("name", list(TABLES))
def test_every_table_in_every_form(perfect: dict[str, Score], name: str) -> None:
    scores = {"combined": perfect["v1"], "other_one": perfect["v1"]}
    table = make_table(name, scores)
    assert table.to_text().startswith(TABLES[name])
    assert "protocol v1" in table.to_text()
    rows = list(csv.reader(io.StringIO(table.to_csv())))
    assert len(rows) == len(table.rows) + 1
    assert len({len(row) for row in rows}) == 1
    latex = table.to_latex()
    assert latex.count(r"\\") == len(rows)
    assert r"other\_one" in latex
    assert "with errata" in latex
    pytest.importorskip("matplotlib")
    assert len(plot_table(table).axes) == 1


@needs_korte
@pytest.mark.parametrize("width", [60, 80, 100])
@pytest.mark.parametrize("protocol", ["v1", "seker2021"])
def test_text_fits_the_terminal_and_a_method_without_an_answer_has_no_error(
    perfect: dict[str, Score], protocol: str, width: int
) -> None:
    labels = read_labels(KORTE, errata=protocol == "v1")
    nothing = score(labels, Predictions({}, "nothing"), protocol)
    for name in TABLES:
        table = make_table(name, {"perfect": perfect[protocol], "shoulder": nothing, "pupil": nothing})
        lines = table.to_text(width).splitlines()
        assert max(map(len, lines)) <= width
        assert lines[-1] == "no answer (-): shoulder, pupil placed no pair of people"
        assert all(math.isnan(row.cells["shoulder"].value) for row in table.rows)
    both = {"perfect": perfect[protocol], "shoulder": nothing}
    lines = comparison(both, width).splitlines()
    assert max(map(len, lines)) <= width
    row = next(line for line in lines if line.startswith("shoulder"))
    assert row.split()[1:4] == ["0", "96", "-"]
    assert "no answer" in to_text(nothing) and "mean over photos" not in to_text(nothing)


def test_tables_refuse_what_they_cannot_show(perfect: dict[str, Score]) -> None:
    with pytest.raises(SettingsError, match="use one of all, outdoor"):
        make_table("some", {"m": perfect["v1"]})
    with pytest.raises(SettingsError, match="one protocol"):
        make_table("all", {"a": perfect["v1"], "b": perfect["seker2021"]})
    with pytest.raises(SettingsError, match="one protocol"):
        make_table("all", {})


@needs_korte
def test_score_file_has_the_fields_promised(perfect: dict[str, Score]) -> None:
    for protocol, result in perfect.items():
        content = json.loads(result.to_json())
        assert content["protocol"] == protocol
        assert set(content["images"][0]) == {
            "filename", "n_annotated", "n_detected", "n_matched", "n_pairs", "pair_error_pct", "detection_rate",
            "false_discovery_rate", "mean_distance_mm",
        }  # fmt: skip
        assert {
            "n_images", "n_unscored", "pair_error_pct_mean_over_images", "pair_error_pct_median_over_pairs",
            "detection_rate", "false_discovery_rate", "signed_bias_pct", "baseline_constant_pct", "coverage_90", "f1",
        } <= set(content["overall"])  # fmt: skip
        assert set(content["overall"]["f1"]) == {"1.0", "1.5", "2.0", "3.0"}
        assert {g["by"] for g in content["groups"]} == {"focal_mm", "setting", "camera"}
        assert content["overall"]["n_unscored"] == 2
        unscored = [i for i in content["images"] if i["n_pairs"] == 0]
        assert [i["pair_error_pct"] for i in unscored] == ([None, None] if protocol == "v1" else [0, 0])
        assert len(list(csv.DictReader(io.StringIO(result.to_csv())))) == 96
        text = to_text(result)
        assert f"protocol {protocol}" in text.splitlines()[0]
        assert "answering 1.70 m for every pair" in text
        assert "1.70 m for all" in comparison({"perfect": result})


@needs_korte
def test_scores_are_drawn(perfect: dict[str, Score], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    figure = plot_score(perfect["v1"])
    figure.savefig(tmp_path / "score.svg")
    assert len(figure.axes) == 2


@needs_korte
def test_a_drawing_says_what_it_cuts_off_and_the_constant_answer_errs_as_it_does() -> None:
    pytest.importorskip("matplotlib")
    labels = read_labels(KORTE)
    result = score(labels, Predictions(predict_labels(labels, Settings(method="torso")), "torso"))
    left, right = plot_score(result).axes
    errors = np.concatenate([abs(i.estimated_mm - i.true_mm) / i.true_mm for i in result.images])
    assert [t.get_text() for t in right.texts] == [f"{(errors > 1).sum()} above"]
    estimated = np.concatenate([i.estimated_mm for i in result.images]) / 1000
    assert [t.get_text() for t in left.texts] == [f"{(estimated > left.get_ylim()[1]).sum()} above"]
    (line,) = (line for line in right.lines if line.get_label() == "1.70 m for every pair")
    x, y = line.get_data()
    assert np.interp(3.4, x, y) == pytest.approx(50, abs=0.1)  # half of what it is
    assert np.interp(1.7, x, y) == pytest.approx(0, abs=1)


@needs_korte
def test_command_line_writes_what_it_is_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    out = tmp_path / "run"
    common = ["benchmark", "--labels", str(KORTE), "--keypoints", "labels"]
    assert main([*common, "--method", "torso", "--out", str(out), "--json", str(tmp_path / "a.json")]) == 0
    assert "protocol v1" in capsys.readouterr().out
    kept = score_files(out / "predictions_torso_v1.json", KORTE)
    assert json.loads((tmp_path / "a.json").read_text())["overall"] == kept.to_dict()["overall"]
    assert json.loads((out / "score_torso_v1.json").read_text())["images"] == kept.to_dict()["images"]
    named = [f"torso={out / 'predictions_torso_v1.json'}", f"again={out / 'predictions_torso_v1.json'}"]
    plot = tmp_path / "t.png"
    args = ["score", *named, "--labels", str(KORTE), "--table", "indoor", "--format", "csv", "--plot", str(plot)]
    assert main(args) == 0
    assert capsys.readouterr().out.startswith("mm,photos,torso rate,torso %,torso published rate")
    assert plot.stat().st_size > 1000
    assert main([*common, "--method", "torso,combined", "--protocol", "seker2021"]) == 0
    assert "combined" in capsys.readouterr().out
    assert main(["benchmark", "--how"]) == 0
    assert "10.23729/b2ea87e6" in capsys.readouterr().out
    for wrong in (["--method", "magic"], ["--images", "x"]):
        assert main([*common, *wrong]) == 2
    assert main(["benchmark", "--images", "x", "--labels", str(KORTE)]) == 2
    assert "--out DIR" in capsys.readouterr().err


@needs_korte
def test_metres_for_millimetres_do_not_pass_in_silence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["benchmark", "--labels", str(KORTE), "--keypoints", "labels", "--method", "torso", "--out", str(tmp_path)])
    answers = json.loads((tmp_path / "predictions_torso_v1.json").read_text())
    for image in answers["images"]:
        image.pop("distances_mm", None)
        for person in image["people"]:
            person["position_mm"] = [v / 1000 for v in person["position_mm"]] if person["position_mm"] else None
    (tmp_path / "metres.json").write_text(json.dumps(answers))
    capsys.readouterr()
    assert main(["score", str(tmp_path / "metres.json"), "--labels", str(KORTE)]) == 0
    assert "millimetres" in capsys.readouterr().err
    assert main(["score", str(tmp_path / "predictions_torso_v1.json"), "--labels", str(KORTE)]) == 0
    assert capsys.readouterr().err == ""
    assert main(["score", str(tmp_path / "metres.json"), "--labels", str(KORTE), "--format", "csv"]) == 2


@needs_korte
def test_annotated_points_as_keypoints() -> None:
    labels = read_labels(KORTE)
    image = labels.by_name["IMG_6285.jpg"]
    people, estimate = people_of_labels(image), camera_of_labels(image)
    assert len(people) == len(image)
    np.testing.assert_allclose(people.part("Torso"), image.parts_px[:, 2])
    assert estimate.camera is not None
    assert estimate.camera.f_px == pytest.approx(image.focal_mm * image.width / 36)


@needs_korte
@pytest.mark.parametrize(("protocol", "over_pairs", "over_all"), [("seker2021", 38.4, 35.6)])
def test_naive_torso_on_annotated_points_is_as_known(protocol: str, over_pairs: float, over_all: float) -> None:
    labels = read_labels(KORTE, errata=False)
    settings = Settings(method="torso", locate=LocateSettings(body_size="adults"))
    result = score(labels, Predictions(predict_labels(labels, settings), "torso"), protocol)
    errors = [image.pair_error_pct for image in result.images if image.n_pairs]
    assert np.mean(errors) == pytest.approx(over_pairs, abs=0.3)
    assert result.overall.pair_error_pct_mean_over_images == pytest.approx(over_all, abs=0.3)


@needs_korte
@pytest.mark.parametrize("method", ["shoulder", "pupil"])
def test_what_is_not_annotated_places_nobody(method: str) -> None:
    labels = read_labels(KORTE)
    for scene in scenes_of_labels(labels, Settings(method=method)):
        assert not scene.bodies.placed.any()
        assert all(scene.bodies.reasons)


def test_without_a_focal_length_nobody_is_placed(tmp_path: Path) -> None:
    (tmp_path / "body_pixel_locations.csv").write_text(
        "P0,Shoulder,100,110,a.jpg,1000,800\nP0,Torso,100,150,a.jpg,1000,800\n"
    )
    (tmp_path / "ground_truth_locations.csv").write_text("0,C0,0,0,0\n0,P0,0,0,5000\n")
    (tmp_path / "camera_locations_photoshoot_identifiers.csv").write_text("0,C0,a.jpg\n")
    (scene,) = scenes_of_labels(read_labels(tmp_path), Settings(method="torso"))
    assert scene.status == "no_camera"
    assert "focal_lengths.csv" in str(scene.reason)


def fake_locate(people: People, camera: Camera, settings: LocateSettings, mount: object = None) -> Bodies:
    """Put everyone in a row 1 m apart, 5 m away, gravity known."""
    positions = np.array([(float(k), 0.2, 5.0) for k in range(len(people))]).reshape(-1, 3)
    count = len(people)
    return Bodies(
        positions, np.eye(3 * count) * 0.01, "fake", ("row",) * count, (None,) * count, up=np.array([0, -1.0, 0])
    )


@needs_korte
def test_any_method_takes_the_same_road(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(sys.modules["proxemetry.measure"], "method_named", lambda name: fake_locate)
    labels = read_labels(KORTE)
    answers = predict_labels(labels, Settings(method="torso"))
    path = tmp_path / "answers.json"
    write_predictions(path, answers)
    again = read_predictions(path)
    for given, read in zip(answers, again, strict=True):
        np.testing.assert_allclose(given.points_px, read.points_px)
        np.testing.assert_allclose(given.positions_mm, read.positions_mm)
        np.testing.assert_allclose(given.low_mm, read.low_mm)
        assert read.up is not None
    result = score(labels, again)
    assert result.overall.n_pairs == result.overall.n_annotated_pairs
    assert result.overall.n_intervals == result.overall.n_pairs


@needs_korte
def test_results_folder_of_a_run_scores_like_its_predictions(tmp_path: Path) -> None:
    """The tables of `measure` in metres, and the prediction file in millimetres, are the same answer."""
    from proxemetry.tables import TABLES as COLUMNS
    from proxemetry.tables import rows

    labels = Labels(read_labels(KORTE).images[::5], "some")
    scenes = list(scenes_of_labels(labels, Settings(method="scene", locate=LocateSettings(body_size="adults"))))
    for table, columns in COLUMNS.items():
        with (tmp_path / f"{table}.csv").open("w", newline="") as file:
            writer = csv.DictWriter(file, [c.name for c in columns], extrasaction="ignore")
            writer.writeheader()
            for scene in scenes:
                writer.writerows(
                    {k: str(v).lower() if isinstance(v, bool) else v for k, v in row.items()}
                    for row in rows(table, scene)
                )
    from_tables = score(labels, read_predictions(tmp_path)).overall
    direct = score(labels, Predictions(tuple(prediction_of(scene) for scene in scenes), "")).overall
    for name, value in direct.to_dict().items():
        if isinstance(value, float):
            assert getattr(from_tables, name, value) == pytest.approx(value, rel=1e-4), name
    (tmp_path / "pairs.csv").unlink()
    with pytest.raises(LabelsError, match=r"pairs\.csv: no such file"):
        read_predictions(tmp_path)


def test_metrics_are_plain_arithmetic() -> None:
    true, estimated = np.array([400.0, 1000, 2000, 5000]), np.array([500.0, 1100, 1000, 5000])
    assert zone_confusion(estimated, true) == ((0, 1, 0, 0), (0, 1, 0, 0), (0, 1, 0, 0), (0, 0, 0, 1))
    bins = [b for b in error_by_distance(estimated, true, (0, 1000, 3000, math.inf)) if b.n_pairs]
    assert [b.n_pairs for b in bins] == [1, 2, 1]
    assert bins[1].error_pct_mean == pytest.approx(30)
    assert bins[1].bias_pct == pytest.approx(-20)
    yes, no = np.array([True, True, False, False]), np.array([True, False, True, False])
    assert f1(yes, no) == 0.5  # one hit, one false alarm, one miss
    assert math.isnan(f1(~yes & yes, no & ~no))
