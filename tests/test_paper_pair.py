"""The paper's pair: groups of boxes, BODY_25's decoding, real Darknet files, and both networks together."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proxemetry.errors import ModelError
from proxemetry.overlap import iou
from proxemetry.people import People
from proxemetry.people.skeleton import BODY_25
from proxemetry.photo import Photo
from proxemetry.pose import backend_named
from proxemetry.pose.detections import Detections
from proxemetry.pose.paper.body25 import (
    CHANNELS,
    JOINTS,
    LIMBS,
    PEAK_THRESHOLD,
    _connect,
    _limb_scores,
    _Person,
    decode,
    peaks_of,
)
from proxemetry.pose.paper.box_groups import grouped, grouped_as_published
from proxemetry.pose.paper.opencv_network import DarknetDetector, OpenCvNetwork
from proxemetry.pose.paper.openpose_body25 import Body25, net_scale, net_size
from proxemetry.pose.paper.yolov4_openpose import PublishedBehaviour, YoloOpenPose
from synthetic.field_maps import maps_of, standing
from synthetic.network_files import field, varint

SHARED = Path(__file__).resolve().parents[2] / "shared"
MODELS, PHOTOS = SHARED / "models", SHARED / "data" / "photos"
needs_models = pytest.mark.skipif(
    not (MODELS / "yolov4.cfg").is_file(), reason="the models are not beside this checkout"
)

BOXES = st.lists(
    st.tuples(st.integers(0, 60), st.integers(0, 60), st.integers(1, 30), st.integers(1, 30)), max_size=9
).map(lambda rows: np.array([(x, y, x + w, y + h) for x, y, w, h in rows], float).reshape(-1, 4))


# Groups ------------------------------------------------------------------------------------------------------------


@given(BOXES, st.randoms(use_true_random=False))
def test_groups_part_the_boxes_whatever_their_order(boxes: np.ndarray, random) -> None:  # type: ignore[no-untyped-def]
    groups = grouped(boxes)
    assert sorted(row for group in groups for row in group.rows) == list(range(len(boxes)))
    order = list(range(len(boxes)))
    random.shuffle(order)
    shuffled = {frozenset(order[row] for row in group.rows) for group in grouped(boxes[order])}
    assert shuffled == {frozenset(group.rows) for group in groups}
    for group in groups:
        assert group.count == len(group.rows)
        assert group.region_px == (*boxes[list(group.rows), :2].min(axis=0), *boxes[list(group.rows), 2:].max(axis=0))


@given(BOXES)
def test_nobody_overlaps_a_box_of_another_group(boxes: np.ndarray) -> None:
    groups = grouped(boxes)
    for one in groups:
        for other in groups:
            if one is not other:
                assert all((iou(boxes[i], boxes[list(other.rows)]) == 0).all() for i in one.rows)


def _listed_as_published(boxes: np.ndarray) -> list[tuple[set[int], int]]:
    """The published code's lists, grown while they are walked through, in its own way: an independent reference."""
    order = np.argsort(boxes[:, 0], kind="stable")
    rows = boxes[order].tolist()
    lists: list[list[int]] = [[] for _ in rows]

    def within(low: float, value: float, high: float) -> bool:
        return low < value < high

    def on_axis(a: list[float], b: list[float], axis: int) -> bool:
        return any(within(b[axis], a[k], b[axis + 2]) or within(a[axis], b[k], a[axis + 2]) for k in (axis, axis + 2))

    for i, a in enumerate(rows):
        lists[i] = [k for k in range(i + 1, len(rows)) if on_axis(a, rows[k], 0) and on_axis(a, rows[k], 1)]
    for i, _ in enumerate(lists):
        position = 0
        while position < len(lists[i]):
            lists[i].extend(lists[lists[i][position]] if lists[i][position] != i else [])
            position += 1
    for i, members in enumerate(lists):
        members.append(i)
    kept = [i for i in range(len(lists)) if not any(set(lists[i]) <= set(lists[k]) for k in range(i))]
    return [({int(order[m]) for m in lists[i]}, len(lists[i])) for i in kept]


@given(BOXES.filter(lambda boxes: len(boxes) <= 7))
def test_published_groups_are_those_of_the_published_lists(boxes: np.ndarray) -> None:
    groups = grouped_as_published(boxes)
    assert [(set(g.rows), g.count) for g in groups] == _listed_as_published(boxes)


def test_the_published_grouping_is_not_transitive() -> None:
    """B and C both overlap D, and C lies right of B: B's group has D but never learns of C, C's group has D too."""
    boxes = np.array([[0, 0, 10, 10], [5, 20, 12, 30], [8, 5, 20, 25]], float)
    assert [g.rows for g in grouped(boxes)] == [(0, 1, 2)]
    assert [g.rows for g in grouped_as_published(boxes)] == [(0, 2), (1, 2)]
    twice = np.array([[0, 0, 10, 10], [0, 0, 10, 10]], float)
    assert len(grouped(twice)) == 1
    assert len(grouped_as_published(twice)) == 2


# Decoding ----------------------------------------------------------------------------------------------------------


def _assert_found(points: np.ndarray, truth: list[np.ndarray], tolerance: float) -> None:
    """Everyone of the truth is found once, with all joints that they have and no other."""
    assert len(points) == len(truth)
    for joints in truth:
        distance = np.nanmax(np.linalg.norm(points - joints, axis=-1), axis=1)
        best = points[np.nanargmin(distance)]
        assert np.array_equal(np.isfinite(best).all(axis=-1), np.isfinite(joints).all(axis=-1))
        assert np.nanmax(np.linalg.norm(best - joints, axis=-1)) < tolerance


def test_one_person_is_decoded_joint_by_joint() -> None:
    truth = standing(100, 20, 320)
    points, scores = decode(maps_of([truth], (208, 368)))
    _assert_found(points, [truth], 0.6)
    assert (scores[0] > 0.8).all()


def test_nobody_is_decoded_from_empty_maps() -> None:
    points, scores = decode(np.zeros((CHANNELS, 368, 208), np.float32))
    assert points.shape == (0, 25, 2) and scores.shape == (0, 25)


@pytest.mark.parametrize("seed", range(4))
def test_two_people_who_overlap_stay_two(seed: int) -> None:
    """One stands half in front of the other: limbs cross, but their fields point along their own."""
    rng = np.random.default_rng(seed)
    truth = [standing(110, 15, 330, rng), standing(175, 40, 310, rng)]
    _assert_found(decode(maps_of(truth, (288, 368)))[0], truth, 2.0)


def test_a_person_cut_by_the_edge_has_the_joints_that_are_left() -> None:
    truth = standing(12, 30, 320)
    truth[(truth < 4).any(axis=1)] = np.nan  # the right side is beyond the picture
    assert 8 < np.isfinite(truth[:, 0]).sum() < 25
    _assert_found(decode(maps_of([truth], (208, 368)))[0], [truth], 2.0)


@pytest.mark.parametrize("seed", range(2))
def test_twenty_people_at_once_are_twenty(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = [standing(45 + 64 * (k % 10) + rng.uniform(-4, 4), 8 + 182 * (k // 10), 165, rng) for k in range(20)]
    points, _ = decode(maps_of(truth, (688, 368), sigma=3.0))
    # the feet's own joints lie 3 to 5 px apart at this size: peaks merge, as they do in practice
    seen = [np.where(np.arange(JOINTS)[:, None] < 19, joints, np.nan) for joints in truth]
    points[:, 19:] = np.nan
    _assert_found(points, seen, 2.5)


def test_a_few_loose_joints_are_nobody() -> None:
    alone = np.full((25, 2), np.nan)
    alone[[4, 7]] = (50, 50), (120, 80)  # two wrists
    assert len(decode(maps_of([alone], (208, 368)))[0]) == 0
    leg = np.full((25, 2), np.nan)
    leg[[11, 22, 23, 24]] = (50, 50), (60, 75), (70, 72), (45, 70)  # an ankle and a foot: feet do not count
    assert len(decode(maps_of([leg], (208, 368), sigma=2.0))[0]) == 0


def test_peaks_are_centres_of_gravity_and_shun_the_rim() -> None:
    heatmap = maps_of([np.where(np.arange(25)[:, None] == 0, (30.3, 40.6), np.nan)], (80, 90))[0]
    # seven pixels hold only the middle of so wide a bump: the centre of gravity stays near the highest pixel
    assert peaks_of(heatmap) == pytest.approx(np.array([[30.3, 40.6, heatmap.max()]]), abs=0.5)
    rim = np.zeros((20, 20), np.float32)
    rim[0, 5] = rim[10, 19] = 1
    assert len(peaks_of(rim)) == 0
    plateau = np.zeros((20, 20), np.float32)
    plateau[8:10, 8] = 1
    assert len(peaks_of(plateau)) == 0, "inside, a peak is higher than all of its neighbours"
    assert len(peaks_of(np.zeros((2, 50), np.float32))) == 0


def test_one_pixel_from_the_edge_a_peak_may_be_a_plateau() -> None:
    """As high as a neighbour, where resizing makes them: OpenPose's own rule of the outermost ring."""
    ring = np.zeros((20, 20), np.float32)
    ring[1, 5:7] = 1
    assert len(peaks_of(ring)) == 2
    one_in = np.zeros((20, 20), np.float32)
    one_in[2, 5:7] = 1
    assert len(peaks_of(one_in)) == 0


@pytest.mark.parametrize(
    ("turned_deg", "strength", "covered", "score"),
    [(0, 0.8, 1.0, 0.8), (60, 0.8, 1.0, 0.4), (90, 0.8, 1.0, 0.0), (180, 0.8, 1.0, 0.0), (0, 0.04, 1.0, 0.0),
     (0, 0.8, 0.97, 0.8), (0, 0.8, 0.8, 0.0)],
)  # fmt: skip
def test_a_limb_scores_its_field_along_the_line(
    turned_deg: float, strength: float, covered: float, score: float
) -> None:
    """A field of one strength and direction over a part of the line; the mean of what is strong enough of it."""
    turn = np.radians(turned_deg)
    field_x, field_y = (np.full((100, 120), strength * v, np.float32) for v in (np.cos(turn), np.sin(turn)))
    beyond = round(10 + 100 * covered)
    field_x[:, beyond:] = field_y[:, beyond:] = 0
    a, b = np.array([[10.0, 50, 0.9]]), np.array([[110.0, 50, 0.9]])
    assert _limb_scores(a, b, field_x, field_y) == pytest.approx(np.array([[score]]), abs=1e-6)


def test_joints_that_nearly_coincide_get_the_least_score() -> None:
    nothing = np.zeros((150, 150), np.float32)
    a = np.array([[50.0, 50, 0.9]])
    assert _limb_scores(a, a + (0.7, 0, 0), nothing, nothing) == pytest.approx(PEAK_THRESHOLD)
    assert _limb_scores(a, a + (1.3, 0, 0), nothing, nothing) == 0
    assert _limb_scores(a, a, nothing, nothing) == 0


def test_a_persons_score_is_of_all_joints_and_connections_once() -> None:
    """Two arms and what ties them together: four joints, three connections, and one that closes a ring."""
    people: list[_Person] = []
    owner: dict[tuple[int, int], _Person] = {}
    joints = {joint: (joint, 0, 0.1 * joint) for joint in (1, 2, 3, 4)}
    _connect(people, owner, joints[1], joints[2], 0.5)
    _connect(people, owner, joints[3], joints[4], 0.6)
    assert [p.score for p in people] == pytest.approx([0.8, 1.3])
    _connect(people, owner, joints[2], joints[3], 0.7)
    (whole,) = people
    assert whole.score == pytest.approx(0.8 + 1.3 + 0.7) and whole.peaks == {1: 0, 2: 0, 3: 0, 4: 0}
    _connect(people, owner, joints[4], joints[1], 0.05)
    assert whole.score == pytest.approx(2.85)
    _connect(people, owner, joints[1], (5, 0, 0.3), 0.2)
    assert whole.score == pytest.approx(3.35) and whole.peaks[5] == 0
    _connect(people, owner, joints[2], (5, 1, 0.9), 0.9)  # a surer one was there before
    assert whole.score == pytest.approx(3.35) and whole.peaks[5] == 0


def test_every_field_belongs_to_one_limb() -> None:
    assert sorted(channel for _, _, channel in LIMBS) == list(range(0, 52, 2))


def test_limbs_and_fields_are_openposes() -> None:
    """The lists of poseParameters.cpp for BODY_25, as it has them: pairs of joints, and each pair's x and y."""
    pairs = (
        "1,8 1,2 1,5 2,3 3,4 5,6 6,7 8,9 9,10 10,11 8,12 12,13 13,14 1,0 0,15 15,17 0,16 16,18 2,17 5,18 "
        "14,19 19,20 14,21 11,22 22,23 11,24"
    )
    fields = (
        "0,1 14,15 22,23 16,17 18,19 24,25 26,27 6,7 2,3 4,5 8,9 10,11 12,13 30,31 32,33 36,37 34,35 38,39 20,21 28,29 "
        "40,41 42,43 44,45 46,47 48,49 50,51"
    )
    ours = [f"{a},{b}" for a, b, _ in LIMBS], [f"{x},{x + 1}" for _, _, x in LIMBS]
    assert ours == (pairs.split(), fields.split())


# The networks ------------------------------------------------------------------------------------------------------


def test_the_input_has_openposes_size() -> None:
    # 1280 x 720: 368 * 1280 / 720 / 16 = 40.9, so 41 * 16
    assert net_size(1280, 720) == (656, 368)
    assert net_size(100, 1000) == (32, 368) and net_size(1, 1000) == (16, 368)
    # the last pixel falls on the last pixel: 367 / 719 is less than 655 / 1279
    assert net_scale(1280, 720, (656, 368)) == pytest.approx(367 / 719)


class _Answering(OpenCvNetwork):
    """A network whose answer is known: maps of people given in positions of its input, eight times smaller."""

    def __init__(self, people: list[np.ndarray]) -> None:
        self.people, self.files, self.shapes = people, (Path("known.prototxt"), Path("known.caffemodel")), []

    def run(self, blob: np.ndarray) -> list[np.ndarray]:
        self.shapes.append(blob.shape)
        return [maps_of(self.people, (blob.shape[3], blob.shape[2]), stride=8)[None]]


def _body25(people: list[np.ndarray]) -> Body25:
    pose = object.__new__(Body25)
    pose.network, pose.net_height = _Answering(people), 368
    return pose


def test_joints_come_back_to_the_picture() -> None:
    """A picture twice the input's size; the maps are an eighth of it, as the network's are."""
    truth = standing(100, 20, 320)
    pose = _body25([truth])
    points, _ = pose.detect(np.zeros((736, 416, 3), np.uint8))
    assert pose.network.shapes == [(1, 3, 368, 208)]
    scale = net_scale(416, 736, (208, 368))
    assert np.nanmax(np.abs(points[0] - (truth / scale + 0.5))) < 2.5
    assert np.abs(np.nanmean(points[0] - (truth / scale + 0.5), axis=0)).max() < 0.3


def _layers(prototxt: str) -> list[dict[str, object]]:
    """Read name, type, inputs, output and convolution size of each layer of a Caffe description."""
    found = []
    for text in prototxt.split("\nlayer {")[1:]:

        def words(key: str, text: str = text) -> list[str]:
            return re.findall(rf'\b{key}: "?([^"\s]+)"?', text)

        found.append(
            {
                "name": words("name")[0], "type": words("type")[0], "from": words("bottom"), "to": words("top")[0],
                "outputs": int((words("num_output") or ["0"])[0]), "size": int((words("kernel_size") or ["1"])[0]),
            }
        )  # fmt: skip
    return found


def caffe_weights(prototxt: Path, path: Path, biases: dict[str, np.ndarray]) -> Path:
    """Write weights of the right shapes, all zero but the biases named."""
    channels = {"image": 3}
    with path.open("wb") as stream:
        for layer in _layers(prototxt.read_text()):
            coming = sum(channels[name] for name in layer["from"])
            channels[layer["to"]] = layer["outputs"] or coming
            if layer["type"] == "Convolution":
                shape = (layer["outputs"], coming, layer["size"], layer["size"])
                blobs = [np.zeros(shape, np.float32), biases.get(layer["name"], np.zeros(shape[0], np.float32))]
            elif layer["type"] == "PReLU":
                blobs = [np.zeros(coming, np.float32)]
            else:
                continue
            message = field(1, layer["name"]) + field(2, layer["type"])
            for blob in blobs:
                dims = field(1, b"".join(varint(d) for d in blob.shape))
                message += field(7, field(7, dims) + field(5, blob.astype("<f4").tobytes()))
            stream.write(field(100, message))
    return path


@needs_models
def test_the_real_description_takes_weights_and_answers_in_order(tmp_path: Path) -> None:
    """Known biases at both ends come out as the channels that the decoder takes them for: heatmaps, then fields."""
    prototxt = MODELS / "body_25_pose_deploy.prototxt"
    joints = np.linspace(0.001, 0.026, 26).astype(np.float32)
    fields = np.linspace(0.101, 0.152, 52).astype(np.float32)
    weights = caffe_weights(
        prototxt, tmp_path / "generated.caffemodel", {"Mconv7_stage1_L1": joints, "Mconv7_stage3_L2": fields}
    )
    pose = Body25(prototxt, weights, net_height=48)
    answer = pose.network.run(np.zeros((1, 3, 48, 64), np.float32))[0]
    assert answer.shape == (1, CHANNELS, 6, 8)
    assert answer[0, :, 3, 4] == pytest.approx(np.concatenate([joints, fields]), abs=1e-6)
    points, _ = pose.detect(np.zeros((60, 80, 3), np.uint8))
    assert len(points) == 0
    with pytest.raises(ModelError, match="OpenCV cannot read them"):
        Body25(prototxt, prototxt)


@needs_models
def test_the_papers_detector_is_read(tmp_path: Path) -> None:
    """YOLOv4's description with weights that are all zero: every box scores 0.5 x 0.5, so nobody is there at 0.3."""
    weights = tmp_path / "zero.weights"
    with weights.open("wb") as stream:
        stream.write(np.array([0, 2, 5, 0, 0], "<i4").tobytes())
        stream.truncate(257_717_640)  # the size of the published file
    detector = DarknetDetector(MODELS / "yolov4.cfg", weights, size=(64, 64))
    rows = detector.network.run(np.zeros((1, 3, 64, 64), np.float32))
    # three anchors in each cell of 8 x 8, 4 x 4 and 2 x 2
    assert sorted(r.shape for r in rows) == [(12, 85), (48, 85), (192, 85)]
    assert len(detector.detect(np.zeros((90, 120, 3), np.uint8))) == 0


@needs_models
@pytest.mark.parametrize("name", ["yolo-fastest-1.1_body", "yolo-fastest-1.1-xl"])
def test_real_darknet_files_find_what_opencvs_own_detector_finds(name: str) -> None:
    cv2 = pytest.importorskip("cv2")
    size = (320, 320)
    files = [MODELS / f"{name}.cfg", MODELS / f"{name}.weights"]
    pixels = Photo.open(PHOTOS / "COCO_val2014_000000000241.jpg").pixels()
    found = DarknetDetector(*files, size=size).detect(pixels)
    reference = cv2.dnn.DetectionModel(*map(str, files[::-1]))
    reference.setInputParams(1 / 255, size, swapRB=True)
    classes, scores, boxes = reference.detect(pixels[..., ::-1].copy(), 0.3, 0.4)
    people = boxes[np.ravel(classes) == 0].astype(float)
    assert len(found) == len(people) >= 1
    people[:, 2:] += people[:, :2]
    order = np.argsort(-np.ravel(scores)[np.ravel(classes) == 0], kind="stable")
    # the reference rounds to whole pixels, and moves boxes that reach beyond the picture into it
    height, width = pixels.shape[:2]
    whole = (found.boxes_px > 1).all(axis=1) & (found.boxes_px < (width, height, width, height)).all(axis=1)
    assert whole.any()
    assert np.abs(found.boxes_px - people[order])[whole].max() <= 2


@needs_models
def test_files_that_do_not_belong_together_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no such network file"):
        DarknetDetector(MODELS / "yolov4.cfg", tmp_path / "absent.weights")
    with pytest.raises(ModelError, match=r"no yolov4\.weights in it"):
        backend_named(f"yolov4-openpose:{MODELS}")
    with pytest.raises(ModelError, match="not in"):
        backend_named("yolov4-openpose")


def test_an_opencv_without_the_readers_says_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cv2 = pytest.importorskip("cv2")
    monkeypatch.delattr(cv2.dnn, "readNetFromDarknet")
    (tmp_path / "a").touch()
    with pytest.raises(ModelError, match=r"reads no Darknet files: pip install 'proxemetry\[paper\]'"):
        OpenCvNetwork("Darknet", tmp_path / "a", tmp_path / "a")


# Both together -----------------------------------------------------------------------------------------------------


class _Boxes(DarknetDetector):
    """A detector whose boxes are known, in pixels of the half-size photo."""

    def __init__(self, boxes: list[tuple[float, float, float, float]]) -> None:
        self.boxes = np.array(boxes, dtype=float).reshape(-1, 4)

    def detect(self, pixels: np.ndarray) -> Detections:
        self.seen = pixels.shape
        return Detections(self.boxes, np.full(len(self.boxes), 0.9))


class _Crops(Body25):
    """A pose network that sees, in each crop, the people given in pixels of the half-size photo."""

    def __init__(self, people: list[np.ndarray], photo: np.ndarray) -> None:
        self.people, self.photo, self.crops = people, photo, []

    def detect(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        y, x = (int(v) for v in pixels[0, 0, :2])  # the photo's pixels say where they are
        self.crops.append((x, y, pixels.shape[1], pixels.shape[0]))
        points = np.array(self.people).reshape(-1, 25, 2) - (x, y)
        inside = ((points >= 0) & (points <= (pixels.shape[1], pixels.shape[0]))).all(axis=-1)
        return np.where(inside[..., None], points, np.nan), np.where(inside, 0.8, 0.0)


def _located(height: int = 200, width: int = 250) -> np.ndarray:
    """A photo of twice that size, even over blocks of 2 x 2, whose half-size pixels hold their own row and column."""
    rows, columns = np.indices((height, width))
    half = np.stack([rows, columns, np.zeros_like(rows)], axis=-1).astype(np.uint8)
    return half.repeat(2, axis=0).repeat(2, axis=1)


def _pair(boxes: list[tuple[float, ...]], people: list[np.ndarray], **published: bool) -> tuple[YoloOpenPose, People]:
    photo = _located()
    backend = YoloOpenPose(_Boxes(boxes), _Crops(people, photo), published=PublishedBehaviour(**published))  # type: ignore[arg-type]
    return backend, backend.detect(Photo.from_array(photo))


ONE, TWO, FAR = standing(50, 10, 150), standing(75, 15, 150), standing(180, 20, 150)


def _box(joints: np.ndarray) -> tuple[float, float, float, float]:
    (x0, y0), (x1, y1) = np.floor(joints.min(axis=0)) - 2, np.ceil(joints.max(axis=0)) + 2
    return float(x0), float(y0), float(x1), float(y1)


def test_people_come_back_in_pixels_of_the_full_photo() -> None:
    backend, people = _pair([_box(FAR), _box(ONE), _box(TWO)], [ONE, TWO, FAR])
    assert backend.detector.seen == (200, 250, 3)
    assert len(backend.pose.crops) == 2, "the two who overlap share a crop"
    assert people.skeleton is BODY_25 and len(people) == 3
    found = people.keypoints_px[np.argsort(people.joint("neck")[:, 0])]
    for joints, truth in zip(found, (ONE, TWO, FAR), strict=True):
        assert joints == pytest.approx(truth * 2)


def test_nobody_detected_is_nobody() -> None:
    backend, people = _pair([], [ONE])
    assert len(people) == 0 and not backend.pose.crops


def test_a_skeleton_without_a_box_of_its_own_is_dropped() -> None:
    """The box of one person shows two skeletons: one is a reflection, say. Only the pair of models knows."""
    ghost = (TWO - TWO.mean(axis=0)) * 0.3 + ONE.mean(axis=0)
    _, people = _pair([_box(ONE)], [ONE, ghost])
    assert len(people) == 1
    assert people.keypoints_px[0] == pytest.approx(ONE * 2)


def test_the_published_code_keeps_the_largest_where_eyes_outnumber_boxes() -> None:
    ghost = (TWO - TWO.mean(axis=0)) * 0.3 + ONE.mean(axis=0)
    _, people = _pair([_box(ONE)], [ghost, ONE], surplus=True)
    assert people.keypoints_px[0] == pytest.approx(ONE * 2)
    blind = ghost.copy()
    blind[[15, 16]] = blind[[16, 15]]  # turned away: no facing pair of eyes
    _, people = _pair([_box(ONE)], [blind, ONE], surplus=True)
    assert len(people) == 2, "without surplus eyes it drops nobody"


def test_the_published_grouping_shows_a_person_twice() -> None:
    boxes = [(0, 0, 10, 10), (5, 20, 12, 30), (8, 5, 20, 25)]
    assert len(_pair(boxes, [])[0].pose.crops) == 1
    assert len(_pair(boxes, [], grouping=True)[0].pose.crops) == 2


@needs_models
def test_real_files_all_the_way(tmp_path: Path) -> None:
    """Real Darknet weights and the real BODY_25 description: boxes are found, generated weights see no joints."""
    prototxt = MODELS / "body_25_pose_deploy.prototxt"
    weights = caffe_weights(prototxt, tmp_path / "pose_iter_584000.caffemodel", {})
    detector = DarknetDetector(
        MODELS / "yolo-fastest-1.1_body.cfg", MODELS / "yolo-fastest-1.1_body.weights", size=(320, 320)
    )
    backend = YoloOpenPose(detector, Body25(prototxt, weights, net_height=48))
    people = backend.detect(Photo.open(PHOTOS / "COCO_val2014_000000000241.jpg"))
    assert len(people) == 0
    assert set(backend.models) == {
        "yolo-fastest-1.1_body.cfg", "yolo-fastest-1.1_body.weights", "body_25_pose_deploy.prototxt",
        "pose_iter_584000.caffemodel",
    }  # fmt: skip
