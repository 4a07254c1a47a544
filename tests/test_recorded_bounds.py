"""Numbers and names in keypoint files that nothing can be: one line, or missing, never a distance of a thousand km."""

import json
import os
from pathlib import Path
from typing import Any

import pytest

from proxemetry.archive.store.results import Results
from proxemetry.camera import Camera
from proxemetry.cli import main
from proxemetry.errors import CameraError, KeypointsError
from proxemetry.pose.recorded import Recorded

_PERSON = {"keypoints": [[300 + 9 * (k % 4), 100 + 12 * k, 0.9] for k in range(17)]}


def _content(**changes: Any) -> dict[str, Any]:
    camera = {"fx": 700, "fy": 700, "cx": 320, "cy": 240}
    image = {
        "filename": "a.jpg",
        "width": 640,
        "height": 480,
        "camera": camera,
        "people": [_PERSON, _PERSON],
        **changes,
    }
    return {"skeleton": "coco17", "images": [image, {**image, "filename": "b.jpg"}]}


@pytest.mark.parametrize(
    "changes",
    [
        {"camera": {"fx": 1e300}}, {"camera": {"fx": 1e-300}}, {"camera": {"fx": 700, "cx": 1e200}},
        {"camera": {"fx": 700, "k1": 1e300}}, {"camera": {"fx": 10**400}}, {"camera": {"fx": float("inf")}},
        {"width": 3e9}, {"width": float("inf")}, {"width": 10**400}, {"height": 0}, {"filename": "a\x00.jpg"},
        {"people": [{"keypoints": [[10**400, 1, "x"]]}]}, {"filename": "x" * 5, "people": 3},
    ],
    ids=str,
)  # fmt: skip
def test_what_nothing_can_be_is_one_line(
    changes: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "k.json"
    path.write_text(json.dumps(_content(**changes)))
    with pytest.raises((KeypointsError, CameraError)) as refused:
        Recorded(path)
    assert len(str(refused.value)) < 500
    assert main(["measure", "--pose", f"recorded:{path}", "--out", str(tmp_path / "r")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    "text", ['{"images": ' + "[" * 100_000, '{"skeleton": "coco17", "images": [{"filename": "\\ud800.jpg"}]}']
)
def test_texts_that_nobody_means_are_one_line(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "k.json").write_text(text)
    assert main(["measure", "--pose", f"recorded:{tmp_path / 'k.json'}", "--out", str(tmp_path / "r")]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_mmpose_instances_that_are_no_list_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "results_a.json").write_text('{"instance_info": [{"instances": 3.5}], "meta_info": {}}')
    with pytest.raises(KeypointsError, match="must be a list"):
        Recorded(tmp_path / "results_a.json")


def test_joints_far_outside_are_missing_and_the_others_count(tmp_path: Path) -> None:
    person = {"keypoints": [[1e12, 5, 0.9], [float("inf"), 5, 0.9], *_PERSON["keypoints"][2:]], "box": [0, 0, 1e300, 9]}
    (tmp_path / "k.json").write_text(json.dumps(_content(people=[person, _PERSON])))
    arguments = ["measure", "--pose", f"recorded:{tmp_path / 'k.json'}", "--out", str(tmp_path / "r"), "--jobs", "0"]
    assert main(arguments) == 0
    scene = next(iter(Results.open(tmp_path / "r").scenes()))
    assert (scene.people.scores[0, :2] == 0).all()
    assert scene.bodies.placed.all()


@pytest.mark.skipif(os.name != "posix", reason="bytes as names")
def test_openpose_files_of_bytes_have_readable_names(tmp_path: Path) -> None:
    folder = tmp_path / "k"
    folder.mkdir()
    content = json.dumps({"people": [{"pose_keypoints_2d": [300.0, 100.0, 0.9] * 25}]}).encode()
    try:
        Path(os.fsdecode(os.fsencode(folder) + b"/gr\xfc_keypoints.json")).write_bytes(content)
    except OSError:
        pytest.skip("this disk takes no such names")
    assert Recorded(folder).photos == (r"gr\xfc",)


def test_a_camera_s_bounds_are_those_of_lenses() -> None:
    Camera.centred(160_000, 640, 480)  # ten metres, on a tenth of a full frame
    Camera.centred(90, 640, 480)
    for f_px in (6.0, 6.5e6):
        with pytest.raises(CameraError, match="no lens has"):
            Camera.centred(f_px, 640, 480)
