"""The camera table: the most specific row wins, and a wrong cell is named with its line."""

from __future__ import annotations

from pathlib import Path

import pytest

from proxemetry.camera import Mount
from proxemetry.camera.focal import FocalRequest, estimate_camera
from proxemetry.camera.table import CameraRow, CameraTable
from proxemetry.errors import CameraError, ProxemetryError, SettingsError
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Metadata

HEADER = "photo,make,model,focal_mm,focal_35mm,sensor_width_mm,sensor_height_mm,focal_px,focal_y_px,cx_px,cy_px,k1"


def table_of(tmp_path: Path, *rows: str, header: str = HEADER) -> CameraTable:
    path = tmp_path / "cameras.csv"
    path.write_text("\n".join((header, *rows)) + "\n", encoding="utf-8")
    return CameraTable.read(path)


def estimate_of(table: CameraTable, name: str = "roll_3/scan_0042.tif", **metadata: object):  # type: ignore[no-untyped-def]
    photo = Photo(name, 6000, 4000, "", Metadata(**metadata))  # type: ignore[arg-type]
    return estimate_camera(photo, FocalRequest(camera_table=table))


def test_the_most_specific_row_wins(tmp_path: Path) -> None:
    table = table_of(
        tmp_path,
        "*,,,,,,,1000", "*.tif,,,,,,,1100", ",Nikon,,,,,,2000", ",Nikon,FM2,,,,,3000", "roll_3/*,,,,,,,4000",
        "scan_000*,,,,,,,5000", "SCAN_0042.TIF,,,,,,,6000",
    )  # fmt: skip

    def focal_px(name: str, **metadata: str) -> float | None:
        row = table.row_for(name, **metadata)
        return row and row.focal_px

    assert focal_px("a.jpg") == 1000
    assert focal_px("a.jpg", make="NIKON") == 2000
    assert focal_px("a.tif", make="Nikon", model="FM2") == 3000
    assert focal_px("roll_3/x.tif", make="Nikon", model="FM2") == 4000
    assert focal_px("roll_3/scan_0001.tif") == 5000
    assert focal_px("roll_3\\scan_0042.tif") == 6000


def test_rows_that_apply_to_nothing_change_nothing(tmp_path: Path) -> None:
    table = table_of(tmp_path, "other*,,,,,,,1000", ",Leica,M6,,,,,1000")
    assert table.row_for("scan.tif") is None
    assert estimate_of(table).camera is None


@pytest.mark.parametrize(
    ("row", "metadata", "expected"),
    [
        ("*,,,50,,36,24", {}, 50 * 6000 / 36),
        ("*,,,50,,36,", {}, 50 * 6000 / 36),
        ("*,,,,,36,24", {"focal_mm": 35.0}, 35 * 6000 / 36),
        ("*,,,,28,,", {}, 28 * (36**2 + 24**2) ** 0.5 * 6000 / 36 / (36**2 + 24**2) ** 0.5),
        ("*,,,85,,,", {"focal_plane_px_per_mm": 6000 / 36}, 85 * 6000 / 36),
        ("*,,,,,,,7000", {"focal_35mm": 42.0}, 7000),
    ],
)
def test_what_a_row_can_state(row: str, metadata: dict[str, float], expected: float, tmp_path: Path) -> None:
    camera = estimate_of(table_of(tmp_path, row), **metadata).camera
    assert camera is not None and camera.f_px == pytest.approx(expected)
    assert str(camera.source).startswith("camera table line 2: ") and not camera.source.is_assumed


def test_a_row_can_state_a_whole_calibration(tmp_path: Path) -> None:
    estimate = estimate_of(table_of(tmp_path, "*,,,,,,,7000,7070,2900,2100,-0.1"), cropped=True)
    camera = estimate.camera
    assert (camera.fx, camera.fy, camera.cx, camera.cy) == (7000, 7070, 2900, 2100)
    assert camera.distortion == (-0.1, 0, 0, 0, 0) and camera.principal_sd_px == 0
    assert estimate.lens == "camera table line 2"


def test_a_row_comes_before_what_is_stated_for_the_run(tmp_path: Path) -> None:
    table = table_of(tmp_path, "scan*,,,,,,,7000")
    request = FocalRequest(focal_px=5000, camera_table=table)
    for name, expected in (("scan_1.tif", 7000), ("other.tif", 5000)):
        camera = estimate_camera(Photo(name, 6000, 4000, ""), request).camera
        assert camera is not None and camera.f_px == expected


def test_spreadsheets_of_all_countries_are_read(tmp_path: Path) -> None:
    path = tmp_path / "cameras.csv"
    path.write_bytes("\ufeffphoto;focal_mm;sensor_width_mm\r\nscan*;50;35,9\r\n;;\r\n".encode())
    (row,) = CameraTable.read(path).rows
    assert (row.photo, row.focal_mm, row.sensor_width_mm) == ("scan*", 50.0, 35.9)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("*,,,fifty", r"line 2: focal_mm is 'fifty'"),
        ("*,,,-50", r"line 2: focal_mm is -50"),
        ("*,,,nan", r"line 2: focal_mm is 'nan'"),
        ("*,,,50,50", r"line 2: focal_mm and focal_35mm state the focal length twice"),
        (",,,50", r"line 2: the row names neither"),
        ("*,,,,,,,,7000", r"focal_y_px is given without focal_px"),
        ("*,,,,,,,7000,,3000", r"cx_px and cy_px belong together"),
        ("*,,,,,,24", r"sensor_height_mm is given without"),
        ("*" + "," * 20 + "1", r"line 2: there are more cells than columns"),
    ],
)
def test_wrong_cells_are_named(row: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CameraError, match=message):
        table_of(tmp_path, row)


def test_wrong_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match=r"none\.csv"):
        CameraTable.read(tmp_path / "none.csv")
    with pytest.raises(CameraError, match="column 'foto' is unknown; columns are photo"):
        table_of(tmp_path, "*,1", header="foto,focal_px")
    with pytest.raises(CameraError, match="no column photo, make or model"):
        table_of(tmp_path, "50", header="focal_mm")
    with pytest.raises(CameraError, match="no rows"):
        table_of(tmp_path)


def test_an_umlaut_is_an_umlaut_however_it_is_written(tmp_path: Path) -> None:
    composed, decomposed = "M\u00fcller.jpg", "Mu\u0308ller.jpg"
    for written, named in ((composed, decomposed), (decomposed, composed)):
        row = table_of(tmp_path, f"{written},,,,,,,1000").row_for(named)
        assert row is not None and row.focal_px == 1000


@pytest.mark.parametrize("value", ["1e-320", "1e308", "0", "-3"])
def test_lengths_that_no_camera_has_are_one_line(tmp_path: Path, value: str) -> None:
    path = tmp_path / "cameras.csv"
    path.write_text(f"photo,focal_mm,sensor_width_mm,sensor_height_mm\n*,50,{value},24\n")
    with pytest.raises(ProxemetryError, match="sensor_width_mm"):
        CameraTable.read(path)
    with pytest.raises(ProxemetryError):
        FocalRequest(focal_mm=50, sensor_mm=(float(value), 24))
    with pytest.raises(ProxemetryError, match="height"):
        Mount.stated(0.1, 0.0, 0.0, height_sd_m=0.1)


@pytest.mark.parametrize(
    ("pattern", "fits", "fits_not"),
    [
        ("photo[1].jpg", "photo[1].jpg", "photo1.jpg"),
        ("[a] holiday/*.jpg", "[a] holiday/1.jpg", "a holiday/1.jpg"),
        ("photo[12].jpg", "photo[12].jpg", "photo3.jpg"),
        ("photo[12].jpg", "photo2.jpg", "photo12.jpg"),
        ("what[?].jpg", "what?.jpg", "whatx.jpg"),
        ("all[*].jpg", "all*.jpg", "allx.jpg"),
    ],
)
def test_a_names_own_brackets_are_no_pattern(pattern: str, fits: str, fits_not: str) -> None:
    """A browser saves photo[1].jpg: a row for it applied to photo1.jpg instead, whose lens is another."""
    row = CameraRow(2, pattern, focal_35mm=50.0)
    assert row.applies(fits, None, None) and not row.applies(fits_not, None, None)


def test_rows_that_name_no_photo_are_found() -> None:
    rows = (CameraRow(2, "a*.jpg"), CameraRow(3, "b.jpg"), CameraRow(4, None, "Canon"), CameraRow(5, "c.jpg"))
    table = CameraTable(rows)
    assert [row.line for row in table.unused(["x/a1.jpg", "B.JPG"]) or ()] == [5]
    assert table.unused(["a1.jpg", "b.jpg", "deep/c.jpg"]) == ()
    assert table.unused(f"{k}.jpg" for k in range(400_000)) is None  # too long to know
