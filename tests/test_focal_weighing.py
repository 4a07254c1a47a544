"""Files as they are: cameras, editors and firmware write false things, and the interval still holds the truth.

Every expected focal length is arithmetic beside it: millimetres, times the pixels of the whole picture, over the width
of the sensor.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_photo_metadata import xmp_of

from proxemetry.camera import Camera, CameraEstimate, Candidate, Doubt, FocalSource, Source
from proxemetry.camera.choice import choose_camera
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.perspective import is_strip, projection_of
from proxemetry.camera.sensors import SENSORS, sensor_of, sensors_of_pixels
from proxemetry.camera.weighing import agree
from proxemetry.people import People
from proxemetry.people.skeleton import COCO_17
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Crop, Metadata, Projection
from synthetic.camera_files import (
    FOCAL,
    FOCAL_35,
    MAKE,
    MODEL,
    PLANE_UNIT,
    PLANE_X,
    RENDERED,
    SOFTWARE,
    STORED_HEIGHT,
    STORED_WIDTH,
    write,
)

DIAGONAL = math.hypot(36, 24)
CANON = {MAKE: "Canon", MODEL: "Canon EOS 5D Mark III"}
WRONG = {MAKE: "Canon", MODEL: "Canon EOS 6D Mark II"}


def plane(px_per_mm: float) -> dict[int, object]:
    """Return the tags of a focal plane resolution in pixels an inch."""
    return {PLANE_X: (round(px_per_mm * 25.4 * 1000), 1000), PLANE_UNIT: 2}


def stored(width: int, height: int) -> dict[int, object]:
    return {STORED_WIDTH: width, STORED_HEIGHT: height}


def estimate_of(tmp_path: Path, width: int, height: int, tags: dict[int, object], **options: object) -> CameraEstimate:
    return estimate_camera(Photo.open(write(tmp_path / "photo.jpg", width, height, tags, **options)))


def holds(camera: Camera, f_px: float) -> bool:
    return abs(math.log(f_px / camera.f_px)) <= 1.645 * camera.focal_rel_sd


def half_width(camera: Camera) -> float:
    """Return half the width of the 90 % interval, as a factor above 1."""
    return math.exp(1.645 * camera.focal_rel_sd)


# name: size of the file, its tags, the true focal length in pixels, widest factor of the interval, source
FILES: dict[str, tuple[tuple[int, int], dict[int, object], float, float, FocalSource]] = {
    "resized, stored size renewed, camera known": (
        (1920, 1280), {FOCAL: (50, 1), **CANON, **plane(160), **stored(1920, 1280)},
        50 / 36 * 1920, 1.1, FocalSource.CROP_FACTOR,
    ),
    "resized, stored size renewed, equivalent known": (
        (1600, 1200), {FOCAL: (20, 1), FOCAL_35: 97, **plane(380), **stored(1600, 1200)},
        97 * 2000 / DIAGONAL, 1.1, FocalSource.EQUIVALENT,
    ),
    "resized, nothing else known": (
        (1024, 768), {FOCAL: (218, 10), **plane(370.4), **stored(1024, 768)},
        21.8 * 1024 / 7.6, 2.3, FocalSource.FOCAL_PLANE,
    ),
    "resized from 35 mm film size, nothing else known": (
        (1200, 800), {FOCAL: (50, 1), MAKE: "Acme", MODEL: "One", **plane(160), **stored(1200, 800)},
        50 * 1200 / 36, 2.1, FocalSource.FOCAL_PLANE,
    ),
    "resized, stored size kept": (
        (1500, 1000), {FOCAL: (50, 1), **CANON, **plane(160), **stored(5760, 3840)},
        50 / 36 * 1500, 1.05, FocalSource.FOCAL_PLANE,
    ),
    "wrong resolution, straight from the camera": (
        (6240, 4160), {FOCAL: (35, 1), **WRONG, **plane(263), **stored(6240, 4160)},
        35 / 35.9 * 6240, 1.1, FocalSource.CROP_FACTOR,
    ),
    "wrong resolution, made smaller since": (
        (1560, 1040), {FOCAL: (35, 1), **WRONG, **plane(263), **stored(6240, 4160)},
        35 / 35.9 * 1560, 1.1, FocalSource.CROP_FACTOR,
    ),
    "the preview's resolution": (
        (4896, 3264), {FOCAL: (25, 1), FOCAL_35: 38, MAKE: "FUJIFILM", MODEL: "X-M1", **plane(82)},
        25 / 23.6 * 4896, 1.1, FocalSource.EQUIVALENT,
    ),
    "the preview's resolution, equivalent stripped": (
        (4896, 3264), {FOCAL: (25, 1), MAKE: "FUJIFILM", MODEL: "X-M1", **plane(82)},
        25 / 23.6 * 4896, 1.1, FocalSource.CROP_FACTOR,
    ),
    "part of the sensor used, by the equivalent": (
        (4800, 3200), {FOCAL: (50, 1), FOCAL_35: 75, MAKE: "NIKON CORPORATION", MODEL: "NIKON D810"},
        75 / 36 * 4800, 1.1, FocalSource.EQUIVALENT,
    ),
    "part of the sensor used, by the resolution": (
        (5088, 3392), {FOCAL: (50, 1), MAKE: "Canon", MODEL: "Canon EOS R5", **plane(228), **stored(5088, 3392)},
        50 * 228, 2.0, FocalSource.FOCAL_PLANE,
    ),
    "the equivalent repeats the millimetres": (
        (5184, 3456), {FOCAL: (50, 1), FOCAL_35: 50, MAKE: "Canon", MODEL: "Canon EOS 600D"},
        50 / 22.3 * 5184, 1.1, FocalSource.CROP_FACTOR,
    ),
    "cropped a little to the same shape": (
        (4800, 3200), {FOCAL: (50, 1), **CANON, **plane(160), **stored(4800, 3200)},
        50 * 160, 1.4, FocalSource.CROP_FACTOR,
    ),
    "cropped to another shape and made smaller": (
        (2000, 1600), {FOCAL: (50, 1), FOCAL_35: 50, **plane(6000 / 36), **stored(2000, 1600)},
        50 / 24 * 1600, 4.0, FocalSource.FOCAL_PLANE,
    ),
    "cropped to another shape, nothing else known": (
        (2000, 1600), {FOCAL: (50, 1), **plane(6000 / 36), **stored(2000, 1600)},
        50 / 24 * 1600, 4.5, FocalSource.FOCAL_PLANE,  # 12 mm of it are left: sensors go up to 54 mm
    ),
    "a camera listed once a shape": (
        (3648, 2736), {FOCAL: (51, 10), MAKE: "Panasonic", MODEL: "DMC-LX3"},
        5.1 * 4.7 * 4560 / DIAGONAL, 1.1, FocalSource.CROP_FACTOR,
    ),
    "the same camera's long shape": (
        (3968, 2232), {FOCAL: (51, 10), MAKE: "Panasonic", MODEL: "DMC-LX3"},
        5.1 * 5.753 * math.hypot(3968, 2232) / DIAGONAL, 1.15, FocalSource.CROP_FACTOR,
    ),
    "edited, and the resolution fits a sensor by chance": (
        (3900, 2600), {FOCAL: (50, 1), **plane(166.7), **stored(3900, 2600), SOFTWARE: "Adobe Photoshop CC"},
        50 / 36 * 3900, 2.0, FocalSource.FOCAL_PLANE,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_the_interval_holds_the_truth_and_is_no_wider_than_need_be(name: str, tmp_path: Path) -> None:
    (width, height), tags, truth, widest, kind = FILES[name]
    estimate = estimate_of(tmp_path, width, height, tags)
    camera = estimate.camera
    assert camera is not None and estimate.source is not None and estimate.source.kind is kind
    assert holds(camera, truth), f"{camera.f_px:.0f} px within a factor of {half_width(camera):.2f}, not {truth:.0f}"
    assert half_width(camera) <= widest
    assert estimate.why


def test_the_optical_centre_of_a_crop_is_as_unsure_as_what_was_cut_away(tmp_path: Path) -> None:
    """Cut anywhere out of the whole, a picture's middle is off by as much as the two differ in size."""
    sd = []
    for width in (4800, 5184):  # of 5760 pixels: a sixth and a tenth are gone
        tags = {FOCAL: (50, 1), **CANON, **plane(160), **stored(width, width * 2 // 3)}
        camera = estimate_of(tmp_path, width, width * 2 // 3, tags).camera
        assert camera is not None
        sd.append(camera.principal_sd_px)
    assert sd[0] / sd[1] == pytest.approx((5760 - 4800) / (5760 - 5184), rel=0.05)
    assert 0 < sd[0] <= (5760 - 4800) / math.sqrt(12)


def test_a_full_frame_canon_with_a_wrong_resolution_is_no_crop(tmp_path: Path) -> None:
    """Straight out of the camera: what it writes would be an APS-C sensor."""
    (width, height), tags, *_ = FILES["wrong resolution, straight from the camera"]
    estimate = estimate_of(tmp_path, width, height, tags)
    assert estimate.camera is not None and estimate.camera.principal_sd_px == 0
    assert [flag.doubt for flag in estimate.flags] == [Doubt.CONTRADICTED]


def test_no_lens_sees_so_wide(tmp_path: Path) -> None:
    """A phone's resolution would make its 3.8 mm lens an equivalent of 8 mm, seen across 132 degrees."""
    tags = {FOCAL: (382, 100), MAKE: "HTC", MODEL: "HTC One", **plane(155.7), **stored(2688, 1520)}
    assert estimate_of(tmp_path, 2688, 1520, tags).camera is None
    with_tag = estimate_of(tmp_path, 2688, 1520, {**tags, FOCAL_35: 27}).camera
    assert with_tag is not None and holds(with_tag, 27 * math.hypot(2688, 1520) / DIAGONAL)


def test_a_recorded_crop_tells_the_part_and_not_the_size() -> None:
    """0.7 of a picture of 5184 px, then made smaller to 1500: the whole would be 2143 px wide."""
    metadata = {
        "focal_mm": 50.0,
        "focal_plane_px_per_mm": 225.5,
        "cropped": True,
        "crop": Crop(0.1, 0.1, 0.8, 0.8, 0.0),
    }
    truth = 50 * 225.5 * 1500 / (0.7 * 5184)
    body = Metadata(make="Canon", model="Canon EOS 600D", **metadata)  # type: ignore[arg-type]
    known = estimate_camera(Photo("a.jpg", 1500, 1000, "", body)).camera
    assert known is not None and holds(known, truth) and half_width(known) < 1.1
    unknown = estimate_camera(Photo("a.jpg", 1500, 1000, "", Metadata(**metadata))).camera  # type: ignore[arg-type]
    assert unknown is not None and holds(unknown, truth) and half_width(unknown) > 1.2
    at_full_size = estimate_camera(Photo("a.jpg", 3629, 2419, "", body)).camera
    assert at_full_size is not None and at_full_size.f_px == pytest.approx(50 * 225.5)


def test_one_name_for_cameras_of_several_sensors_holds_them_all(tmp_path: Path) -> None:
    tags = {FOCAL: (8, 1), MAKE: "SONY", MODEL: "CYBERSHOT"}
    camera = estimate_of(tmp_path, 2048, 1536, tags).camera
    if camera is not None:  # the lenses that lensfun knows may all be longer
        assert all(holds(camera, 8 * factor * 2560 / DIAGONAL) for factor in (3.933, 4.843))
    longer = estimate_of(tmp_path, 2048, 1536, {**tags, FOCAL: (14, 1)}).camera
    assert longer is not None
    assert all(holds(longer, 14 * factor * 2560 / DIAGONAL) for factor in (3.933, 4.843))


@pytest.mark.parametrize(("make", "expected"), [("Apple", 77), ("Google", 3 * 77)])
def test_makers_differ_in_counting_the_digital_zoom(make: str, expected: float) -> None:
    photo = Photo("a.jpg", 4032, 3024, "", Metadata(make=make, focal_35mm=77.0, digital_zoom=3.0))
    camera = estimate_camera(photo).camera
    assert camera is not None and camera.f_px == pytest.approx(expected * 5040 / DIAGONAL)
    assert half_width(camera) < 1.1
    unknown = estimate_camera(Photo("a.jpg", 4032, 3024, "", Metadata(make="Acme", focal_35mm=77.0, digital_zoom=3.0)))
    assert unknown.camera is not None and all(holds(unknown.camera, mm * 5040 / DIAGONAL) for mm in (77, 231))


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([s for s in SENSORS if s.width_mm >= 13]), st.floats(0.1, 1.0), st.floats(0.05, 1.0),
    st.floats(14, 300), st.booleans(),
)  # fmt: skip
def test_made_smaller_with_all_sizes_renewed_is_never_a_narrow_wrong_answer(
    sensor: object, density: float, scale: float, equivalent: float, tagged: bool
) -> None:
    """Whatever the sensor and the factor: the truth is in the interval, or there is no answer."""
    from proxemetry.camera.sensors import Sensor

    assert isinstance(sensor, Sensor)
    pixels = sensor.fewest_px * (sensor.most_px / sensor.fewest_px) ** density
    width = round(pixels * scale)
    height = round(width * sensor.height_mm / sensor.width_mm)
    focal_mm = equivalent * math.hypot(sensor.width_mm, sensor.height_mm) / DIAGONAL
    metadata = Metadata(
        focal_mm=focal_mm, focal_plane_px_per_mm=pixels / sensor.width_mm, edited_by="an editor",
        focal_35mm=equivalent if tagged else None, stored_width_px=width, stored_height_px=height,
    )  # fmt: skip
    estimate = estimate_camera(Photo("a.jpg", width, height, "", metadata))
    truth = focal_mm / sensor.width_mm * width
    if estimate.camera is not None and sensor.width_mm <= 36.5:  # medium format is left out of what is likely
        low, high = (truth / 1.06, truth * 1.06)
        assert any(holds(estimate.camera, f_px) for f_px in (low, truth, high))


#: Compact cameras that no database names: sensor's width and pixels along the long side, by their makers' data sheets.
COMPACTS = ((5.75, 3264), (6.17, 3648), (6.17, 4608), (6.17, 5152), (7.18, 3648), (7.5, 4416), (8.8, 4000))


def of_compact(width_mm: float, pixels: int, long_side: int) -> tuple[Camera, float]:
    """Return the camera found of a file with all its sizes renewed, and the truth: a 6 mm lens."""
    height = round(long_side * 0.75)
    metadata = Metadata(
        make="Acme", model="Snap 9", focal_mm=6.0, focal_plane_px_per_mm=pixels / width_mm, date="2012-05-01",
        stored_width_px=long_side, stored_height_px=height,
    )  # fmt: skip
    camera = estimate_camera(Photo("a.jpg", long_side, height, "", metadata)).camera
    assert camera is not None
    return camera, 6.0 * long_side / width_mm


@pytest.mark.parametrize("width_mm, pixels", COMPACTS)
@pytest.mark.parametrize("long_side", [800, 1600, 2000, 3000, 3500, 3840])
def test_a_compact_cameras_photo_made_smaller_holds_its_truth(width_mm: float, pixels: int, long_side: int) -> None:
    if long_side < pixels:
        camera, truth = of_compact(width_mm, pixels, long_side)
        assert holds(camera, truth)


@pytest.mark.parametrize("width_mm, pixels", COMPACTS)
def test_a_compact_cameras_whole_photo_is_right_and_mostly_narrow(width_mm: float, pixels: int) -> None:
    camera, truth = of_compact(width_mm, pixels, pixels)
    assert camera.f_px == pytest.approx(truth)
    # 3264 and 4000 are what photos are made smaller to, too
    assert half_width(camera) < (1.36 if pixels in (3264, 4000) else 1.04)


def test_sensors() -> None:
    full = sensor_of((36.0, 24.0), (6000, 4000))
    assert full is not None and full.name == "35 mm"
    assert sensor_of((24.0, 36.0), (4000, 6000)) == full  # held upright
    assert sensor_of((36.0, 20.25), (6000, 3375)) == full  # 16:9 keeps the width
    assert sensor_of((24.0, 24.0), (4000, 4000)) == full  # and a square the height
    assert sensor_of((12.0, 8.0), (1920, 1280)) is None
    assert sensor_of((2.76, 2.07), (1024, 768)) is None
    assert sensor_of((23.6, 15.7), (1000, 667)) is None  # nobody put so few pixels on it
    assert {s.name for s in sensors_of_pixels(6000 / 36, 20)} >= {"35 mm", "APS-C"}


NOT_ONE_PERSPECTIVE = {
    "sphere by its packet": ((4000, 2000), {}, 'GPano:ProjectionType="equirectangular"', Projection.SPHERE),
    "sphere by its camera": ((5376, 2688), {MAKE: "RICOH", MODEL: "RICOH THETA S"}, "", Projection.SPHERE),
    "swept by a phone": ((9000, 3000), {FOCAL_35: 26, RENDERED: 6}, "", Projection.PANORAMA),
    "cylinder by its packet": ((9000, 3000), {FOCAL_35: 26}, 'GPano:ProjectionType="cylindrical"', Projection.PANORAMA),
}


@pytest.mark.parametrize("name", NOT_ONE_PERSPECTIVE)
def test_what_is_not_one_perspective_has_no_focal_length(name: str, tmp_path: Path) -> None:
    size, tags, said, projection = NOT_ONE_PERSPECTIVE[name]
    path = write(tmp_path / "a.jpg", *size, tags, **({"xmp": xmp_of("", said)} if said else {}))
    for request in (None, FocalRequest(assume_fov_deg=60), FocalRequest(focal_35mm=28)):
        estimate = estimate_camera(Photo.open(path), request)
        assert estimate.camera is None and not estimate.may_be_guessed
        assert str(projection) in (estimate.reason or "")


def test_a_strip_is_marked_and_a_portrait_mode_is_not() -> None:
    strip = estimate_camera(Photo("a.jpg", 8000, 2000, "", Metadata(focal_35mm=28.0)))
    assert any(flag.doubt is Doubt.PROJECTION for flag in strip.flags)
    bare = choose_camera(Photo("a.jpg", 640, 218, ""), People.none(COCO_17), FocalRequest(), None, None)
    assert bare.is_assumed and any(flag.doubt is Doubt.PROJECTION for flag in bare.flags)
    portrait = estimate_camera(Photo("a.jpg", 4032, 3024, "", Metadata(focal_35mm=52.0)))
    assert not portrait.flags


@pytest.mark.parametrize(
    ("size", "model", "sphere"),
    [
        ((5376, 2688), "RICOH THETA V", True), ((5376, 2690), "RICOH THETA V", True),
        ((2688, 5376), "RICOH THETA V", False),
        ((5376, 3000), "RICOH THETA V", False), ((5376, 2688), "Canon EOS R5", False), ((4032, 3024), "SM-R210", False),
        ((4096, 2048), "SM-C200", True),
    ],
)  # fmt: skip
def test_a_sphere_cameras_picture_is_twice_as_wide_as_high(size: tuple[int, int], model: str, sphere: bool) -> None:
    found = projection_of(Photo("a.jpg", *size, "", Metadata(model=model)))
    assert found is (Projection.SPHERE if sphere else None)
    said = Metadata(model=model, projection=Projection.PANORAMA)
    assert projection_of(Photo("a.jpg", *size, "", said)) is Projection.PANORAMA


@pytest.mark.parametrize("turned", [False, True])
def test_a_strip_is_longer_than_any_cinema_format(turned: bool) -> None:
    for long_side, strip in ((2590, False), (2610, True)):
        assert is_strip(*((1000, long_side) if turned else (long_side, 1000))) == strip


@pytest.mark.parametrize(
    "said",
    [
        {"lens": "LUMIX G FISHEYE 8/F3.5", "focal_35mm": 16.0}, {"lens": "Samyang Fish-Eye 8mm", "focal_35mm": 12.0},
        {"make": "GoPro", "model": "HERO7 Black", "focal_35mm": 15.0}, {"make": "GoPro", "focal_35mm": 17.0},
        {"make": "Canon", "model": "Canon EOS 6D", "focal_mm": 8.0, "lens": "EF8-15mm f/4L"},
    ],
)  # fmt: skip
def test_fisheyes_are_named(said: dict[str, object]) -> None:
    estimate = estimate_camera(Photo("a.jpg", 4000, 3000, "", Metadata(**said)))  # type: ignore[arg-type]
    assert any(flag.doubt is Doubt.LENS and "fisheye" in flag.text for flag in estimate.flags)


@pytest.mark.parametrize("equivalent", [1, 4, 8])
def test_an_equivalent_that_no_lens_has_is_unusable(equivalent: int, tmp_path: Path) -> None:
    estimate = estimate_of(tmp_path, 4160, 3120, {FOCAL: (equivalent, 1), FOCAL_35: equivalent, MODEL: "Box"})
    assert estimate.camera is None
    assert any(f"35 mm equivalent {equivalent} in the metadata is unusable" in flag.text for flag in estimate.flags)
    assert estimate_of(tmp_path, 4160, 3120, {FOCAL_35: 9}).camera is not None


@pytest.mark.parametrize(("apart", "both_right"), [(0.27, True), (0.29, False)])
def test_answers_agree_within_two_standard_deviations_of_their_difference(apart, both_right):
    one, other = (Candidate(f_px, 0.1, Source(FocalSource.EQUIVALENT)) for f_px in (1000.0, 1000.0 * math.exp(apart)))
    assert agree(one, other) == agree(other, one) == both_right
