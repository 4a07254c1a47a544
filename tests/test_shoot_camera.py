"""What the people of a shoot say about its one camera: when it is believed, and of which photos."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from proxemetry.calibration.people import whole
from proxemetry.calibration.shoot import WIDEST_RATIO, ShootFit
from proxemetry.camera import Camera, CameraEstimate, Doubt, FocalSource, Mount, of_shoot
from proxemetry.camera.from_people.self_calibration import FocalPosterior
from proxemetry.camera.others import SameShoot, shoot_from_dict, shoot_to_dict
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from synthetic.modelled import photo

PHOTO = Photo("a.jpg", 1920, 1080, "")
SHOOT = SameShoot(7.0, 0.05, 12, 30)
NOBODY = People.none(COCO_17)


@pytest.mark.parametrize(("apart", "another"), [(0.0, False), (0.37, False), (0.39, True), (3.0, True)])
@pytest.mark.parametrize("side", [1, -1])
def test_a_photo_of_another_lens_is_one_whose_own_people_are_so_much_surer(monkeypatch, apart, another, side):
    """Its own people say 0.1 as a deviation; the shoot's interval reaches 1.645 x 0.05 = 0.082 towards them.

    What is left in between costs half its square in deviations: 4.5 at three, so at 0.382 from one to the other.
    """
    log_f = np.linspace(3, 11, 8001)
    own = 7.0 + side * apart
    said = FocalPosterior(
        math.exp(own), 0.0, 0.0, 0.1, 0.2, np.zeros(0, dtype=bool), log_f, -0.5 * ((log_f - own) / 0.1) ** 2
    )
    monkeypatch.setattr(of_shoot, "focal_posterior", lambda *_: said)
    flag = of_shoot.contradiction(SHOOT, NOBODY, PHOTO)
    assert (flag is not None) == another
    if flag is not None:
        assert flag.doubt is Doubt.CONTRADICTED and f"{math.exp(own):.0f} px" in flag.text
        assert "those of the other photos 1097 px" in flag.text
    far = replace(said, log_f=log_f[:10], log_likelihood=np.zeros(10))  # nothing of it lies within reach
    monkeypatch.setattr(of_shoot, "focal_posterior", lambda *_: far)
    assert of_shoot.contradiction(SHOOT, NOBODY, PHOTO) is not None
    monkeypatch.setattr(of_shoot, "focal_posterior", lambda *_: "too few")
    assert of_shoot.contradiction(SHOOT, NOBODY, PHOTO) is None


def test_a_shoots_focal_length_is_each_photos_and_its_place_only_where_it_stayed():
    moved = of_shoot.of_shoot(CameraEstimate(None), SHOOT, PHOTO)
    assert moved.camera is not None and moved.mount is None
    assert moved.camera.f_px == pytest.approx(math.exp(7.0)) and moved.camera.focal_rel_sd == 0.05
    assert moved.source is not None and moved.source.kind is FocalSource.PEOPLE_OF_PHOTOS
    assert moved.testimony[-1].counted and any(flag.doubt is Doubt.ESTIMATED for flag in moved.flags)
    lens = Camera(1100.0, 1100.0, 950.0, 545.0, 1920, 1080, focal_rel_sd=0.03)
    stood = replace(SHOOT, mount=Mount.stated(0.2, 0.0, 3.0, camera=lens))
    there = of_shoot.of_shoot(CameraEstimate(None), stood, PHOTO)
    assert there.camera is not None and there.mount is not None
    assert (there.camera.f_px, there.camera.cx, there.mount.height_m) == (1100.0, 950.0, 3.0)
    taped = of_shoot.of_shoot(CameraEstimate(None, mount=Mount.stated(height_m=2.0)), stood, PHOTO)
    assert taped.mount is not None and taped.mount.height_m == 2.0
    back = shoot_from_dict(json.loads(json.dumps(shoot_to_dict(stood))))
    assert stood.without_place == back.without_place == SHOOT
    assert back.mount is not None and back.mount.camera == lens
    assert (back.mount.pitch_rad, back.mount.height_m) == pytest.approx((0.2, 3.0))


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, None), ({"log_sd": 0.187}, None), ({"log_sd": 0.189}, "too wide"),
        ({"largest_share": 0.49}, None), ({"largest_share": 0.51}, "a single photo"),
        ({"pitch_rad": math.radians(5.1)}, None), ({"pitch_rad": math.radians(4.9)}, "too level"),
    ],
)  # fmt: skip
def test_a_shoot_is_believed_within_the_interval_of_a_photo(changes, said):
    """High over low up to 1.3 / 0.7: 2 x 1.645 deviations of ln 1.857 are 0.188."""
    assert pytest.approx(1.3 / 0.7) == WIDEST_RATIO
    doubt = replace(ShootFit(7.0, 0.1, 12, 30), **changes).doubt
    assert (doubt is None) if said is None else (doubt is not None and said in doubt)


def test_people_count_who_are_seen_whole_and_straight_and_large():
    people, _ = photo(0, noise_px=0.0)
    assert whole(people).all()
    columns = COCO_17.joints.index
    cut = people.scores.copy()
    cut[0, [columns("left_ankle"), columns("right_ankle")]] = 0
    cut[1, columns("left_ankle")] = 0  # one of a pair is enough
    assert whole(replace(people, scores=cut)).tolist() == [False, True, True, True]
    bent = people.keypoints_px.copy()
    for side in ("left", "right"):
        bent[2, columns(f"{side}_hip")] += (0.5 * (people.boxes_px[2, 3] - people.boxes_px[2, 1]), 0)
    assert whole(replace(people, keypoints_px=bent)).tolist() == [True, True, False, True]
    assert not whole(people.scaled(0.02, 0.02)).any()
