"""The benchmark of rendered people: who is whom, and that exact joints come back to where they are."""

import numpy as np
import pytest

from benchmarks.networks.known_people import Tally, count, joined, owners, true_people, true_pixels
from proxemetry.camera import Camera
from proxemetry.people.skeleton import COCO_17
from synthetic.rendered_photos import RenderedPhoto
from synthetic.scenes import Recipe, scenes


@pytest.fixture(scope="module")
def photo():
    made = next(p for p in scenes(20, 3, Recipe()) if len(p.joints_m["neck"]) >= 3 and not p.seated.any())
    joints = np.stack([made.joints_m[joint] for joint in COCO_17.joints], axis=1)
    camera = Camera.centred(made.camera.f_px, made.camera.width, made.camera.height)
    down, right = -made.up, np.cross(-made.up, (0, 0, 1))
    right /= np.linalg.norm(right)
    to_camera = np.column_stack([right, down, np.cross(right, down)])
    shown = np.full(len(joints), 9999)
    return RenderedPhoto(
        0, np.zeros((1, 1, 3), np.uint8), camera, made.pitch_rad, made.height_m, to_camera, joints, shown
    )


def test_everyone_is_who_they_are_and_stands_where_they_stand(photo):
    pixels, statures_px = true_pixels(photo)
    people = true_people(pixels, statures_px, np.random.default_rng(0))
    whom = owners(people[::-1], pixels, statures_px)
    assert (whom == np.arange(len(people))[::-1]).all()
    tally = Tally()
    count(tally, photo, people[::-1], whom)
    assert tally.others == 0
    assert tally.found == tally.seeable > 0
    true, found, sd = np.array(tally.depths).T
    assert np.abs(found - true) == pytest.approx(0, abs=4 * sd.max())
    assert len(tally.pairs) == len(true) * (len(true) - 1) / 2
    assert "others" in joined([tally, Tally()]).line()
    size, down = tally.joint_line().split("hip ")[1].split()[:2]
    assert 0.3 < float(size) < 0.9 and abs(float(down)) < 0.5  # 0.5 % of the stature along either axis


def test_others_are_nobody(photo):
    pixels, statures_px = true_pixels(photo)
    people = true_people(pixels + 3 * statures_px.max(), statures_px, np.random.default_rng(0))
    assert (owners(people, pixels, statures_px) == -1).all()
