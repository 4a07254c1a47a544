"""Laws of what lies between a photo and a network: letterboxes, tiles, crops, heads, suppression, doubles."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from proxemetry.errors import ModelError
from proxemetry.overlap import iou
from proxemetry.people import People
from proxemetry.people.duplicates import distinct, possible_duplicates, similarity
from proxemetry.people.skeleton import COCO_17
from proxemetry.pose.detections import (
    Detections,
    decode_nanodet,
    decode_ultralytics,
    decode_yolox,
    joined,
    seen_often,
    suppressed,
    uncut,
)
from proxemetry.pose.onnx.backend import _share_inside
from proxemetry.pose.onnx.letterbox import _shrunk, crop, letterbox, person_region, tiles, tiles_around
from proxemetry.pose.onnx.one_stage import decode_rtmo, decode_ultralytics_pose
from proxemetry.pose.onnx.pose_decoders import (
    _smoothed_around,
    decode_heatmaps_msra,
    decode_heatmaps_udp,
    decode_movenet,
    decode_simcc,
)
from proxemetry.pose.onnx.specification import Input
from proxemetry.pose.onnx.tiled_detector import normalised

SIDES = st.integers(1, 3000)
POINTS = st.tuples(st.floats(-100, 4000), st.floats(-100, 4000))


@given(SIDES, SIDES, st.booleans(), POINTS)
@settings(max_examples=50)
def test_a_letterbox_and_back_is_nothing(width: int, height: int, centred: bool, point: tuple[float, float]) -> None:
    pixels = np.broadcast_to(np.uint8(0), (height, width, 3))
    canvas, placement = letterbox(pixels, (0, 0, width, height), (416, 320), centred=centred)
    assert canvas.shape == (320, 416, 3)
    assert placement.to_photo(placement.to_input(point)) == pytest.approx(np.array(point), abs=1e-6)
    corners = placement.to_input([(0, 0), (width, height)])
    assert (corners >= 0).all() and (corners <= np.array([416, 320]) + 1e-9).all()
    assert np.allclose(corners, np.rint(corners)), "the photo's edges are drawn on edges of pixels"


def test_what_is_drawn_in_a_letterbox_is_where_the_placement_says() -> None:
    pixels = np.zeros((600, 1000, 3), np.uint8)
    pixels[200:300, 400:700] = 255
    canvas, placement = letterbox(pixels, (100, 50, 900, 550), (400, 400), centred=True)
    assert placement.scale == (0.5, 0.5) and placement.shift == (0, 75)
    white = np.argwhere(canvas[..., 0] == 255)
    drawn = [*white.min(axis=0)[::-1], *(white.max(axis=0) + 1)[::-1]]
    # (400 - 100) / 2 = 150, (200 - 50) / 2 + 75 = 150; 300 x 100 pixels become 150 x 50
    assert drawn == [150, 150, 300, 200]
    assert placement.boxes_to_photo([drawn])[0].tolist() == [400, 200, 700, 300]
    assert (canvas[:75] == 114).all() and (canvas[325:] == 114).all()


@given(SIDES, SIDES, st.floats(0.1, 1.5), st.floats(0.4, 2.5))
def test_tiles_cover_the_photo_and_stay_in_it(width: int, height: int, fraction: float, aspect: float) -> None:
    parts = list(tiles(width, height, fraction, aspect))
    for x0, y0, x1, y1 in parts:
        assert 0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height
    for side, low, high in ((width, 0, 2), (height, 1, 3)):
        spans = sorted({(p[low], p[high]) for p in parts})
        assert spans[0][0] == 0 and spans[-1][1] == side
        for (_, end), (start, stop) in itertools.pairwise(spans):
            # rounding to whole pixels may cost the overlap one of them
            assert end - start >= 0.3 * (stop - start) - 1
    if fraction >= 1:
        assert parts == [(0, 0, width, height)]


@given(
    st.integers(50, 900),
    st.integers(50, 900),
    st.floats(0.2, 0.9),
    st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1), st.floats(0.001, 0.5), st.floats(0.001, 0.5)), max_size=12),
)
def test_tiles_around_hold_whoever_fits_and_are_no_more_than_all(
    width: int, height: int, fraction: float, rows: list[tuple[float, float, float, float]]
) -> None:
    values = np.array(rows).reshape(-1, 4) * (width, height, width, height)
    boxes = np.concatenate([values[:, :2], values[:, :2] + values[:, 2:]], axis=1).clip(0, (width, height) * 2)
    everywhere = list(tiles(width, height, fraction))
    around = tiles_around(boxes, width, height, fraction)
    assert len(around) <= len(everywhere)
    tile = np.array(everywhere[0][2:]) - everywhere[0][:2]
    for part in around:
        assert min(part) >= 0 and part[2] <= width and part[3] <= height
        assert part[2] - part[0] == tile[0] and part[3] - part[1] == tile[1]
    if around == everywhere:
        return
    for box in boxes:
        if (box[2:] - box[:2] <= 0.96 * (tile - 1)).all():
            assert any((box[:2] >= p[:2]).all() and (box[2:] <= p[2:]).all() for p in around)


def test_a_suspect_who_nearly_fills_a_tile_gets_one_in_whose_middle_they_stand() -> None:
    # tiles of 0.6 x 640 = 384 pixels; 330 and a tenth on both sides would be more
    assert tiles_around([(200, 70, 310, 400)], 640, 500, 0.6) == [(63, 43, 447, 427)]
    assert tiles_around([(200, 70, 310, 444)], 640, 500, 0.6) == []  # its edges would touch the tile's


@given(st.floats(20, 200), st.floats(20, 200), st.floats(10, 300), st.floats(0.5, 2))
@example(x=20.0, y=20.0, width=188.875, aspect=0.5)
@settings(max_examples=60)
def test_a_crop_shows_what_its_region_holds(x: float, y: float, width: float, aspect: float) -> None:
    """On a ramp the value of each pixel drawn says where it came from: the placement's answer, up to known rounding.

    Drawing rounds to whole grey values, and OpenCV reads between pixels at the nearest 1/32 of one, from sums of two
    numbers rounded to 1/1024: of the photo's pixels that is more where the part was shrunk first. Shrinking rounds to
    whole grey values too, and averages a ramp of steps: the mean of steps over a span of 1/shrink pixels differs from
    the straight line's by at most 1/8 of a pixel over the span.
    """
    ramp = np.stack([np.tile(np.arange(256), (256, 1)), np.tile(np.arange(256)[:, None], (1, 256))], axis=-1)
    pixels = np.concatenate([ramp, np.zeros((256, 256, 1))], axis=-1).astype(np.uint8)
    region = (x - width / 2, y - width / 2 / aspect, x + width / 2, y + width / 2 / aspect)
    drawn, placement = crop(pixels, region, (48, 64))
    middles = np.stack(np.meshgrid(np.arange(48) + 0.5, np.arange(64) + 0.5), axis=-1)
    source = placement.to_photo(middles) - 0.5  # a ramp's pixel has the value of its index
    reach = np.maximum(1.0, 1 / np.array(placement.scale)) * 2 + 1
    inside = ((source > reach) & (source < 255 - reach)).all(axis=-1)
    error = np.abs(drawn[..., :2].astype(float) - source)[inside]
    shrink = np.array(_shrunk(pixels, region, placement.scale)[1].scale)
    bound = 0.5 + (1 / 64 + 2 / 1024) / shrink + np.where(shrink < 1, 0.5 + shrink / 8, 0.0)
    assert (error <= bound).all()


@given(st.floats(1, 100), st.floats(1, 100), st.floats(1, 2))
def test_a_persons_region_holds_their_box_in_the_networks_shape(width: float, height: float, padding: float) -> None:
    x0, y0, x1, y1 = person_region((10, 20, 10 + width, 20 + height), (192, 256), padding)
    assert (x1 - x0) / (y1 - y0) == pytest.approx(0.75)
    # the middle of pixel 96, the input's, shows what lies half a pixel beside the middle of the box
    step = (x1 - x0) / 192
    assert x0 + 96.5 * step == pytest.approx(10 + width / 2 + 0.5)
    assert y0 + 128.5 * step == pytest.approx(20 + height / 2 + 0.5)
    assert x1 - x0 >= width * padding * (1 - 1e-9) and y1 - y0 >= height * padding * (1 - 1e-9)


CELLS = st.tuples(st.floats(6, 40), st.floats(6, 56))


def _bump(at: tuple[float, float], sigma: float = 2.0, size: tuple[int, int] = (48, 64)) -> np.ndarray:
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    return 0.8 * np.exp(-((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2 * sigma**2))[None, None].astype(np.float32)


@given(CELLS)
def test_heatmaps_are_read_far_below_a_cell(at: tuple[float, float]) -> None:
    points, scores = decode_heatmaps_msra([_bump(at)], (192, 256))
    assert points[0, 0] == pytest.approx(np.array(at) * 4 + 0.5, abs=0.1)  # a fortieth of a cell
    assert scores[0, 0] == pytest.approx(0.8, abs=0.05)
    points, _ = decode_heatmaps_udp([_bump(at)], (192, 256))
    assert points[0, 0] == pytest.approx(np.array(at) * (191 / 47, 255 / 63) + 0.5, abs=0.1)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_smoothing_a_few_cells_is_smoothing_all_of_them(seed: int) -> None:
    """The kernel is OpenCV's of eleven cells, mirrored at the edges."""
    cv2 = pytest.importorskip("cv2")
    rng = np.random.default_rng(seed)
    maps = rng.uniform(0, 1, (5, 20, 16)).astype(np.float32)
    x, y = rng.integers(1, 15, 5), rng.integers(1, 19, 5)
    ours = _smoothed_around(maps, x, y)
    for one, column, row, around in zip(maps, x, y, ours, strict=True):
        whole = cv2.GaussianBlur(one, (11, 11), 0)
        assert around == pytest.approx(whole[row - 1 : row + 2, column - 1 : column + 2], abs=1e-6)


@pytest.mark.parametrize("decode", [decode_heatmaps_msra, decode_heatmaps_udp])
def test_heatmaps_without_a_peak_are_harmless(decode) -> None:  # type: ignore[no-untyped-def]
    for maps in (np.zeros((2, 3, 64, 48)), np.full((2, 3, 64, 48), 0.5), -np.ones((2, 3, 64, 48))):
        points, scores = decode([maps.astype(np.float32)], (192, 256))
        assert points.shape == (2, 3, 2) and np.isfinite(points).all()
        assert ((scores >= 0) & (scores <= 1)).all()
    with pytest.raises(ModelError, match="expected heatmaps"):
        decode([np.zeros((1, 17), np.float32)], (192, 256))


@given(st.tuples(st.floats(4, 187), st.floats(4, 251)), st.booleans())
def test_simcc_is_read_far_below_a_bin(at: tuple[float, float], swapped: bool) -> None:
    """Gaussians 5.66 bins wide at twice the input's size, as RTMPose is trained on; in either order of the axes."""
    vectors = [
        (0.7 * np.exp(-((np.arange(2 * side) - 2 * x) ** 2) / (2 * 5.66**2)))[None, None].astype(np.float32)
        for side, x in zip((192, 256), at, strict=True)
    ]
    points, scores = decode_simcc(vectors[::-1] if swapped else vectors, (192, 256))
    assert points[0, 0] == pytest.approx(np.array(at) + 0.5, abs=0.05)
    assert scores[0, 0] == pytest.approx(0.7, abs=0.01)


def test_a_simcc_joint_is_as_sure_as_its_unsurer_axis() -> None:
    across, down = np.zeros((1, 1, 384), np.float32), np.zeros((1, 1, 512), np.float32)
    across[0, 0, 100], down[0, 0, 100] = 0.9, 0.2
    assert decode_simcc([across, down], (192, 256))[1] == pytest.approx(0.2)
    with pytest.raises(ModelError, match="expected two SimCC vectors"):
        decode_simcc([across], (192, 256))


def test_yolox_heads_in_numbers() -> None:
    """Cell (3, 2) of stride 16 in a 64 x 64 input: 64 cells of stride 8 come first, then row 2, column 3 of 4."""
    raw = np.zeros((1, 64 + 16 + 4, 85), np.float32)
    raw[0, 64 + 2 * 4 + 3] = [0.5, 0.25, np.log(2), np.log(1.5), 0.9, 0.8, *[0] * 79]
    found = decode_yolox([raw], (64, 64), least=0.5)
    # middle ((3 + 0.5) * 16, (2 + 0.25) * 16) = (56, 36), size (32, 24)
    assert found.boxes_px == pytest.approx(np.array([[40, 24, 72, 48]]))
    assert found.scores == pytest.approx([0.72])
    assert len(decode_yolox([raw], (64, 64), person=1, least=0.5)) == 0


def test_anchor_free_heads_in_numbers() -> None:
    raw = np.zeros((1, 6, 3), np.float32)
    raw[0, :, 1] = [100, 50, 20, 40, 0.7, 0.2]
    found = decode_ultralytics([raw], (640, 640), least=0.5)
    assert found.boxes_px.tolist() == [[90, 30, 110, 70]]
    raw = np.zeros((1, 5 + 6, 2), np.float32)
    raw[0, :, 0] = [100, 50, 20, 40, 0.7, 95, 40, 0.9, 105, 60, 0.3]
    found = decode_ultralytics_pose([raw], (640, 640), least=0.5)
    points, scores = found.keypoints_px, found.keypoint_scores
    assert found.boxes_px.tolist() == [[90, 30, 110, 70]]
    assert points[0].tolist() == [[95.5, 40.5], [105.5, 60.5]] and scores[0] == pytest.approx([0.9, 0.3])
    for decode in (decode_rtmo, decode_ultralytics_pose):
        with pytest.raises(ModelError, match="expected"):
            decode([np.zeros((1, 7, 3), np.float32)], (640, 640))


BOXES = st.lists(
    st.tuples(st.floats(0, 500), st.floats(0, 500), st.floats(1, 300), st.floats(1, 300), st.floats(0.01, 1)),
    max_size=12,
)


def _detections(rows: list[tuple[float, ...]]) -> Detections:
    values = np.array(rows, dtype=float).reshape(-1, 5)
    return Detections(np.concatenate([values[:, :2], values[:, :2] + values[:, 2:4]], axis=1), values[:, 4])


@given(BOXES, st.floats(0, 1))
def test_suppression_leaves_no_overlap_and_always_the_best(rows: list[tuple[float, ...]], most: float) -> None:
    found = _detections(rows)
    kept = suppressed(found, most)
    for i in range(len(kept)):
        assert (iou(kept.boxes_px[i], kept.boxes_px[:i]) <= most).all()
    assert (np.diff(kept.scores) <= 0).all()
    if len(found):
        assert kept.scores[0] == found.scores.max()
    again = suppressed(kept, most)
    assert np.array_equal(again.boxes_px, kept.boxes_px)


@given(st.integers(0, 150), st.floats(0, 0.95), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_suppression_of_many_is_that_of_one_after_the_other(count: int, most: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    corners = random.integers(0, 40, (count, 2)).astype(float)
    boxes = np.concatenate([corners, corners + random.integers(0, 30, (count, 2))], axis=1)  # some without area
    found = Detections(boxes, random.integers(1, 20, count) / 20)
    kept: list[int] = []
    for row in np.argsort(-found.scores, kind="stable").tolist():
        if not (iou(boxes[row], boxes[kept]) > most).any():
            kept.append(row)
    assert np.array_equal(suppressed(found, most).boxes_px, boxes[kept])


@given(BOXES, st.floats(0.1, 0.9))
def test_boxes_that_few_cells_see_are_dropped(rows: list[tuple[float, ...]], overlap: float) -> None:
    found = _detections(rows)
    kept = suppressed(found, overlap)
    assert np.array_equal(seen_often(kept, found, overlap, 1).boxes_px, kept.boxes_px)
    twice = seen_often(kept, joined([found, found]), overlap, 2)
    assert np.array_equal(twice.boxes_px, kept.boxes_px)
    alone = [(iou(box, found.boxes_px) > overlap).sum() == 1 for box in kept.boxes_px]
    assert len(seen_often(kept, found, overlap, 2)) == len(kept) - sum(alone)


_SCALES = [((103.53, 116.28, 123.675), (57.375, 57.12, 58.395)), ((0.0, 0.0, 0.0), (255.0, 255.0, 255.0))]
_SCALES += [((0.0, 0.0, 1.0), (1.0, 1.0, 1.0)), ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]


@given(st.sampled_from(["rgb", "bgr"]), st.sampled_from(_SCALES), st.booleans(), st.integers(0, 2**32 - 1))
@settings(max_examples=40)
def test_a_network_sees_levels_less_the_mean_over_the_deviation(
    colours: str, scale: tuple[tuple[float, float, float], tuple[float, float, float]], last: bool, seed: int
) -> None:
    image = np.random.default_rng(seed).integers(0, 256, (2, 5, 7, 3), np.uint8)
    part = Input("x", "yolox", colours=colours, mean=scale[0], std=scale[1])
    network = SimpleNamespace(channels_last=last)
    seen = normalised(image, part, network)  # type: ignore[arg-type]
    expected = (image[..., :: -1 if colours == "bgr" else 1] - np.float32(part.mean)) / np.float32(part.std)
    assert seen.dtype == np.float32 and seen.flags["C_CONTIGUOUS"]
    assert np.array_equal(seen if last else seen.transpose(0, 2, 3, 1), expected)


def test_boxes_that_a_tile_cuts_are_left_to_another() -> None:
    found = Detections(np.array([[100, 100, 150, 200], [100, 0, 150, 99], [0, 10, 40, 90]], float), np.ones(3))
    # the tile's right edge at 150 and its lower edge at 200 are inner, its left and upper edges the photo's
    assert uncut(found, (0, 0, 150, 200), (300, 400)).boxes_px.tolist() == [[0, 10, 40, 90]]
    assert len(uncut(found, (0, 0, 150, 200), (150, 200))) == 3
    assert len(joined([])) == 0


def _nanodet(size: tuple[int, int], cell: int, bins: tuple[int, int, int, int]) -> list[np.ndarray]:
    """A head that sees one person, in a cell of stride 16, its sides so many strides from the cell's middle."""
    cells = [(size[0] // stride) * (size[1] // stride) for stride in (8, 16, 32)]
    classes = [np.zeros((1, n, 3), np.float32) for n in cells]
    sides = [np.zeros((1, n, 4 * 11), np.float32) for n in cells]
    classes[1][0, cell, 0] = 0.75
    for side, strides in enumerate(bins):
        sides[1][0, cell, side * 11 + strides] = 50.0
    return [*classes, *sides]


@given(st.integers(0, 23), st.tuples(*[st.integers(0, 10)] * 4))
def test_nanodets_boxes_are_strides_from_the_middle_of_a_cell(cell: int, bins: tuple[int, int, int, int]) -> None:
    found = decode_nanodet(_nanodet((96, 64), cell, bins), (96, 64), 0, 0.5)
    x, y = (cell % 6 + 0.5) * 16, (cell // 6 + 0.5) * 16
    left, top, right, bottom = (16 * b for b in bins)
    assert found.boxes_px == pytest.approx(np.array([[x - left, y - top, x + right, y + bottom]]), abs=1e-6)
    assert found.scores.tolist() == [0.75]
    assert len(decode_nanodet(_nanodet((96, 64), cell, bins), (96, 64), 1, 0.5)) == 0  # another class is nobody


def test_an_uncertain_side_is_the_mean_of_its_distribution() -> None:
    outputs = _nanodet((96, 64), 0, (0, 0, 0, 0))
    outputs[4][0, 0, 22:33] = -100.0
    outputs[4][0, 0, [24, 28]] = 3.0  # 2 or 6 strides to the right, one as likely as the other
    (box,) = decode_nanodet(outputs, (96, 64), 0, 0.5).boxes_px
    assert box[2] == pytest.approx(8 + 4 * 16)
    with pytest.raises(ModelError, match="not a NanoDet head"):
        decode_nanodet(outputs, (96, 96), 0, 0.5)


def test_movenet_answers_y_x_and_score_in_fractions_of_the_input() -> None:
    values = np.array([[[[0.25, 0.5, 0.9], [1.0, 0.0, 1.5]]]], np.float32)
    points, scores = decode_movenet([values], (200, 100))
    assert points.tolist() == [[[100, 25], [0, 100]]]
    assert scores == pytest.approx(np.array([[0.9, 1.0]]))
    with pytest.raises(ModelError, match="expected points"):
        decode_movenet([values[0]], (200, 100))


def test_a_skeleton_that_lies_in_anothers_box_is_told() -> None:
    own, others = np.array([0.0, 0, 100, 200]), np.array([300.0, 0, 400, 200])
    joints = np.random.default_rng(2).uniform((10, 10), (90, 190), (17, 2))
    outside = joints.copy()
    outside[COCO_17.joints.index("nose")] = (-20, 5)  # more than a twentieth of the width aside
    points = np.stack([joints, joints, outside])
    people = People(COCO_17, points, np.ones((3, 17)), boxes_px=np.stack([own, others, own]))
    assert _share_inside(people).tolist() == [1.0, 0.0, 0.8]
    limbs = np.where(np.isin(COCO_17.joints, ("left_wrist", "left_elbow")), 1.0, 0.0)[None]
    assert _share_inside(People(COCO_17, joints[None], limbs, boxes_px=others[None])).tolist() == [1.0]


def _people(offsets: list[tuple[float, float]], scores: list[float], size: float = 200) -> People:
    rng = np.random.default_rng(5)
    figure = rng.uniform(0, size, (17, 2))
    return People(
        COCO_17,
        np.array([figure + o for o in offsets]),
        np.ones((len(offsets), 17)),
        person_scores=np.array(scores),
    )


def test_the_same_person_seen_twice_is_one_and_neighbours_are_two() -> None:
    people = _people([(0, 0), (3, -2), (120, 0)], [0.7, 0.9, 0.5])
    assert distinct(people).person_scores.tolist() == [0.9, 0.5]
    assert len(distinct(People.none(COCO_17))) == 0


def test_who_is_a_little_like_somebody_surer_is_kept_and_said_doubtful() -> None:
    people = _people([(0, 0), (25, 10), (400, 0), (0, 0)], [0.7, 0.9, 0.5, 0.7])
    assert 0.25 < similarity(people)[0, 1] < 0.9
    assert possible_duplicates(people).tolist() == [True, False, False, True]
    assert possible_duplicates(people[[0, 2]]).tolist() == [False, False]
    assert possible_duplicates(people[[0, 3]]).tolist() == [False, True]  # of two alike one is someone
    assert possible_duplicates(People.none(COCO_17)).shape == (0,)


@given(st.permutations(range(4)))
def test_the_same_are_doubtful_in_any_order(order: list[int]) -> None:
    people = _people([(0, 0), (25, 10), (400, 0), (20, 0)], [0.7, 0.9, 0.5, 0.6])
    assert possible_duplicates(people[order]).tolist() == possible_duplicates(people)[order].tolist()


@given(st.floats(-300, 300), st.floats(-300, 300), st.floats(0.1, 10))
def test_similarity_is_symmetric_scale_free_and_one_with_oneself(dx: float, dy: float, factor: float) -> None:
    alike = similarity(_people([(0, 0), (dx, dy)], [0.5, 0.5]))
    assert np.diag(alike) == pytest.approx(1)
    assert alike[0, 1] == pytest.approx(alike[1, 0])
    scaled = similarity(_people([(0, 0), (dx * factor, dy * factor)], [0.5, 0.5], 200 * factor))
    assert scaled == pytest.approx(alike, abs=1e-6)
