"""Circles on the floor and the floor laid flat: closed forms, colours by probabilities, files."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proxemetry.bodies import Bodies, Floor, Intrinsics
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.cli import main
from proxemetry.distances import measure_distances, probability_within
from proxemetry.errors import SettingsError
from proxemetry.locate import LocateSettings
from proxemetry.locate.scenefit import locate
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.plots.floor import Level, laid_flat
from proxemetry.plots.geometry import ground_positions
from proxemetry.scene import Scene
from synthetic.scenes import Recipe, scenes
from synthetic.small_photos import write_photos

CAMERA = Camera.centred(1000.0, 1600, 1200)
PITCH, HEIGHT = math.radians(30), 5.0
UP = np.array([0.0, -math.cos(PITCH), -math.sin(PITCH)])


def _bodies(places, sd_m=0.05, **more):
    """People whose middles are 1.3 m above a floor 5 m below a camera that looks 30 degrees down."""
    ahead = np.array([0.0, -math.sin(PITCH), math.cos(PITCH)])
    positions = np.array([x * np.array([1.0, 0, 0]) + z * ahead - (HEIGHT - 1.3) * UP for x, z in places])
    count = len(places)
    return Bodies(
        positions, np.eye(3 * count) * sd_m**2, "scene", ("feet",) * count, (None,) * count, up=UP,
        floor=Floor(HEIGHT, PITCH, 0.0, 0.1, 0.01, 0.01), **more,
    )  # fmt: skip


def _scene(bodies, camera=CAMERA):
    people = People(COCO_17, np.full((len(bodies), 17, 2), 500.0), np.ones((len(bodies), 17)))
    return Scene("a.jpg", "", camera.width, camera.height, "ok", None, CameraEstimate(camera), people, bodies)


def test_places_are_seen_where_the_ground_formula_has_them():
    """METHOD: Z = H (f cos p - v sin p) / (f sin p + v cos p), X = u H / (f sin p + v cos p)."""
    level = Level.of(_scene(_bodies([(1.5, 9.0)])))
    assert level is not None and level.is_floor
    ((u, v),) = level.to_pixels(np.array([[1.5, 9.0]]), np.array([HEIGHT])) - (800, 600)
    below = 1000 * math.sin(PITCH) + v * math.cos(PITCH)
    assert HEIGHT * (1000 * math.cos(PITCH) - v * math.sin(PITCH)) / below == pytest.approx(9.0)
    assert u * HEIGHT / below == pytest.approx(1.5)


def test_circles_are_round_and_as_wide_as_asked_on_the_floor():
    level = Level.of(_scene(_bodies([(0.0, 8.0), (1.0, 12.0)])))
    outlines = level.circles_px(np.array([(0.0, 8.0), (1.0, 12.0)]), 0.75)
    rays = CAMERA.rays(outlines) @ level.axes.T
    on_floor = rays[..., :2] * (-HEIGHT / rays[..., 2])[..., None]
    off = np.linalg.norm(on_floor - np.array([(0.0, 8.0), (1.0, 12.0)])[:, None], axis=-1)
    np.testing.assert_allclose(off, 0.75, rtol=1e-9)


def test_nothing_is_seen_behind_the_lens_or_folded_back_by_its_distortion():
    level = Level.of(_scene(_bodies([(0.0, 8.0)])))
    behind = level.circles_px(np.array([(0.0, 0.0)]), 20.0)
    assert np.isnan(behind).any() and np.isfinite(behind).any()
    bent = replace(CAMERA, distortion=(-0.3, 0.0, 0.0, 0.0, 0.0))
    level = Level.of(_scene(_bodies([(0.0, 8.0)]), bent))
    assert np.isnan(level.to_pixels(np.array([[30.0, 8.0]]), np.array([HEIGHT]))).all()
    assert np.isfinite(level.to_pixels(np.array([[0.0, 8.0]]), np.array([HEIGHT]))).all()


def test_what_people_made_of_the_lens_is_what_the_floor_is_drawn_with():
    fitted = Intrinsics(0.8, (0.01, -0.02))
    plain, other = (Level.of(_scene(_bodies([(1.0, 8.0)], intrinsics=i))) for i in (Intrinsics(), fitted))
    place, height = np.array([[1.0, 8.0]]), np.array([HEIGHT])
    before, after = plain.to_pixels(place, height) - (800, 600), other.to_pixels(place, height) - (800, 600)
    np.testing.assert_allclose(after, 0.8 * before + (10, -20))


def test_a_fit_s_places_project_onto_the_torsos_that_were_seen():
    """With the focal length uncertain by a half the people move it, and their places go with theirs."""
    photo = next(scenes(1, 3, Recipe(kind="elevated", posture="standing", focal_mm=(35.0,))))
    camera = replace(photo.camera, fx=1.4 * photo.camera.fx, fy=1.4 * photo.camera.fy, focal_rel_sd=0.3)
    bodies = locate(photo.people, camera, LocateSettings())
    seen = camera.project(bodies.intrinsics.seen(bodies.positions_m))
    torso = photo.people.part("Torso")
    tall = np.ptp(photo.people.boxes_px[:, 1::2], axis=1)
    known = np.isfinite(torso).all(axis=1)
    assert known.any() and bodies.intrinsics.focal_factor < 0.9
    assert (np.linalg.norm(seen - torso, axis=1)[known] < 0.06 * tall[known]).all()
    again = Scene.from_json(_scene(bodies, camera).to_json()).bodies.intrinsics
    assert again.focal_factor == pytest.approx(bodies.intrinsics.focal_factor)


def test_without_a_floor_circles_lie_at_the_bodies():
    bodies = replace(_bodies([(0.0, 8.0), (0.5, 9.0)]), floor=None)
    level = Level.of(_scene(bodies))
    assert level is not None and not level.is_floor
    places = ground_positions(bodies)
    np.testing.assert_allclose(level.to_pixels(places, level.height_m), CAMERA.project(bodies.positions_m))
    assert Level.of(replace(_scene(bodies), camera=CameraEstimate(None))) is None


def test_the_floor_laid_flat_is_the_floor():
    """A chessboard of one-metre fields painted on the floor comes back with straight edges at whole metres."""
    level = Level.of(_scene(_bodies([(0.0, 8.0)])))
    v, u = np.mgrid[0 : CAMERA.height, 0 : CAMERA.width] + 0.5
    rays = CAMERA.rays(np.stack([u, v], axis=-1)) @ level.axes.T
    floor = rays[..., :2] * (-HEIGHT / np.where(rays[..., 2:] < 0, rays[..., 2:], np.nan))
    fields = np.floor(np.nan_to_num(floor)).sum(axis=-1) % 2
    pixels = np.repeat((255 * fields).astype(np.uint8)[..., None], 3, axis=-1)
    blank = np.full((200, 200, 3), 7, np.uint8)
    flat = laid_flat(pixels, level, (-2.0, 2.0, 7.0, 11.0), blank)
    middles = flat[25::50, 25::50, 0]  # the middles of the fields, the farthest first
    x, y = np.meshgrid(np.arange(-2, 2), np.arange(10, 6, -1))
    np.testing.assert_array_equal(middles, np.where((x + y) % 2, 255, 0))
    assert (laid_flat(pixels, level, (60.0, 64.0, 7.0, 11.0), blank) == 7).all()
    half = laid_flat(pixels[::2, ::2], level, (-2.0, 2.0, 7.0, 11.0), blank)
    np.testing.assert_array_equal(half[25::50, 25::50, 0], middles)


@pytest.mark.parametrize(("apart", "sd", "expected"), [(1.0, 0.01, 1.0), (3.0, 0.01, 0.0), (2.0, 0.05, 0.5)])
def test_two_circles_touch_as_probably_as_two_are_nearer(apart, sd, expected):
    chance = probability_within(_bodies([(0.0, 8.0), (apart, 8.0)], sd), 2.0)
    assert chance[0, 1] == chance[1, 0] == pytest.approx(expected, abs=0.03) and np.isnan(chance[0, 0])


def test_the_probability_agrees_with_the_zones():
    photo = next(p for p in scenes(9, 4) if len(p.people) >= 4)
    bodies = locate(photo.people, photo.camera, LocateSettings())
    zones = measure_distances(bodies).zone_probability
    np.testing.assert_allclose(probability_within(bodies, 1.219), zones[..., :2].sum(axis=-1), atol=1e-9)


def test_who_has_no_place_has_no_probability():
    bodies = _bodies([(0.0, 8.0), (1.0, 8.0)])
    unplaced = Bodies(
        np.vstack([bodies.positions_m, [np.nan] * 3]), np.full((9, 9), np.nan), "scene", ("a", "a", ""),
        (None, None, "hidden"), up=UP,
    )  # fmt: skip
    covariance = unplaced.covariance_m2.copy()
    covariance[:6, :6] = np.eye(6) * 0.01
    chance = probability_within(replace(unplaced, covariance_m2=covariance), 2.0)
    assert chance[0, 1] == 1.0 and np.isnan(chance[2]).all() and np.isnan(chance[:, 2]).all()


def _texts(figure):
    return [t.get_text() for axes in figure.axes for t in axes.texts]


def test_figures_colour_by_who_is_near_and_say_how_probable_it_is():
    pytest.importorskip("matplotlib")
    from matplotlib.colors import to_hex
    from matplotlib.patches import Polygon

    from proxemetry.plots import birds_eye, circles
    from proxemetry.plots.floor_figures import APART, PERHAPS, TOUCHING

    scene = _scene(_bodies([(0.0, 8.0), (1.0, 8.0), (4.0, 9.0), (6.1, 9.0)], 0.08))
    figure = circles(scene, None, within_m=2.0)
    patches = [p for p in figure.axes[0].patches if isinstance(p, Polygon)]
    assert [to_hex(p.get_facecolor()).upper() for p in patches] == [PERHAPS, PERHAPS, TOUCHING, TOUCHING]
    assert {"100 %"} <= set(_texts(figure)) and len([t for t in _texts(figure) if t.endswith(" %")]) == 2
    # as wide as the limit, so that two touch where they are nearer
    level = Level.of(scene)
    assert level is not None
    wanted = level.circles_px(ground_positions(scene.bodies), 1.0)
    drawn = [line.get_xydata() for line in figure.axes[0].lines if len(line.get_xydata()) == wanted.shape[1]]
    assert all(np.abs(wanted - outline).max(axis=(1, 2)).min() < 1e-6 for outline in drawn) and len(drawn) == 4
    narrow = circles(scene, None, within_m=0.5)
    assert {to_hex(p.get_facecolor()).upper() for p in narrow.axes[0].patches} == {APART}
    flat = birds_eye(scene, None, within_m=2.0)
    assert {"0", "1", "2", "3", "100 %"} <= set(_texts(flat))


def test_heads_are_pixelated_and_laid_flat_so():
    pytest.importorskip("matplotlib")
    from proxemetry.plots import birds_eye, circles

    rng = np.random.default_rng(0)
    photo = Photo.from_array(rng.integers(0, 255, (1200, 1600, 3), dtype=np.uint8))
    keypoints = np.full((1, 17, 2), np.nan)
    keypoints[0, :5] = [(800, 500), (815, 490), (785, 490), (830, 500), (770, 500)]
    keypoints[0, [5, 6]] = [(860, 560), (740, 560)]
    scene = replace(
        _scene(_bodies([(0.0, 8.0)])), people=People(COCO_17, keypoints, np.isfinite(keypoints[..., 0]).astype(float))
    )
    for make in (circles, birds_eye):
        shown, blurred = (make(scene, photo, faces=faces).axes[0].images[0].get_array() for faces in ("show", "blur"))
        assert (shown != blurred).any()
        assert make(scene, photo).axes[0].images[0].get_array().shape == blurred.shape
    head = (slice(480, 510), slice(790, 810))
    shown, blurred = (circles(scene, photo, faces=f).axes[0].images[0].get_array()[head] for f in ("show", "blur"))
    assert len(np.unique(blurred)) < len(np.unique(shown)) / 3


@pytest.mark.parametrize(
    ("within", "faces"), [(0.0, "blur"), (-1.0, "blur"), (math.nan, "blur"), (1e9, "blur"), (2.0, "no")]
)
def test_what_is_no_limit_is_one_line(within, faces):
    from proxemetry.plots import birds_eye, circles

    for make in (circles, birds_eye):
        with pytest.raises(SettingsError):
            make(_scene(_bodies([(0.0, 8.0)])), None, within_m=within, faces=faces)


def test_nobody_placed_and_no_camera_are_figures_too():
    pytest.importorskip("matplotlib")
    from proxemetry.plots import birds_eye, circles

    nobody = Scene.failed("a.jpg", "why")
    lost = replace(_scene(_bodies([(0.0, 8.0)])), bodies=Bodies.unplaced(1, "scene", "hidden"))
    for scene in (nobody, lost, replace(lost, camera=CameraEstimate(None))):
        assert circles(scene, None).axes and birds_eye(scene, None).axes


def test_the_command_writes_both_kinds_of_the_photos_named(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    photos = write_photos(tmp_path / "photos", 2)
    names = sorted(p.relative_to(photos).as_posix() for p in photos.rglob("*.*"))
    out = str(tmp_path / "out")
    pose = ["--pose", "python:synthetic.small_photos:two_people", "--focal-35mm", "35"]
    assert main(["measure", str(photos), "--out", out, "--jobs", "0", *pose]) == 0
    capsys.readouterr()
    assert main(["figures", out, names[0], "--within", "1.5"]) == 0
    drawn = [f"{names[0]}.circles.png", f"{names[0]}.birds-eye.png"]
    assert capsys.readouterr().out.split() == [str(tmp_path / "out" / "figures" / name) for name in drawn]
    assert all((tmp_path / "out" / "figures" / name).stat().st_size > 10_000 for name in drawn)
    assert main(["figures", out, "nothing*"]) == 2
    assert "no measured photo there matches nothing*" in capsys.readouterr().err
    assert main(["figures", out, "--within", "0"]) == 2
    assert "a limit of 0 m is none" in capsys.readouterr().err
