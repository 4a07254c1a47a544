"""What files say of their camera, place and date, against exiftool where that is installed."""

from __future__ import annotations

import json
import shutil
import struct
import subprocess
from pathlib import Path

import pytest
from PIL import Image

from proxemetry.photo import Photo
from proxemetry.photo.about import About
from proxemetry.photo.metadata import Metadata
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
    exif_of,
    write,
)

TAGS = {
    MAKE: "Canon", MODEL: "Canon EOS 6D", LENS: "EF16-35mm f/4L IS USM", FOCAL: (165, 10), FOCAL_35: 17,
    F_NUMBER: (56, 10), ZOOM: (15, 10), PLANE_X: (5472000, 1415), PLANE_UNIT: 2, STORED_WIDTH: 600,
    STORED_HEIGHT: 400, ORIENTATION: 6, 0x9003: "2018:07:24 11:22:45",
}  # fmt: skip
PRIVATE = {0x013B: "Ann Author", 0x010E: "Bo and Cy meet"}
GPS = {1: "S", 2: (60.0, 30.0, 36.0), 3: "E", 4: (24.0, 45.0, 0.0)}


def iim(*datasets: tuple[int, int, str], codec: str = "utf-8") -> bytes:
    """Return an IPTC-IIM block of (record, dataset, text)."""
    return b"".join(
        struct.pack(">BBBH", 0x1C, record, number, len(text.encode(codec))) + text.encode(codec)
        for record, number, text in datasets
    )


def with_iptc(path: Path, block: bytes) -> Path:
    """Put an IPTC block into a JPEG, as Photoshop does."""
    padded = block + b"\0" * (len(block) % 2)
    resource = b"Photoshop 3.0\0" + b"8BIM" + struct.pack(">HHI", 0x0404, 0, len(block)) + padded
    content = path.read_bytes()
    path.write_bytes(content[:2] + b"\xff\xed" + struct.pack(">H", len(resource) + 2) + resource + content[2:])
    return path


def xmp_of(properties: str, attributes: str = "") -> bytes:
    """Return an XMP packet."""
    return (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        '<rdf:Description rdf:about="" xmlns:photoshop="http://ns.adobe.com/photoshop/1.0/" '
        'xmlns:crs="http://ns.adobe.com/camera-raw-settings/1.0/" xmlns:exif="http://ns.adobe.com/exif/1.0/" '
        'xmlns:tiff="http://ns.adobe.com/tiff/1.0/" xmlns:dc="http://purl.org/dc/elements/1.1/" '
        'xmlns:Iptc4xmpExt="http://iptc.org/std/Iptc4xmpExt/2008-02-29/" '
        'xmlns:GPano="http://ns.google.com/photos/1.0/panorama/" '
        f"{attributes}>{properties}</rdf:Description></rdf:RDF></x:xmpmeta>"
    ).encode()


def test_what_a_camera_writes(tmp_path: Path) -> None:
    metadata = Photo.open(write(tmp_path / "photo.jpg", 600, 400, TAGS)).metadata
    assert metadata == Metadata(
        make="Canon", model="Canon EOS 6D", lens="EF16-35mm f/4L IS USM", focal_mm=16.5, focal_35mm=17.0, f_number=5.6,
        focal_plane_px_per_mm=pytest.approx(5472000 / 1415 / 25.4), stored_width_px=400, stored_height_px=600,
        digital_zoom=1.5, date="2018-07-24T11:22:45", orientation=6,
    )  # fmt: skip


@pytest.mark.parametrize(("unit", "mm"), [(1, 25.4), (2, 25.4), (3, 10), (4, 1), (5, 0.001)])
def test_units_of_the_focal_plane_resolution(unit: int, mm: float, tmp_path: Path) -> None:
    per_unit = round(152 * mm * 1000)
    tags = {PLANE_X: (per_unit, 1000), PLANE_UNIT: unit}
    metadata = Photo.open(write(tmp_path / "photo.jpg", 60, 40, tags)).metadata
    assert metadata.focal_plane_px_per_mm == pytest.approx(152, rel=0.01)


def test_names_and_places_only_on_request(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    xmp = xmp_of("<Iptc4xmpExt:PersonInImage><rdf:Bag><rdf:li>Bo</rdf:li></rdf:Bag></Iptc4xmpExt:PersonInImage>")
    Image.new("RGB", (60, 40)).save(path, exif=exif_of(PRIVATE, GPS), xmp=xmp)
    plain = Photo.open(path).metadata
    assert plain == Metadata() and plain.about() == About()
    asked = Photo.open(path, with_names=True, with_gps=True).metadata
    assert (asked.creator, asked.caption, asked.people) == ("Ann Author", "Bo and Cy meet", ("Bo",))
    assert asked.gps == pytest.approx((-60.51, 24.75))
    assert asked.about().latitude_deg == -60.51


def test_iptc_comes_before_xmp_and_exif(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    xmp = xmp_of("<photoshop:Country>Atlantis</photoshop:Country><photoshop:Source>Agency</photoshop:Source>")
    Image.new("RGB", (60, 40)).save(path, exif=exif_of({0x9003: "2020:01:01 00:00:00"}), xmp=xmp)
    block = iim((1, 90, "\x1b%G"), (2, 55, "19870612"), (2, 90, "Jyväskylä"), (2, 101, "Finland"), (2, 80, "Ann"))
    metadata = Photo.open(with_iptc(path, block)).metadata
    assert metadata.about() == About("1987-06-12", "Finland", "Jyväskylä", "Agency")
    latin = iim((2, 90, "Jyväskylä"), codec="latin-1")
    plain = write(tmp_path / "latin.jpg", 60, 40)
    assert Photo.open(with_iptc(plain, latin)).metadata.city == "Jyväskylä"


def test_a_date_may_be_as_vague_as_it_is(tmp_path: Path) -> None:
    for said, expected in (("1987", "1987"), ("1987-06", "1987-06"), ("19870600", "1987-06"), ("00000000", None)):
        path = with_iptc(write(tmp_path / "photo.jpg", 60, 40), iim((2, 55, said)))
        assert Photo.open(path).metadata.date == expected


@pytest.mark.parametrize("suffix", ["jpg", "png", "webp", "tif"])
def test_xmp_in_every_format(suffix: str, tmp_path: Path) -> None:
    path, packet = tmp_path / f"photo.{suffix}", xmp_of("<photoshop:City>Oulu</photoshop:City>", 'crs:HasCrop="True"')
    image = Image.new("RGB", (60, 40))
    if suffix == "png":
        from PIL.PngImagePlugin import PngInfo

        text = PngInfo()
        text.add_itxt("XML:com.adobe.xmp", packet.decode())
        image.save(path, pnginfo=text)
    elif suffix == "tif":
        image.save(path, tiffinfo={700: packet})
    else:
        image.save(path, xmp=packet)
    metadata = Photo.open(path).metadata
    assert (metadata.city, metadata.cropped) == ("Oulu", True)


def test_xmp_stands_in_for_exif_that_was_stripped(tmp_path: Path) -> None:
    path = tmp_path / "photo.jpg"
    xmp = xmp_of("", 'exif:FocalLength="425/10" tiff:Model="Canon EOS 6D" crs:LensProfileEnable="1"')
    Image.new("RGB", (60, 40)).save(path, xmp=xmp)
    metadata = Photo.open(path).metadata
    assert (metadata.focal_mm, metadata.model, metadata.lens_corrected) == (42.5, "Canon EOS 6D", True)


def test_nonsense_is_none_with_a_remark(tmp_path: Path) -> None:
    tags = {FOCAL: (0, 0), FOCAL_35: 65535, PLANE_X: (1, 0), ZOOM: (0, 1), MAKE: "\x00\x01 \n"}
    metadata = Photo.open(write(tmp_path / "photo.jpg", 60, 40, tags)).metadata
    assert (metadata.focal_mm, metadata.focal_35mm, metadata.focal_plane_px_per_mm) == (None, None, None)
    assert metadata.digital_zoom is None and metadata.make is None
    assert len(metadata.remarks) == 3 and "0/0" in metadata.remarks[0]


@pytest.mark.skipif(shutil.which("exiftool") is None, reason="exiftool (libimage-exiftool-perl) is not installed")
@pytest.mark.parametrize("suffix", ["jpg", "png", "webp", "tif"])
def test_exiftool_reads_the_same(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"photo.{suffix}"
    whole = tmp_path / "whole.jpg"
    Image.new("RGB", (600, 400)).save(whole, exif=exif_of(TAGS | PRIVATE, GPS))
    Image.new("RGB", (600, 400)).save(path)
    subprocess.run(["exiftool", "-q", "-TagsFromFile", str(whole), "-all:all", str(path)], check=True)
    if suffix == "jpg":
        with_iptc(path, iim((1, 90, "\x1b%G"), (2, 90, "Jyväskylä"), (2, 101, "Finland"), (2, 115, "Agency")))
    run = subprocess.run(["exiftool", "-json", "-n", str(path)], capture_output=True, text=True, check=True)
    (theirs,) = json.loads(run.stdout)
    ours = Photo.open(path, with_names=True, with_gps=True).metadata
    assert ours.make == theirs["Make"] and ours.model == theirs["Model"] and ours.lens == theirs["LensModel"]
    assert ours.focal_mm == pytest.approx(theirs["FocalLength"])
    assert ours.focal_35mm == theirs["FocalLengthIn35mmFormat"]
    assert ours.f_number == pytest.approx(theirs["FNumber"])
    assert ours.digital_zoom == pytest.approx(theirs["DigitalZoomRatio"])
    per_mm = theirs["FocalPlaneXResolution"] / {2: 25.4, 3: 10, 4: 1}[theirs["FocalPlaneResolutionUnit"]]
    assert ours.focal_plane_px_per_mm == pytest.approx(per_mm, rel=1e-5)
    assert theirs["Orientation"] == 6
    assert (ours.stored_height_px, ours.stored_width_px) == (theirs["ExifImageWidth"], theirs["ExifImageHeight"])
    assert (ours.date or "").replace("-", ":").replace("T", " ") == theirs["DateTimeOriginal"]
    assert (ours.creator, ours.caption) == (theirs["Artist"], theirs["ImageDescription"])
    assert ours.gps == pytest.approx((theirs["GPSLatitude"], theirs["GPSLongitude"]))
    if suffix == "jpg":
        assert (ours.city, ours.country, ours.source) == (
            theirs["City"], theirs["Country-PrimaryLocationName"], theirs["Source"],
        )  # fmt: skip
