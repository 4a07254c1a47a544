"""A drone's photo says where it was taken from: what is read, what it is worth, and what is not believed."""

import json
import math

import numpy as np
import pytest
from PIL import Image
from test_photo_metadata import xmp_of

import proxemetry as px
from proxemetry.calibration.drone import _mount, from_subtitles
from proxemetry.camera import Camera, CameraEstimate, Doubt, Mount
from proxemetry.camera.choice import with_flight
from proxemetry.camera.drone import SOURCE, flight_mount
from proxemetry.cli import main
from proxemetry.errors import CameraError
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Flight, Metadata
from proxemetry.settings import Settings
from synthetic.modelled import photo

CAMERA = Camera.centred(1200, 1920, 1080)
DJI = 'xmlns:drone-dji="http://www.dji.com/drone-dji/1.0/" '


def taken(seed=0, pitch=0.5, height_m=8.0, flight=None):
    """Return people seen from above, and the photo that shows them."""
    people, _ = photo(seed, count=5, pitch=pitch, height_m=height_m, depths_m=(10, 20))
    pixels = np.zeros((1080, 1920, 3), np.uint8)
    return people, Photo.from_array(pixels, "DJI_0001.JPG", Metadata(flight=flight))


def test_what_a_drone_writes_is_read(tmp_path):
    path = tmp_path / "DJI_0001.JPG"
    packet = xmp_of("", DJI + 'drone-dji:RelativeAltitude="+30.10" drone-dji:GimbalPitchDegree="-45.00" '
                    'drone-dji:GimbalRollDegree="+0.00"')  # fmt: skip
    Image.new("RGB", (60, 40)).save(path, xmp=packet)
    assert Photo.open(path).metadata.flight == Flight(30.1, -45.0, 0.0)
    packet = xmp_of("<drone-dji:GimbalPitchDegree>-90</drone-dji:GimbalPitchDegree>", DJI)
    Image.new("RGB", (60, 40)).save(path, xmp=packet)
    assert Photo.open(path).metadata.flight == Flight(None, -90.0, None)
    Image.new("RGB", (60, 40)).save(path, xmp=xmp_of("", DJI + 'drone-dji:RelativeAltitude="n/a"'))
    assert Photo.open(path).metadata.flight is None


def test_pitch_height_and_their_uncertainty():
    mount = flight_mount(Flight(30.0, -45.0, 0.0))
    assert [math.degrees(mount.pitch_rad), mount.roll_rad, mount.height_m] == pytest.approx([45, 0, 30])
    assert math.degrees(mount.sd[0]) == pytest.approx(1.0) and mount.height_sd_m == pytest.approx(1.0)
    assert flight_mount(Flight(100.0, -45.0, 0.0)).height_sd_m == pytest.approx(3.0)
    assert math.degrees(flight_mount(Flight(30.0, -90.0, 0.0)).pitch_rad) == pytest.approx(90)


@pytest.mark.parametrize("flight", [None, Flight(30.0, None, 0.0), Flight(30.0, 135.0, 0.0), Flight(30.0, -179.0, 0.0)])
def test_what_cannot_be_is_no_mount(flight):
    assert flight_mount(flight) is None


@pytest.mark.parametrize("height_m", [None, -3.0, 0.0, 0.6])
def test_a_height_that_says_nothing_leaves_the_pitch(height_m):
    mount = flight_mount(Flight(height_m, -20.0, 90.0))  # rolled: held for an upright picture
    assert mount.known.tolist() == [0]


def test_what_is_stated_comes_first_part_by_part():
    _, shown = taken(flight=Flight(8.0, -30.0, 0.0))
    alone = with_flight(CameraEstimate(CAMERA), shown, None).mount
    assert alone.source == SOURCE and alone.known.tolist() == [0, 1, 2]
    taped = Mount.stated(height_m=12.0, source="tape")
    both = with_flight(CameraEstimate(CAMERA, mount=taped), shown, None).mount
    assert both.height_m == 12.0 and math.degrees(both.pitch_rad) == pytest.approx(30)
    assert both.source == f"tape, and {SOURCE}"
    assert np.allclose(both.sd[:3], [alone.sd[0], alone.sd[1], taped.sd[2]])
    whole = Mount.stated(0.1, 0.0, 5.0, camera=CAMERA)
    assert with_flight(CameraEstimate(CAMERA), shown, whole).mount is None  # the run's stands


def test_it_places_people_better_and_says_where_it_is_from():
    people, shown = taken(flight=Flight(8.0, -math.degrees(0.5), 0.0))
    told = px.measure(shown, pose=lambda pixels: people, camera=CAMERA, settings=Settings(lines=False))
    untold = px.measure(shown, pose=lambda pixels: people, camera=CAMERA, settings=Settings(lines=False, drone=False))
    assert told.camera.mount.source == SOURCE and untold.camera.mount is None
    assert told.bodies.floor.pitch_rad == pytest.approx(0.5, abs=0.03)
    width = [np.nanmean(s.distances.high_m - s.distances.low_m) for s in (told, untold)]
    assert width[0] < width[1]
    assert px.Scene.from_json(told.to_json()).camera.mount.source == SOURCE


def test_a_start_from_a_hill_is_contradicted_by_the_people():
    people, shown = taken(flight=Flight(30.0, -math.degrees(0.5), 0.0))
    scene = px.measure(shown, pose=lambda pixels: people, camera=CAMERA, settings=Settings(lines=False))
    assert any(flag.doubt is Doubt.MOUNT for flag in scene.camera.flags)
    assert scene.bodies.floor.height_m < 12


def test_the_option_reaches_the_run(tmp_path):
    Image.new("RGB", (400, 300)).save(
        tmp_path / "a.jpg", xmp=xmp_of("", DJI + 'drone-dji:RelativeAltitude="+9" drone-dji:GimbalPitchDegree="-30"')
    )
    (tmp_path / "k.json").write_text(json.dumps({"skeleton": "coco17", "images": []}))
    for option, expected in (([], True), (["--no-drone"], False)):
        out = tmp_path / f"out{expected}"
        told = [str(tmp_path / "a.jpg"), "--pose", f"recorded:{tmp_path / 'k.json'}", "--jobs", "0", "--out", str(out)]
        main(["measure", *told, *option])
        assert json.loads((out / "run.json").read_text())["settings"]["drone"] is expected


@pytest.mark.parametrize(
    ("height_m", "pitch_deg", "moved"),
    [([30.0, 30.9], [-45.0, -45.0], False), ([30.0, 31.1], [-45.0, -45.0], True), ([30.0, 30.0], [-45.0, -46.9], False),
     ([30.0, 30.0], [-45.0, -47.1], True)],
)  # fmt: skip
def test_subtitles_of_a_drone_that_moved_are_no_one_place(tmp_path, height_m, pitch_deg, moved):
    """More than a metre in height or two degrees in pitch, either of them; else the mean of all."""
    path = tmp_path / "a.srt"
    lines = [f"[rel_alt: {h} gb_pitch: {p} gb_roll: 1.0]\n" for h, p in zip(height_m, pitch_deg, strict=True)]
    path.write_text("".join(lines))
    if moved:
        with pytest.raises(CameraError, match="the drone moved"):
            from_subtitles(path)
        return
    mount = from_subtitles(path)
    assert (mount.height_m, math.degrees(mount.pitch_rad)) == pytest.approx((np.mean(height_m), -np.mean(pitch_deg)))
    assert math.degrees(mount.roll_rad) == pytest.approx(1.0)


@pytest.mark.parametrize(("gimbal_deg", "pitch_deg"), [(-90.4, 90.0), (20.0, -20.0), (-60.0, 60.0)])
def test_a_gimbal_that_reports_a_little_too_much_looks_straight_down(gimbal_deg, pitch_deg):
    found = _mount(30.0, gimbal_deg, 0.0, None, "drone")
    assert math.degrees(found.pitch_rad) == pytest.approx(pitch_deg)
    if gimbal_deg < -60:
        assert math.degrees(flight_mount(Flight(30.0, gimbal_deg, 0.0)).pitch_rad) == pytest.approx(pitch_deg)


def test_a_roll_that_is_let_go_is_as_unsure_as_it_is_large():
    for roll, sd in ((0.5, 1.0), (4.0, 4.0)):
        assert math.degrees(flight_mount(Flight(30.0, -45.0, roll)).sd[1]) == pytest.approx(sd)
