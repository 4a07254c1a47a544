"""Boxes without keypoints: read from MOT's text or our own file, and measured through the fit with wider intervals."""

import json
import math

import numpy as np
import pytest

from proxemetry.camera import Camera, CameraEstimate, Mount
from proxemetry.errors import KeypointsError
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.skeleton import BOX
from proxemetry.pose.recorded import Recorded
from proxemetry.settings import Settings
from synthetic.modelled import CAMERA, photo


def boxed(people):
    """Return people of whom nothing is left but boxes about their keypoints, heads and soles included."""
    nose, ankles = people.joint("nose"), (people.joint("left_ankle") + people.joint("right_ankle")) / 2
    tall = ankles[:, 1] - nose[:, 1]
    top = np.column_stack([nose[:, 0], nose[:, 1] - 0.085 * tall])
    bottom = np.column_stack([ankles[:, 0], ankles[:, 1] + 0.055 * tall])
    half = np.column_stack([0.15 * tall, 0 * tall])
    return People(
        BOX, np.stack([top, bottom], axis=1), np.ones((len(people), 2)), np.hstack([top - half, bottom + half])
    )


def measured(people, mount):
    return place("", "", CAMERA.width, CAMERA.height, people, CameraEstimate(CAMERA), Settings(), mount)


def test_boxes_measure_with_wider_intervals():
    mount = Mount.stated(0.2, 0.0, 3.5, pitch_sd_rad=0.003, roll_sd_rad=0.003, height_sd_m=0.03)
    down = np.array([0.0, math.cos(0.2), math.sin(0.2)])
    errors, holds, wider = [], [], []
    for seed in range(8):
        people, middles = photo(seed, count=4, pitch=0.2, height_m=3.5, depths_m=(7, 16))
        floor = middles - (middles @ down)[:, None] * down
        truth = np.linalg.norm(floor[:, None] - floor[None], axis=-1)
        whole, alone = measured(people, mount).distances, measured(boxed(people), mount).distances
        a, b = np.triu_indices(4, 1)
        errors += list(np.abs(alone.distance_m[a, b] / truth[a, b] - 1))
        holds += list((alone.low_m[a, b] <= truth[a, b]) & (truth[a, b] <= alone.high_m[a, b]))
        wider.append(np.mean((alone.high_m - alone.low_m)[a, b]) / np.mean((whole.high_m - whole.low_m)[a, b]))
    assert np.mean(errors) < 0.12
    assert np.mean(holds) > 0.8
    assert np.median(wider) > 1.2


def test_mot_text_is_read(tmp_path):
    (tmp_path / "seqinfo.ini").write_text("[Sequence]\nimWidth=1920\nimHeight=1080\n")
    path = tmp_path / "det.txt"
    path.write_text("1,-1,100,200,50,150,0.9,-1,-1,-1\n1,-1,400,210,52,160,0.8\n3,7,10.5,20,30,90,1,-1,-1,-1\n")
    recorded = Recorded(path)
    assert recorded.photos == ("000001", "000003")
    people = recorded.detect(recorded.photo("000001"))
    assert people.skeleton == BOX
    assert people.boxes_px[0].tolist() == [100, 200, 150, 350]
    assert people.keypoints_px[0].tolist() == [[125, 200], [125, 350]]
    assert people.person_scores[0] == pytest.approx(0.9)


def test_our_own_file_of_boxes(tmp_path):
    path = tmp_path / "boxes.json"
    entry = {"filename": "a.jpg", "width": 640, "height": 480, "people": [{"box": [10, 20, 60, 200], "score": 0.7}]}
    path.write_text(json.dumps({"skeleton": "box", "images": [entry]}))
    recorded = Recorded(path)
    assert len(recorded.detect(recorded.photo("a.jpg"))) == 1


@pytest.mark.parametrize("line", ["1,2,10,20,-5,90,1", "1.5,2,10,20,5,90,1"])
def test_a_wrong_line_is_named(tmp_path, line):
    path = tmp_path / "det.txt"
    path.write_text("1,-1,100,200,50,150,0.9\n" + line + "\n")
    with pytest.raises(KeypointsError, match="line 2"):
        Recorded(path)


def test_a_box_on_its_own_says_how_little_it_tells():
    people = People(BOX, np.array([[(480.0, 300.0), (480.0, 700.0)]]), np.ones((1, 2)))
    scene = place("", "", 1920, 1080, people, CameraEstimate(Camera.centred(1200, 1920, 1080)), Settings())
    assert scene.bodies.placed.all()
    assert scene.bodies.position_sd_m[0, 2] > 0.15
