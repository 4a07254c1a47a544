"""Every photo gets the right camera: the expected focal length in pixels is arithmetic in the table."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image
from test_photo_metadata import xmp_of

from proxemetry.camera import Camera
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.frame import frame_of
from proxemetry.camera.lens import _fit, _signature
from proxemetry.errors import SettingsError
from proxemetry.intervals import HALF_WIDTH_SD
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Crop, Metadata
from synthetic.camera_files import (
    F_NUMBER,
    FOCAL,
    FOCAL_35,
    LENS,
    MAKE,
    MODEL,
    ORIENTATION,
    PLANE_UNIT,
    PLANE_X,
    STORED_HEIGHT,
    STORED_WIDTH,
    ZOOM,
    write,
)  # fmt: skip

DIAGONAL = math.hypot(36, 24)
#: A 36 mm wide sensor of 6000 pixels, in pixels per inch.
FULL_FRAME = {PLANE_X: (60000000, 14173), PLANE_UNIT: 2}
assert abs(60000000 / 14173 / 25.4 - 6000 / 36) < 0.01
STORED_6000 = {STORED_WIDTH: 6000, STORED_HEIGHT: 4000}

# name: (width, height of the file), tags, expected f_px, words that the source or a flag must hold
SITUATIONS = {
    "full frame": ((6000, 4000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000}, 50 * 6000 / 36, "focal plane"),
    "APS-C by crop factor": (
        (5184, 3456), {FOCAL: (18, 1), MAKE: "Canon", MODEL: "Canon EOS 600D"},
        18 * 1.613 * math.hypot(5184, 3456) / DIAGONAL, "crop factor",
    ),
    "4:3 by equivalent": (
        (4000, 3000), {FOCAL: (14, 1), FOCAL_35: 28}, 28 * 5000 / DIAGONAL, "35 mm equivalent",
    ),
    "phone": (
        (4032, 3024), {FOCAL: (425, 100), FOCAL_35: 26, MAKE: "Apple", MODEL: "iPhone 12"},
        26 * 5040 / DIAGONAL, "35 mm equivalent",
    ),
    "resized": ((1500, 1000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000}, 50 * 1500 / 36, "focal plane"),
    "cropped, stored size kept": (
        (3000, 4000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000}, 50 * 6000 / 36, "cropped",
    ),
    "cropped, stored size rewritten": (
        (2000, 1600), {FOCAL: (50, 1), FOCAL_35: 50, **FULL_FRAME, STORED_WIDTH: 2000, STORED_HEIGHT: 1600},
        50 * 6000 / 36, "cropped",
    ),
    "portrait": (
        (4000, 6000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000}, 50 * 6000 / 36, "focal plane",
    ),
    "portrait by orientation": (
        (6000, 4000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000, ORIENTATION: 6}, 50 * 6000 / 36, "focal plane",
    ),
    "digital zoom": (
        (6000, 4000), {FOCAL: (50, 1), **FULL_FRAME, **STORED_6000, ZOOM: (2, 1)}, 2 * 50 * 6000 / 36, "digital zoom",
    ),
    "no EXIF": ((6000, 4000), {}, None, "no focal length in the photo"),
    "rational focal length": (
        (6000, 4000), {FOCAL: (425, 10), **FULL_FRAME, **STORED_6000}, 42.5 * 6000 / 36, "focal plane",
    ),
    "zero focal length": ((6000, 4000), {FOCAL: (0, 1), **FULL_FRAME}, None, "focal length 0 in the metadata"),
    "focal length 0/0": ((6000, 4000), {FOCAL: (0, 0), **FULL_FRAME}, None, "focal length 0/0 in the metadata"),
    "focal length 65535": ((6000, 4000), {FOCAL: (65535, 1), FOCAL_35: 65535}, None, "65535 in the metadata"),
    "sensor unknown": (
        (6000, 4000), {FOCAL: (50, 1), MAKE: "Acme", MODEL: "Box 1"}, None, "sensor size of Box 1 is unknown",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SITUATIONS)
def test_situation(name: str, tmp_path: Path) -> None:
    (width, height), tags, expected, words = SITUATIONS[name]
    estimate = estimate_camera(Photo.open(write(tmp_path / "photo.jpg", width, height, tags)))
    said = " | ".join((*map(str, estimate.flags), estimate.reason or "", str(estimate.source)))
    assert words in said
    if expected is None:
        assert estimate.camera is None and estimate.reason
    else:
        assert estimate.camera is not None
        assert estimate.camera.f_px == pytest.approx(expected, rel=1e-3)
        assert estimate.camera.focal_rel_sd > 0


def photo_of(width: int = 6000, height: int = 4000, **metadata: object) -> Photo:
    """Return a photo without pixels."""
    return Photo("photo.jpg", width, height, "", Metadata(**metadata))  # type: ignore[arg-type]


def camera_of(photo: Photo, request: FocalRequest | None = None) -> Camera:
    camera = estimate_camera(photo, request).camera
    assert camera is not None
    return camera


def test_the_users_word_comes_first_and_all_candidates_are_kept() -> None:
    photo = photo_of(
        focal_mm=50.0, focal_35mm=50.0, focal_plane_px_per_mm=6000 / 36, model="Canon EOS 6D", make="Canon"
    )
    estimate = estimate_camera(photo, FocalRequest(focal_px=9000, assume_fov_deg=60))
    assert estimate.camera is not None and estimate.camera.f_px == 9000
    sources = [str(candidate.source).split(":")[0].split(" of ")[0] for candidate in estimate.candidates]
    assert sources == [
        "user", "EXIF focal length and focal plane resolution", "EXIF 35 mm equivalent",
        "EXIF focal length and crop factor 1.005", "ASSUMED",
    ]  # fmt: skip
    assert any("8333 px" in flag.text for flag in estimate.flags)


@pytest.mark.parametrize(
    ("size", "sensor", "expected"),
    [
        ((6000, 4000), (36, 24), 50 * 6000 / 36),
        ((4000, 6000), (36, 24), 50 * 6000 / 36),
        ((4000, 6000), (24, 36), 50 * 6000 / 36),
        ((6000, 3375), (36, 24), 50 * 6000 / 36),  # 16:9 out of 3:2 keeps the width
        ((4000, 4000), (36, 24), 50 * 4000 / 24),  # and a square keeps the height
    ],
)
def test_sensor_sides_follow_the_photo(size: tuple[int, int], sensor: tuple[float, float], expected: float) -> None:
    assert camera_of(photo_of(*size, focal_mm=50.0), FocalRequest(sensor_mm=sensor)).f_px == pytest.approx(expected)
    assert camera_of(photo_of(*size), FocalRequest(focal_mm=50.0, sensor_mm=sensor)).f_px == pytest.approx(expected)


def test_a_photo_of_another_shape_than_the_sensor_is_as_unsure_as_its_sides_disagree() -> None:
    """16:9 out of 3:2 is the width's answer; by the height it would be 32 / 27 of it, and half of that is one sd."""
    whole = camera_of(photo_of(6000, 4000, focal_mm=50.0), FocalRequest(sensor_mm=(36, 24)))
    cut = camera_of(photo_of(6000, 3375, focal_mm=50.0), FocalRequest(sensor_mm=(36, 24)))
    apart = math.sqrt(cut.focal_rel_sd**2 - whole.focal_rel_sd**2)
    assert apart == pytest.approx(math.log(32 / 27) / 2, abs=0.03)
    assert math.exp(2 * apart) == pytest.approx(32 / 27, rel=0.05)


def test_assumptions_are_marked_and_come_last() -> None:
    camera = camera_of(photo_of(), FocalRequest(assume_fov_deg=60))
    assert camera.f_px == pytest.approx(3000 / math.tan(math.radians(30)))
    assert camera.source.is_assumed and str(camera.source).startswith("ASSUMED") and camera.focal_rel_sd >= 0.2
    upright = camera_of(photo_of(4000, 6000), FocalRequest(assume_fov_deg=60))
    assert upright.f_px == pytest.approx(camera.f_px)  # the same lens, held upright
    assert camera_of(photo_of(), FocalRequest(focal_35mm=28)).source.is_assumed
    assert not camera_of(photo_of(focal_35mm=28.0), FocalRequest(assume_fov_deg=60)).source.is_assumed


def test_disagreement_is_flagged_and_widens_the_interval_to_hold_both() -> None:
    agreed = estimate_camera(photo_of(focal_mm=50.0, focal_plane_px_per_mm=6000 / 36, focal_35mm=51.0))
    torn = estimate_camera(photo_of(focal_mm=50.0, focal_plane_px_per_mm=6000 / 36, focal_35mm=75.0))
    assert agreed.camera is not None and torn.camera is not None
    assert not agreed.flags and agreed.camera.focal_rel_sd == 0.02
    assert any("8333 px" in flag.text and "35 mm equivalent 12500 px" in flag.text for flag in torn.flags)
    assert math.exp(1.645 * torn.camera.focal_rel_sd) >= 75 / 50


def test_stated_focal_length_without_a_sensor_uses_the_cameras_own() -> None:
    assert camera_of(photo_of(focal_plane_px_per_mm=6000 / 36), FocalRequest(focal_mm=85)).f_px == pytest.approx(
        85 * 6000 / 36
    )
    assert camera_of(photo_of(focal_mm=10.0, focal_35mm=20.0), FocalRequest(focal_mm=30)).f_px == pytest.approx(
        60 * math.hypot(6000, 4000) / DIAGONAL
    )
    estimate = estimate_camera(photo_of(focal_35mm=20.0), FocalRequest(focal_mm=30))
    assert estimate.camera is None and "--sensor-mm" in (estimate.reason or "")


@pytest.mark.parametrize(
    "wrong",
    [
        {"focal_mm": -1}, {"focal_px": 0}, {"focal_px": math.nan}, {"focal_mm": 50, "focal_px": 3000},
        {"focal_35mm": 28, "focal_mm": 28}, {"sensor_mm": (36, 0)}, {"focal_px": 900, "sensor_mm": (36, 24)},
        {"assume_fov_deg": 180}, {"assume_fov_deg": 0},
    ],
)  # fmt: skip
def test_contradictory_requests_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SettingsError, match="--"):
        FocalRequest(**wrong)  # type: ignore[arg-type]


def test_equivalent_may_or_may_not_count_the_digital_zoom() -> None:
    without = estimate_camera(
        photo_of(focal_mm=50.0, focal_plane_px_per_mm=6000 / 36, focal_35mm=50.0, digital_zoom=2.0)
    )
    counted = estimate_camera(
        photo_of(focal_mm=50.0, focal_plane_px_per_mm=6000 / 36, focal_35mm=100.0, digital_zoom=2.0)
    )
    for estimate in (without, counted):
        assert estimate.camera is not None and estimate.camera.focal_rel_sd == 0.02
        assert [c.focal_px for c in estimate.candidates] == pytest.approx([100 * 6000 / 36] * 2, rel=1e-3)
    alone = camera_of(photo_of(focal_35mm=50.0, digital_zoom=2.0))
    assert math.exp(1.645 * alone.focal_rel_sd) >= 2


def test_crops_lose_the_principal_point_and_resized_files_do_not() -> None:
    full = {"focal_mm": 50.0, "focal_plane_px_per_mm": 6000 / 36, "stored_width_px": 6000, "stored_height_px": 4000}
    assert camera_of(photo_of(3000, 2000, **full)).principal_sd_px == 0
    # cut from the middle third of the height, or anywhere in it: the spread of an even distribution over 2000 px
    cut = camera_of(photo_of(6000, 2000, **full))
    assert cut.principal_sd_px == pytest.approx(2000 / math.sqrt(2) / math.sqrt(12))
    assert cut.f_px == pytest.approx(50 * 6000 / 36)
    edited = estimate_camera(photo_of(focal_35mm=50.0, cropped=True))
    assert edited.camera is not None and edited.camera.principal_sd_px > 0 and edited.camera.focal_rel_sd >= 0.2
    assert any("principal point unknown" in flag.text for flag in edited.flags)


def test_the_interval_of_a_cut_reaches_down_to_one_made_smaller() -> None:
    full = {"focal_mm": 50.0, "focal_plane_px_per_mm": 6000 / 36, "stored_width_px": 6000, "stored_height_px": 4000}
    camera = camera_of(photo_of(1000, 1000, **full))
    at_full_size, at_a_quarter = 50 * 6000 / 36, 50 * 1500 / 36
    assert camera.f_px == pytest.approx(at_full_size)
    assert camera.f_px * math.exp(-1.645 * camera.focal_rel_sd) <= at_a_quarter


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 12), st.sampled_from(["focal_35mm", "plane", "px_sensor", "fov"]))
def test_focal_length_scales_with_resizing(divisor: int, known: str) -> None:
    metadata = {
        "focal_35mm": {"focal_35mm": 35.0},
        "plane": {
            "focal_mm": 35.0, "focal_plane_px_per_mm": 6000 / 36, "stored_width_px": 6000, "stored_height_px": 4000
        },
        "px_sensor": {"focal_mm": 35.0},
        "fov": {},
    }[known]  # fmt: skip
    request = FocalRequest(
        sensor_mm=(36, 24) if known == "px_sensor" else None, assume_fov_deg=50 if known == "fov" else None
    )
    large = camera_of(photo_of(6000, 4000, **metadata), request)
    small = camera_of(photo_of(6000 // divisor, 4000 // divisor, **metadata), request)
    assert small.f_px * divisor == pytest.approx(large.f_px, rel=2e-3)
    assert small.focal_rel_sd == pytest.approx(large.focal_rel_sd, rel=1e-6)
    np.testing.assert_allclose((small.cx * divisor, small.cy * divisor), (large.cx, large.cy), rtol=2e-3)


def test_lens_and_aperture_are_read(tmp_path: Path) -> None:
    tags = {LENS: "EF16-35mm f/4L IS USM", F_NUMBER: (8, 1), MAKE: "Canon", MODEL: "Canon EOS 6D"}
    metadata = Photo.open(write(tmp_path / "a.jpg", 600, 400, tags)).metadata
    assert (metadata.lens, metadata.f_number) == ("EF16-35mm f/4L IS USM", 8.0)


WIDE_ANGLE = {
    "make": "Canon", "model": "Canon EOS 6D", "lens": "EF16-35mm f/4L IS USM", "focal_mm": 16.0, "f_number": 8.0,
    "focal_plane_px_per_mm": 6000 / 36,
}  # fmt: skip


@pytest.mark.parametrize("distortion", [(-0.1, 0.02, 0.0, 0.0, -0.004), (0.03, -0.01, 0.002, -0.001, 0.002)])
@pytest.mark.parametrize("scale", [1.0, 0.97])
def test_a_mapping_by_opencvs_model_gives_its_numbers_back(distortion, scale) -> None:
    """Also where the mapping keeps another scale than that of the optical axis, as lensfun's does."""
    f = 0.8  # of the long side
    ideal = np.stack(np.meshgrid(np.linspace(-0.5, 0.5, 31), np.linspace(-1 / 3, 1 / 3, 21)), axis=-1).reshape(-1, 2)
    camera = Camera(f, f, 0.0, 0.0, 1, 1, distortion)
    bent = camera.project(np.column_stack([ideal * scale / f, np.ones(len(ideal))]))
    found = _fit("drawn", ideal, bent, f, 6000)
    assert found is not None
    assert found.distortion == pytest.approx(distortion, abs=1e-9)
    assert found.residual_px < 1e-6 and found.worst_px < 1e-5
    off = bent + np.where(np.arange(len(bent)) % 2, 1, -1)[:, None] * (0.001, 0.0)
    found = _fit("drawn", ideal, off, f, 6000)
    assert found is not None and found.residual_px == pytest.approx(6.0, rel=0.05)  # a thousandth of 6000 px
    folding = _fit("drawn", ideal, ideal * (1 - 2 * (ideal**2).sum(axis=1, keepdims=True) / f**2), f, 6000)
    assert folding is None  # it comes back towards the middle before the corner


@pytest.mark.parametrize(
    ("name", "numbers", "generation"),
    [
        ("EF 50mm f/1.8 II", {50, 1.8}, 2), ("EF50mm f/1.8", {50, 1.8}, 1),
        ("EF-S 18-55mm f/3.5-5.6 III", {18, 55, 3.5, 5.6}, 3),
        ("Nokton 35mm Mk IV", {35}, 4), ("Apo-Lanthar V", set(), 5), ("Vivid 24mm", {24}, 1),
    ],
)  # fmt: skip
def test_a_lenss_name_tells_its_numbers_and_generation(name, numbers, generation) -> None:
    assert _signature(name) == (frozenset(numbers), generation)


def test_a_known_lens_brings_its_distortion() -> None:
    """The stored corner of a 16 mm picture belongs far from where a straight lens would have put it."""
    estimate = estimate_camera(photo_of(**WIDE_ANGLE))
    camera = estimate.camera
    assert camera is not None and camera.f_px == pytest.approx(16 * 6000 / 36)
    assert "EF 16-35mm f/4L" in (estimate.lens or "") and any(camera.distortion)
    import lensfunpy

    database = lensfunpy.Database()
    body = database.find_cameras("Canon", "Canon EOS 6D")[0]
    lens = database.find_lenses(body, None, WIDE_ANGLE["lens"])[0]
    modifier = lensfunpy.Modifier(lens, body.crop_factor, 6000, 4000)
    modifier.initialize(16.0, 8.0, 1000.0, 1.0, flags=lensfunpy.ModifyFlags.DISTORTION)
    # lensfun gives, for a point of its straightened picture, the point of the photo. Its straightened picture may
    # be larger or smaller than ours, by one factor for all points.
    factors = []
    for column, row in ((100, 100), (3000, 50), (5900, 2000), (1000, 3000), (4500, 700)):
        stored = modifier.apply_geometry_distortion(column, row, 1, 1)[0, 0] + 0.5
        ours = camera.undistorted(stored) - (3000, 2000)
        theirs = np.array([column + 0.5 - 3000, row + 0.5 - 2000])
        factors.append(np.linalg.norm(ours) / np.linalg.norm(theirs))
        assert np.linalg.norm(ours / factors[-1] - theirs) < 0.5  # the same direction
    assert max(factors) / min(factors) - 1 < 2e-3
    assert np.linalg.norm(camera.undistorted([100.0, 100.0]) - (100.0, 100.0)) > 40


@settings(max_examples=30, deadline=None)
@given(st.floats(0, 6000), st.floats(0, 4000), st.floats(0.5, 50))
def test_projecting_undoes_unprojecting_with_distortion(u: float, v: float, depth_m: float) -> None:
    camera = camera_of(photo_of(**WIDE_ANGLE))
    np.testing.assert_allclose(camera.project(camera.rays([u, v]) * depth_m), (u, v), atol=1e-6)


@pytest.mark.parametrize(
    "change",
    [
        {"cropped": True}, {"lens_corrected": True}, {"digital_zoom": 2.0}, {"lens": "EF16-35mm f/9L"},
        {"lens": "EF16-35mm f/2.8L II USM", "focal_mm": 50.0}, {"lens": None}, {"model": "Canon EOS 9999X"},
        {"make": "SONY", "model": "ILCE-7M3", "lens": "FE 28mm F2", "focal_mm": 28.0},
        {"make": "Apple", "model": "iPhone XS", "lens": None, "focal_mm": 4.25},
    ],
)  # fmt: skip
def test_distortion_is_left_alone_where_it_is_not_known_or_already_gone(change: dict[str, object]) -> None:
    estimate = estimate_camera(photo_of(**{**WIDE_ANGLE, **change}))
    assert estimate.camera is not None and not any(estimate.camera.distortion) and estimate.lens is None


def test_a_phones_sensor_counts_only_with_its_own_lens() -> None:
    def sources(focal_mm: float) -> list[str]:
        return [
            str(c.source)
            for c in estimate_camera(photo_of(make="Apple", model="iPhone XS", focal_mm=focal_mm)).candidates
        ]

    assert len(sources(4.25)) == 1 and sources(6.0) == []


def _cut(angle_deg: float, shape: tuple[int, int], turned: bool) -> tuple[Metadata, int, int, complex]:
    """Return what an editor records of a rectangle cut from a sensor's picture, the file's size, and where the middle
    of the sensor's picture lies in the file, as the sensor has it (right + i down)."""
    turn = np.exp(1j * math.radians(angle_deg))
    middle, kept = complex(0.45 * shape[0], 0.55 * shape[1]), complex(2400, 1500)
    corners = [middle + side * kept / 2 * turn for side in (-1, 1)]
    crop = Crop(
        corners[0].real / shape[0], corners[0].imag / shape[1], corners[1].real / shape[0], corners[1].imag / shape[1],
        angle_deg,
    )  # fmt: skip
    centre = (complex(*shape) / 2 - middle) / turn + kept / 2
    size = (1500, 2400) if turned else (2400, 1500)
    return Metadata(focal_mm=50.0, focal_35mm=50.0, cropped=True, crop=crop), *size, centre


@pytest.mark.parametrize("shape", [(6000, 4000), (4608, 3456)])
@pytest.mark.parametrize("angle_deg", [0.0, 3.5, -7.0])
@pytest.mark.parametrize("turned", [False, True])
def test_a_recorded_crop_gives_back_the_whole_picture(shape: tuple[int, int], angle_deg: float, turned: bool) -> None:
    metadata, width, height, centre = _cut(angle_deg, shape, turned)
    frame = frame_of(width, height, metadata)
    assert frame.diagonal_px == pytest.approx(math.hypot(*shape), rel=0.005)
    if turned:  # which way is not recorded: on one side or the other
        off = abs(centre - complex(1200, 750))
        assert frame.principal_px is None and frame.principal_sd_px == pytest.approx(off / math.sqrt(2), rel=0.02)
    else:
        assert frame.principal_px == pytest.approx((centre.real, centre.imag), abs=2)


def test_a_recorded_crop_reaches_the_camera(tmp_path: Path) -> None:
    settings_of = 'crs:HasCrop="True" crs:AlreadyApplied="{}" crs:CropLeft="0.2" crs:CropTop="0.1" '
    settings_of += 'crs:CropRight="0.6" crs:CropBottom="0.5" crs:CropAngle="0" exif:FocalLengthIn35mmFilm="50"'
    path = tmp_path / "cut.jpg"
    Image.new("RGB", (600, 400)).save(path, xmp=xmp_of("", settings_of.format("True")))
    estimate = estimate_camera(Photo.open(path))
    assert estimate.camera is not None
    assert estimate.camera.f_px == pytest.approx(50 * math.hypot(1500, 1000) / DIAGONAL)
    assert (estimate.camera.cx, estimate.camera.cy) == pytest.approx((450, 400))  # the middle at .5, .5 of 1500 x 1000
    assert any("principal point as recorded" in flag.text for flag in estimate.flags)
    Image.new("RGB", (600, 400)).save(path, xmp=xmp_of("", settings_of.format("False")))
    pending = estimate_camera(Photo.open(path))
    assert pending.camera is not None and pending.camera.cx == 300 and not pending.flags


def test_a_recorded_rectangle_that_is_not_the_files_is_not_believed() -> None:
    metadata, width, height, _ = _cut(0.0, (6000, 4000), False)
    frame = frame_of(width, height * 2, metadata)
    assert frame.principal_px is None and frame.size_rel_sd > 0.1


def test_a_zoom_that_a_maker_counts_or_not_lies_within_the_interval() -> None:
    """Of an unknown maker: half of the interval, as a logarithm, is the zoom, besides what the tag leaves."""
    plain, zoomed = camera_of(photo_of(focal_35mm=28.0)), camera_of(photo_of(focal_35mm=28.0, digital_zoom=2.0))
    assert zoomed.fx == pytest.approx(plain.fx)
    assert zoomed.focal_rel_sd == pytest.approx(math.hypot(plain.focal_rel_sd, math.log(2.0) / HALF_WIDTH_SD))


def test_a_cut_at_an_unknown_scale_reaches_down_to_the_largest_that_fits() -> None:
    """800 x 800 of 3000 x 2000: cut at full size, or as much as fits made smaller, by 0.4."""
    frame = frame_of(800, 800, Metadata(stored_width_px=3000, stored_height_px=2000))
    assert (frame.width_px, frame.height_px, frame.scale) == (3000, 2000, 1.0)
    assert frame.size_rel_sd == frame.scale_rel_sd == pytest.approx(math.log(1 / 0.4) / HALF_WIDTH_SD)
    # uniform over the room that is left, 2,200 by 1,200
    assert frame.principal_sd_px == pytest.approx(math.hypot(2200, 1200) / math.sqrt(2) / math.sqrt(12))
