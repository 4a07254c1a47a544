"""What every pose back end promises. A new one needs a row in `pose.BACKENDS` and nothing here.

A back end whose networks are not on this machine is skipped by name; the embedded one's are fetched.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from proxemetry import weights
from proxemetry.errors import ModelError
from proxemetry.people import People, PoseBackend
from proxemetry.people.doubts import doubts_of
from proxemetry.photo import Photo
from proxemetry.pose import BACKENDS, PoseOptions, backend_named, is_available
from proxemetry.pose.rivals import LEAST_RATIO
from synthetic.dotted_world import HEADS, ONE_STAGE, PEOPLE, PHOTO_SIZE, specification
from synthetic.network_files import dots

SHARED = Path(__file__).resolve().parents[2] / "shared"
PHOTOS = SHARED / "data" / "photos"

#: Back ends that replay or wrap what someone else found: tested on their own.
OF_OTHERS = ("recorded", "python", "onnx", "cross-check")
NAMES = [name for name in BACKENDS if name not in OF_OTHERS]
#: Back ends of generated networks, one for each decoder: on every machine the contract is tested on something.
GENERATED_NAME = "spec"
GENERATED = [f"generated {head}" for head in (*HEADS, *ONE_STAGE)]


@pytest.fixture(scope="module", autouse=True)
def caches() -> Iterator[None]:
    """Search the folder of models beside the checkout too, where there is one."""
    patch = pytest.MonkeyPatch()
    folders = [str(folder) for folder in weights.cache_folders()]
    patch.setenv("PROXEMETRY_CACHE", os.pathsep.join([*folders, str(SHARED / "models")]))
    yield
    patch.undo()


@pytest.fixture(scope="module", params=[*GENERATED, *NAMES])
def backend(request: pytest.FixtureRequest, caches: None, tmp_path_factory: pytest.TempPathFactory) -> PoseBackend:
    if request.param in GENERATED:
        pytest.importorskip("onnxruntime")
        folder = tmp_path_factory.mktemp("networks")
        return backend_named(f"onnx:{specification(folder, request.param.removeprefix('generated '))}")
    if request.param == "blazepose":
        try:
            weights.fetch((*weights.EMBEDDED, weights.EMBEDDED_FINDER))
        except ModelError as error:
            pytest.skip(f"blazepose: {error}")
    if not is_available(request.param):
        pytest.skip(f"{request.param}: its networks or its runtime are not on this machine")
    return backend_named(request.param, PoseOptions(offline=True, effort="fast"))


@pytest.fixture(scope="module")
def street(backend: PoseBackend) -> np.ndarray:
    """A photo of several people, small enough to be quick: a real one, or one of the generated networks' own world."""
    if backend.name == GENERATED_NAME:
        return dots(PHOTO_SIZE, PEOPLE)
    path = PHOTOS / "COCO_val2014_000000000241.jpg"
    if not path.is_file():
        pytest.skip("the labelled photos are not beside this checkout")
    return Photo.open(path).pixels()


def _empty_pictures() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(7)
    height, width = 360, 480
    rows = np.linspace(0, 1, height)[:, None, None]
    sky, meadow = np.array([120, 170, 230]), np.array([60, 120, 40])
    landscape = np.where(rows < 0.45, sky + 60 * rows, meadow + rng.normal(0, 18, (height, width, 1)))
    coarse = rng.integers(0, 256, (9, 12, 3)).repeat(40, axis=0).repeat(40, axis=1)
    return {
        "black": np.zeros((height, width, 3), np.uint8),
        "white": np.full((height, width, 3), 255, np.uint8),
        "landscape": np.clip(np.broadcast_to(landscape, (height, width, 3)), 0, 255).astype(np.uint8),
        "noise": rng.integers(0, 256, (height, width, 3)).astype(np.uint8),
        "blocks": coarse.astype(np.uint8),
    }


@pytest.mark.parametrize("kind", _empty_pictures())
def test_nobody_where_nobody_is(backend: PoseBackend, kind: str) -> None:
    assert len(backend.detect(Photo.from_array(_empty_pictures()[kind]))) == 0


@pytest.mark.parametrize("size", [(1, 1), (3, 400), (400, 3), (40, 40)])
def test_any_size_of_picture_is_taken(backend: PoseBackend, size: tuple[int, int]) -> None:
    people = backend.detect(Photo.from_array(np.full((*size, 3), 128, np.uint8)))
    assert len(people) == 0


def test_it_says_what_it_is(backend: PoseBackend) -> None:
    assert backend.name == GENERATED_NAME or backend.name.split(":")[0] in BACKENDS
    assert len(backend.skeleton) >= 15
    for name, sha256 in backend.models.items():
        assert backend.name == GENERATED_NAME or weights.model_named(name).name == name
        assert len(sha256) == 64


def test_what_else_a_detector_sees_goes_with_each_person(backend: PoseBackend, street: np.ndarray) -> None:
    people = backend.detect(Photo.from_array(street))
    assert len(people.rivals) == len(people) > 0
    for rival in people.rivals:
        assert rival is None or (rival.name not in ("", "person") and rival.ratio >= LEAST_RATIO)
    assert len(doubts_of(people)) == len(people)


def test_people_are_in_pixels_of_the_photo_with_scores(backend: PoseBackend, street: np.ndarray) -> None:
    before = street.copy()
    people = backend.detect(Photo.from_array(street))
    assert np.array_equal(street, before)
    assert people.skeleton is backend.skeleton
    assert people.source in ("", backend.name)
    assert len(people) >= 2
    height, width = street.shape[:2]
    seen = np.isfinite(people.keypoints_px).all(axis=-1)
    assert np.array_equal(seen, people.scores > 0)
    assert people.scores.max() <= 1
    assert ((people.person_scores > 0) & (people.person_scores <= 1)).all()
    assert (people.keypoints_px[seen] >= 0).all(), "a joint outside the picture was not seen"
    assert (people.keypoints_px[seen] <= (width, height)).all()
    assert (people.boxes_px[:, :2] < people.boxes_px[:, 2:]).all()


def test_the_same_photo_gives_the_same_people(backend: PoseBackend, street: np.ndarray) -> None:
    first, second = (backend.detect(Photo.from_array(street)) for _ in range(2))
    assert np.array_equal(first.keypoints_px, second.keypoints_px, equal_nan=True)
    assert np.array_equal(first.scores, second.scores)


def test_a_larger_copy_gives_the_same_people_larger(backend: PoseBackend, street: np.ndarray) -> None:
    small = backend.detect(Photo.from_array(street))
    large = backend.detect(Photo.from_array(street.repeat(2, axis=0).repeat(2, axis=1)))
    _assert_same_torsos(small.scaled(2, 2), large)


def test_a_mirrored_photo_gives_the_mirrored_people(backend: PoseBackend, street: np.ndarray) -> None:
    people = backend.detect(Photo.from_array(street))
    mirrored = backend.detect(Photo.from_array(np.ascontiguousarray(street[:, ::-1])))
    _assert_same_torsos(people.mirrored(street.shape[1]), mirrored)


def _assert_same_torsos(expected: People, found: People) -> None:
    """Everyone whose torso one sees is where the other sees it, within a quarter of its length."""
    neck, hip = expected.joint("neck"), expected.joint("mid_hip")
    length = np.linalg.norm(neck - hip, axis=1)
    whole = np.isfinite(length) & (expected.person_scores > 0.5)
    assert whole.any()
    torsos = np.nan_to_num(found.part("Torso"), nan=np.inf)
    for centre, tolerance in zip(((neck + hip) / 2)[whole], length[whole] / 4, strict=True):
        assert np.linalg.norm(torsos - centre, axis=1).min() < tolerance
