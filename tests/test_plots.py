"""Figures: labels never overlap, heads are gone where asked for, nothing of the photo's metadata goes along."""

import math
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.path import Path as Outline
from matplotlib.patheffects import Normal, Stroke
from matplotlib.textpath import TextPath
from numpy.typing import NDArray
from PIL import Image

from proxemetry import plots
from proxemetry.arrays import FloatArray
from proxemetry.bodies import Bodies
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.camera.mount import Mount
from proxemetry.distances import UNCERTAIN, ZONES, ground_frame, measure_distances
from proxemetry.errors import OutputError, SettingsError
from proxemetry.intervals import CHI2_2D
from proxemetry.measure import place
from proxemetry.people import People
from proxemetry.people.doubts import in_words
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.plots.cased_lines import DASHED, Casing, Line, draw_cased
from proxemetry.plots.faces import heads_px, pixelated
from proxemetry.plots.figure import overlay_figure
from proxemetry.plots.geometry import ground_positions, ground_regions, horizon_px
from proxemetry.plots.lettering import draw_badges, draw_pair_labels, to_points
from proxemetry.plots.pair_selection import (
    PERSON_COLOURS,
    camera_text,
    footnote,
    line_colours,
    metres_text,
    pairs_shown,
    text_on,
)
from proxemetry.plots.picture import draw_picture
from proxemetry.plots.placement import Obstacles, along
from proxemetry.plots.placement import place as place_labels
from proxemetry.plots.zone_colours import ZONE_COLOURS
from proxemetry.scene import Scene
from proxemetry.settings import Settings

#: A standing person, facing the camera, metres above the feet's middle (x right, y down): one row a COCO joint.
STANDING_M = np.array([
    (0.0, -1.58), (0.03, -1.61), (-0.03, -1.61), (0.07, -1.59), (-0.07, -1.59), (0.17, -1.40), (-0.17, -1.40),
    (0.22, -1.12), (-0.22, -1.12), (0.22, -0.88), (-0.22, -0.88), (0.09, -0.90), (-0.09, -0.90), (0.09, -0.49),
    (-0.09, -0.49), (0.09, -0.08), (-0.09, -0.08),
])  # fmt: skip


def drawn_people(camera: Camera, places_m: list[tuple[float, float]], camera_height_m: float = 1.5) -> People:
    """Return people standing at (right, forward) metres as a level camera sees them."""
    points = [
        np.column_stack([STANDING_M[:, 0] + x, STANDING_M[:, 1] + camera_height_m, np.full(17, z)]) for x, z in places_m
    ]
    keypoints = camera.project(np.array(points).reshape(-1, 17, 3))
    return People(COCO_17, keypoints, np.full(keypoints.shape[:2], 0.9))


def drawn_scene(
    places_m: list[tuple[float, float]], width: int = 1200, height: int = 800, name: str = "x.jpg"
) -> Scene:
    camera = Camera.centred(0.9 * width, width, height, focal_rel_sd=0.03, source="test")
    people = drawn_people(camera, places_m)
    return place(name, "0" * 64, width, height, people, CameraEstimate(camera), Settings(method="torso"))


CROWD_M = [(-3.2 + 0.8 * (i % 9), 5.0 + 1.7 * (i // 9) + 0.13 * (i % 4)) for i in range(25)]


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 40))
def test_placed_labels_never_overlap_and_stay_inside(seed: int, count: int) -> None:
    random = np.random.default_rng(seed)
    bounds = np.array([0.0, 0.0, 600.0, 400.0])
    sizes = random.uniform((20, 8), (90, 16), (count, 2))
    ends = random.uniform((0, 0), (600, 400), (count, 2, 2))
    centres = place_labels([along(a, b, 9.0) for a, b in ends], sizes, np.zeros((0, 4)), Obstacles.none(), bounds)
    known = np.isfinite(centres).all(axis=1)
    assert known.all()  # forty small labels have room on this panel
    low, high = centres - sizes / 2, centres + sizes / 2
    assert (low >= -1e-9).all() and (high <= bounds[2:] + 1e-9).all()
    for i in range(count):
        for j in range(i):
            assert (low[i] >= high[j] - 1e-9).any() or (low[j] >= high[i] - 1e-9).any()


def test_a_label_without_room_is_left_out() -> None:
    bounds = np.array([0.0, 0.0, 100.0, 12.0])
    ends = [np.array([[x0, 6.0], [x1, 6.0]]) for x0, x1 in ((0, 45), (55, 100), (0, 100))]
    sizes = np.full((3, 2), (45.0, 10.0))
    centres = place_labels([along(*e, 9.0) for e in ends], sizes, np.zeros((0, 4)), Obstacles.none(), bounds)
    assert centres[:2].tolist() == [[22.5, 6.0], [77.5, 6.0]]
    assert np.isnan(centres[2]).all()  # two labels of 45 fit into 100, a third does not


def test_a_label_leaves_what_is_under_it_where_there_is_room_nearby() -> None:
    line, bounds = along(np.array([100.0, 100.0]), np.array([200.0, 100.0]), 6.0), np.array([0.0, 0.0, 300.0, 200.0])
    size, nothing = np.array([[60.0, 10.0]]), np.zeros((0, 4))
    body = np.array([[110.0, 80.0, 190.0, 120.0]])

    def at(cost: float, reach: float = math.inf) -> list[float]:
        return place_labels([line], size, nothing, Obstacles(body, np.array([cost])), bounds, reach)[0].tolist()

    assert at(0.0) == [150.0, 100.0]
    assert abs(at(8.0)[1] - 100.0) >= 25.0  # above or below the body: 20 to its edge, half a label more
    assert abs(at(1.0)[1] - 100.0) < 25.0  # cheaper to cover than to go two and a half heights
    assert abs(at(8.0, reach=1.0)[1] - 100.0) <= 10.0


def test_labels_stand_beside_bodies_not_on_them() -> None:
    scene = drawn_scene([(-2.4, 6.0), (-0.8, 6.0), (0.8, 6.0), (2.4, 6.0)])
    axes = plots.overlay(scene, None).axes[0]
    assert isinstance(axes.figure, Figure)
    boxes = [t.get_window_extent() for t in axes.texts if " m " in t.get_text()]
    joints = axes.transData.transform(scene.people.keypoints_px.reshape(-1, 2))
    assert len(boxes) == 3
    assert not any(box.contains(x, y) for box in boxes for x, y in joints)


def test_pairs_without_room_are_counted_in_a_corner_nearest_labelled_first() -> None:
    scene = drawn_scene(CROWD_M)
    texts = [t.get_text() for t in plots.overlay(scene, None, all_pairs=True).axes[0].texts]
    labels, counted = [t for t in texts if t.endswith("]")], [t for t in texts if t.startswith("+ ")]
    assert len(counted) == 1 and 10 < len(labels) < 60
    assert int(counted[0].split()[1]) == 300 - len([t for t in texts if " m [" in t])  # 25 people, 300 pairs


@pytest.mark.parametrize(("width", "height"), [(600, 400), (6000, 4000), (4000, 6000), (6000, 1500)])
@pytest.mark.parametrize("places_m", [CROWD_M[:2], CROWD_M], ids=["2 people", "25 people"])
def test_no_two_texts_overlap_at_any_size(width: int, height: int, places_m: list[tuple[float, float]]) -> None:
    scene = drawn_scene(places_m, width, height)
    figure = plots.overlay(scene, None)
    renderer = figure.canvas.get_renderer()  # type: ignore[attr-defined]
    for axes in figure.axes:
        boxes = [t.get_window_extent(renderer) for t in axes.texts if t.get_text()]
        assert len(boxes) >= len(places_m)
        for i, one in enumerate(boxes):
            for other in boxes[:i]:
                assert not one.overlaps(other)
    assert figure.axes[0].get_xlim() == (0, width)


def test_text_is_as_large_on_any_photo() -> None:
    small, large = (plots.overlay(drawn_scene(CROWD_M[:4], 600 * k, 400 * k), None) for k in (1, 10))
    assert tuple(small.get_size_inches()) == tuple(large.get_size_inches())
    assert [t.get_fontsize() for t in small.axes[0].texts] == [t.get_fontsize() for t in large.axes[0].texts]


def test_nearest_neighbours_first_all_pairs_on_request() -> None:
    scene = drawn_scene([(0.0, 5.0), (1.0, 5.0), (4.0, 5.0), (5.5, 5.0)], 4000, 1000)
    # gaps 1, 3, 1.5 m: everyone's nearest are 0-1 and 2-3
    assert pairs_shown(scene.distances) == [(0, 1), (2, 3)]
    everything = pairs_shown(scene.distances, all_pairs=True)
    assert len(everything) == 6 and everything[:2] == [(0, 1), (2, 3)]
    assert "nearest neighbours, 2 of 6 pairs" in footnote(scene, [(0, 1), (2, 3)])


def test_people_without_a_place_are_named_with_the_reason() -> None:
    scene = drawn_scene(CROWD_M[:2])
    people = People(COCO_17, np.full((1, 17, 2), np.nan), np.zeros((1, 17)), np.array([[10, 10, 60, 200.0]]))
    lost = place("x", "", 1200, 800, people, scene.camera, Settings(method="torso"))
    assert lost.bodies.reasons[0] and lost.bodies.reasons[0] in footnote(lost, [])
    plots.overlay(lost, None, faces="blur")


def test_a_photo_without_camera_or_people_still_gives_a_figure(tmp_path: Path) -> None:
    scene = drawn_scene([])
    unknown = place("x", "", 1200, 800, drawn_people(scene.camera.camera, CROWD_M[:3]),  # type: ignore[arg-type]
                    CameraEstimate(None, reason="no focal length"), Settings(method="torso"))  # fmt: skip
    for value in (scene, unknown, Scene.failed("broken.jpg", "truncated")):
        plots.save(plots.overlay(value, None), tmp_path / "figure.png")
        assert "Distance between" not in footnote(value, [])  # there is no line that would mean one


def test_a_number_beside_its_place_has_a_dot_at_the_place() -> None:
    axes = Figure(figsize=(4, 4)).subplots()
    axes.set(xlim=(0, 10), ylim=(0, 10))
    middle = to_points(axes, np.array([[5.0, 5.0], [5.1, 5.0]]))
    spots = [np.stack([point, point + (30, 0)]) for point in middle]
    draw_badges(axes, spots, [0, 1], ["#0072B2", "#E69F00"], with_dots=True)
    marks = [c for c in axes.collections if isinstance(c, PathCollection)]
    dots, discs = (np.asarray(c.get_offsets()) for c in sorted(marks, key=lambda c: float(c.get_sizes()[0])))
    assert len(dots) == 1 and dots[0] == pytest.approx([5.1, 5.0])  # the second number gave way to the first
    assert len(discs) == 2 and discs[:, 0].max() > 5.5


def test_intervals_are_part_of_every_number() -> None:
    assert metres_text(2.14, 1.71, 2.62) == "2.1 m [1.7, 2.6]"
    assert metres_text(0.634, 0.41, 0.88) == "0.6 m [0.4, 0.9]"
    assert metres_text(0.634, 0.56, 0.71) == "0.63 m [0.56, 0.71]"  # narrow enough for a second decimal
    assert metres_text(2.14) == "2.1 m"
    assert metres_text(math.nan) == "unknown"


def test_numbers_stand_out_from_every_person_colour() -> None:
    def luminance(colour: str) -> float:
        values = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
        return float(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
                     @ (0.2126, 0.7152, 0.0722))  # fmt: skip

    for colour in PERSON_COLOURS:
        light, dark = sorted((luminance(colour), luminance(text_on(colour))), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 4.5  # WCAG 2 AA


def _placed(position: list[float], covariance: FloatArray, up: tuple[float, float, float] | None = None) -> Bodies:
    return Bodies(
        np.array([position]), covariance, "test", ("torso",), (None,), up=None if up is None else np.array(up)
    )


def _inside(outline: FloatArray, points: FloatArray) -> NDArray[np.bool_]:
    return np.asarray(Outline(np.concatenate([outline, outline[:1]])).contains_points(points))


def test_where_a_person_stands_holds_90_percent() -> None:
    bodies = _placed([1.0, 0.0, 4.0], np.diag([0.01, 0.02, 0.04]))
    position, outline = ground_positions(bodies)[0], ground_regions(bodies)[0]
    assert position == pytest.approx([1.0, 4.0])
    draws = np.random.default_rng(0).multivariate_normal(position, np.diag([0.01, 0.04]), 40_000)
    assert _inside(outline, draws).mean() == pytest.approx(0.9, abs=0.006)
    assert np.isnan(measure_distances(bodies).distance_m[0, 0])


def test_where_a_person_stands_is_the_ellipse_where_depth_is_sure() -> None:
    covariance = np.array([[4e-6, 0, 1e-6], [0, 1e-6, 0], [1e-6, 0, 9e-6]])
    off = ground_regions(_placed([0.5, 0.2, 6.0], covariance))[0] - [0.5, 6.0]
    mahalanobis = np.einsum("ki,ij,kj->k", off, np.linalg.inv(covariance[::2, ::2]), off)
    assert mahalanobis == pytest.approx(CHI2_2D, rel=0.01)


@given(
    relative_sd=st.floats(0.001, 3.0), x=st.floats(-0.9, 0.9), depth=st.floats(0.3, 40.0), pitch=st.floats(-0.5, 1.2)
)
def test_whose_size_is_unsure_stands_on_the_line_of_sight_before_the_camera(
    relative_sd: float, x: float, depth: float, pitch: float
) -> None:
    position = depth * np.array([x, 0.1, 1.0])
    covariance = relative_sd**2 * np.outer(position, position) + 1e-8 * depth**2 * np.eye(3)
    up = (0.0, -math.cos(pitch), -math.sin(pitch))
    outline = ground_regions(_placed(list(position), covariance, up))[0]
    seen = ground_frame(np.array(up))[:2] @ position
    along = outline @ seen / (seen @ seen)
    assert (along > 0).all()
    assert np.abs(outline - np.outer(along, seen)).max() < 2e-3 * depth * max(1.0, along.max())


@given(relative_sd=st.floats(0.01, 3.0), x=st.floats(-0.9, 0.9), depth=st.floats(0.3, 40.0))
def test_at_an_unsure_focal_length_people_stay_as_far_from_the_axis(relative_sd: float, x: float, depth: float) -> None:
    position = [x * depth, 0.2, depth]
    outline = ground_regions(_placed(position, np.diag([1e-8, 1e-8, (relative_sd * depth) ** 2])))[0]
    assert outline[:, 0] == pytest.approx(np.full(len(outline), x * depth), abs=1e-3)
    assert (outline[:, 1] > 0).all()


@pytest.mark.parametrize("log_sd", [0.01, 0.2, 0.4, 0.8])
def test_depth_that_is_uncertain_by_a_factor_is_drawn_by_it(log_sd: float) -> None:
    """Depths about the median 5 m by exp(N(0, sd)): the covariance about it gives their ends again."""
    w = math.exp(log_sd**2 / 2)
    covariance = np.diag([1e-12, 1e-12, 25 * (w**4 - 2 * w + 1)])
    outline = ground_regions(_placed([0.0, 0.0, 5.0], covariance))[0]
    ends = np.log(outline[:, 1] / 5)
    assert (ends.min(), ends.max()) == pytest.approx(
        (-log_sd * math.sqrt(CHI2_2D), log_sd * math.sqrt(CHI2_2D)), rel=0.01
    )


def test_people_who_are_not_placed_have_no_region() -> None:
    assert np.isnan(ground_regions(Bodies.unplaced(2, "test", "why"))).all()


def test_blurring_covers_the_face_and_nothing_far_from_it() -> None:
    scene = drawn_scene([(0.0, 4.0), (2.0, 6.0)])
    heads = heads_px(scene.people)
    for person in range(2):
        face = scene.people.keypoints_px[person, :5]
        assert (np.linalg.norm(face - heads[person, :2], axis=1) <= heads[person, 2]).all()
    random = np.random.default_rng(1)
    pixels = random.integers(0, 255, (800, 1200, 3), dtype=np.uint8)
    blurred = pixelated(pixels, heads)
    y, x = np.mgrid[0:800, 0:1200] + 0.5
    for hx, hy, radius in heads:
        head = np.hypot(x - hx, y - hy) < radius
        assert len(np.unique(blurred[head], axis=0)) <= 6 * 6  # coarse squares: no detail below a fifth of the head
    near = (np.hypot(x[..., None] - heads[:, 0], y[..., None] - heads[:, 1]) < heads[:, 2] + 1).any(axis=-1)
    assert np.array_equal(blurred[~near], pixels[~near])
    assert np.array_equal(pixelated(pixels, np.full((1, 3), np.nan)), pixels)


def test_a_person_seen_from_behind_is_blurred_too() -> None:
    scene = drawn_scene([(0.0, 4.0)])
    scores = scene.people.scores.copy()
    scores[:, :5] = 0  # no face was seen
    behind = People(COCO_17, scene.people.keypoints_px, scores, scene.people.boxes_px)
    x, y, radius = heads_px(behind)[0]
    assert np.hypot(*(scene.people.keypoints_px[0, 0] - (x, y))) < radius


@pytest.mark.parametrize("suffix", plots.FORMATS)
def test_files_are_written_anew_without_the_photos_metadata(tmp_path: Path, suffix: str) -> None:
    exif = Image.Exif()
    exif[0x010E] = "SECRET-CAPTION"
    exif.get_ifd(0x8825)[29] = "2020:01:01"
    Image.new("RGB", (1200, 800), (90, 120, 150)).save(tmp_path / "photo.jpg", exif=exif)
    target = tmp_path / f"figure{suffix}"
    plots.save(plots.overlay(drawn_scene(CROWD_M[:2]), Photo.open(tmp_path / "photo.jpg"), faces="blur"), target)
    content = target.read_bytes()
    assert b"SECRET-CAPTION" not in content and b"Exif" not in content
    assert [p.name for p in tmp_path.iterdir() if "part" in p.name] == []


def test_the_same_scene_gives_the_same_bytes(tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        plots.save(plots.overlay(drawn_scene(CROWD_M[:5]), None), tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_file_names_with_dollar_signs_are_text_not_formulas(tmp_path: Path) -> None:
    plots.save(plots.overlay(drawn_scene(CROWD_M[:2], name=r"$\frac$_<b>.jpg"), None), tmp_path / "figure.png")


def test_errors_say_what_to_do(tmp_path: Path) -> None:
    figure = plots.plan(drawn_scene(CROWD_M[:2]))
    with pytest.raises(SettingsError, match=r"\.png, \.jpg, \.jpeg, \.svg, \.pdf"):
        plots.save(figure, tmp_path / "figure.bmp")
    with pytest.raises(OutputError, match="cannot be written"):
        plots.save(figure, tmp_path / "nowhere" / "figure.png")
    with pytest.raises(SettingsError, match="show, blur"):
        plots.overlay(drawn_scene([]), None, faces="hide")


def test_pyplot_is_never_loaded() -> None:
    code = (
        "import sys; from proxemetry import plots; assert 'matplotlib' not in sys.modules; "
        "import proxemetry.plots.figure; assert 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_pair_whose_interval_says_more_than_its_number_is_marked():
    from proxemetry.plots.pair_selection import line_styles, pair_text, short_pair_text

    scene = drawn_scene([(0.0, 5.0), (1.0, 5.0)])
    metres = scene.distances
    sure = short_pair_text(metres, 0, 1)
    assert "?" not in pair_text(metres, 0, 1) + sure
    doubtful = replace(metres, low_m=metres.low_m * 0.1, high_m=metres.high_m * 2)
    assert pair_text(doubtful, 0, 1).endswith("] ?")
    assert "–" in short_pair_text(doubtful, 0, 1)
    assert sure not in short_pair_text(doubtful, 0, 1)
    assert line_styles(metres, [(0, 1)]) != line_styles(doubtful, [(0, 1)])


def test_lines_have_the_colours_of_their_zones() -> None:
    distances = drawn_scene([(-0.5, 4.0), (0.5, 4.0)]).distances
    assert line_colours(distances, [(0, 1)]) == [ZONE_COLOURS[distances.zone(0, 1) or UNCERTAIN]]
    assert len(set(ZONE_COLOURS.values())) == len(ZONES) + 1


def test_the_horizon_is_where_level_rays_end() -> None:
    camera = Camera.centred(600, 640, 480)
    pitch, roll = 0.2, 0.05
    ends = horizon_px(camera, pitch, roll)
    up = np.array([math.sin(roll) * math.cos(pitch), -math.cos(roll) * math.cos(pitch), -math.sin(pitch)])
    np.testing.assert_allclose(camera.rays(ends) @ up, 0, atol=1e-12)
    assert ends[:, 1].max() < 240  # a camera that looks down has the horizon above the middle


@pytest.mark.parametrize(("pitch", "drawn"), [(0.1, True), (0.9, False), (math.nan, False)])
def test_the_legend_names_the_horizon_where_one_is_drawn(pitch: float, drawn: bool) -> None:
    scene = drawn_scene([(0.0, 4.0)])
    unknown, known = (math.nan,) * 4, not math.isnan(pitch)
    rows = ((1e-4, 0.0, math.nan, math.nan), (0.0, 1e-4, math.nan, math.nan)) if known else (unknown, unknown)
    tilt = Mount(pitch, 0.0 if known else math.nan, covariance=(*rows, unknown, unknown))
    scene = replace(scene, camera=replace(scene.camera, mount=tilt))
    figure = overlay_figure(scene, None, "show", False)
    (legend,) = figure.legends
    assert ("horizon" in [text.get_text() for text in legend.get_texts()]) is drawn
    assert sum(line.get_color() == "#FFFFFF" for line in figure.axes[0].lines) == drawn


def test_a_doubt_that_people_share_is_given_once() -> None:
    scene = drawn_scene([(-1.0, 4.0), (0.0, 4.0), (1.0, 4.0)])
    framed = replace(scene, people=replace(scene.people, framed=(True, False, True)))
    assert "(?): 0, 2: " in (said := footnote(framed, []))
    assert said.count(in_words(framed.people, 0, framed.doubts[0])) == 1


@pytest.mark.parametrize(
    ("rel_sd", "shown"), [(0.02, "± 3.3 %"), (0.1, "± 16 %"), (0.63, "32 mm [11, 91] as 35 mm equivalent, 1080 px")]
)
def test_the_focal_length_s_spread_is_never_in_powers_of_ten(rel_sd: float, shown: str) -> None:
    scene = drawn_scene([(0.0, 4.0)])
    camera = replace(scene.camera.camera, focal_rel_sd=rel_sd)
    assert shown in camera_text(replace(scene, camera=CameraEstimate(camera)))


def _drawn(figure: Figure) -> NDArray[np.int_]:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].astype(int)


@pytest.mark.parametrize("size", [(200, 140), (700, 500)], ids=["enlarged", "reduced"])
def test_a_photo_is_drawn_where_and_as_matplotlib_would(size: tuple[int, int]) -> None:
    y, x = np.mgrid[: size[1], : size[0]] / size[0]
    pixels = (np.stack([x, y, 0.5 + 0.5 * np.sin(9 * x + 5 * y)], axis=-1) * 255).astype(np.uint8)
    figure = Figure(figsize=(3.03, 2.17))
    axes = figure.add_axes((0.113, 0.071, 0.757, 0.811))
    draw_picture(axes, pixels, 6000, 4000)
    (image,) = axes.images
    renderer = FigureCanvasAgg(figure).get_renderer()
    for magnification in (1.0, 2.0):
        drawn, *corner, transform = image.make_image(renderer, magnification)
        expected, *expected_corner, _ = AxesImage.make_image(image, renderer, magnification)
        assert transform is None and corner == expected_corner
        away = np.abs(np.asarray(drawn).astype(int) - expected)  # of 255; a shift by one pixel is 2 and more
        assert away.mean() < 0.7 and away.max() <= 8
    axes.set(xlim=(1000, 2000))  # a part of it
    drawn, expected = image.make_image(renderer)[0], AxesImage.make_image(image, renderer)[0]
    np.testing.assert_array_equal(drawn, expected)


def test_lines_in_one_collection_are_those_of_path_effects() -> None:
    """Two groups that cross, the later one broken: casings of a group below its lines, the second group on top."""
    groups = [[((1, 2), (9, 7)), ((1, 8), (9, 3))], [((2, 1), (7, 9)), ((1, 5.3), (9, 5.9))]]
    one, other = (Figure(figsize=(2, 2)) for _ in range(2))
    for figure in (one, other):
        figure.add_axes((0, 0, 1, 1)).set(xlim=(0, 10), ylim=(0, 10))
    dashes = (None, DASHED)
    lines = [[Line(np.array(e), "#E69F00", d) for e in ends] for ends, d in zip(groups, dashes, strict=True)]
    draw_cased(one.axes[0], lines, 2.0, [Casing(1.5, "#000000", 0.5)], zorder=2, caps="butt")
    halo = [Stroke(linewidth=3.5, foreground="#000000", alpha=0.5), Normal()]
    for ends, style in zip(groups, ("solid", "dashed"), strict=True):
        other.axes[0].add_collection(
            LineCollection(ends, colors="#E69F00", linewidths=2.0, linestyles=style, path_effects=halo, zorder=2,
                           capstyle="butt")
        )  # fmt: skip
    np.testing.assert_allclose(_drawn(one), _drawn(other), atol=2)


@pytest.mark.parametrize("text", ["2.1 m [1.7, 2.6]", "0.63 m [0.56, 0.71] ?", "+ 212 more without room for a label"])
def test_a_label_is_as_wide_as_the_curves_of_its_letters(text: str) -> None:
    axes = Figure(figsize=(6, 4)).add_axes((0, 0, 1, 1))
    ends = [(np.array([100.0, 150.0]), np.array([300.0, 150.0]))]
    (box,) = draw_pair_labels(axes, ends, [text], ["#0072B2"], np.zeros((0, 4)), Obstacles.none())
    width = TextPath((0, 0), text, size=8.5).get_extents().width
    assert box[2] - box[0] == pytest.approx(width + 5.2, abs=1e-6)


def test_the_plan_says_its_metres_at_its_lines() -> None:
    axes = plots.plan(drawn_scene([(-2.0, 6.0), (2.0, 7.0)])).axes[0]
    (grid,) = [c for c in axes.collections if isinstance(c, LineCollection) and len(c.get_segments()) > 10]
    upright = sorted(float(s[0, 0]) for s in grid.get_segments() if s[0, 0] == s[1, 0])
    said = [t for t in axes.texts if t.get_position()[1] == 0 and t.get_va() == "top"]
    assert [float(t.get_text().replace("\N{MINUS SIGN}", "-")) for t in said] == upright
    assert [t.get_position()[0] for t in said] == upright
