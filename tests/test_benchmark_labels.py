"""The label files: what is read, what is put right, and every fault that can be made in them."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from proxemetry.benchmark import load_errata, read_labels
from proxemetry.benchmark.validate_labels import check_labels
from proxemetry.cli import main
from proxemetry.errors import LabelsError

KORTE = Path(__file__).parent.parent.parent / "shared" / "data" / "korte"
needs_korte = pytest.mark.skipif(not KORTE.exists(), reason="the labels of the KORTE benchmark are not here")

BODY = "body_pixel_locations.csv"
TRUTH = "ground_truth_locations.csv"
PHOTOS = "camera_locations_photoshoot_identifiers.csv"
CLEAN = {
    BODY: "P0,Head,100,110,a.jpg,1000,800\nP1,Torso,300,220,a.jpg,1000,800\nP0,Head,5,6,b.jpg,1000,800\n",
    TRUTH: "7,C0,0,0,0\n7,P0,0,0,5000\n7,P1,3000,0,5000\n",
    PHOTOS: "7,C0,a.jpg\n7,C0,b.jpg\n",
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in CLEAN.items():
        (tmp_path / name).write_text(text)
    return tmp_path


def change(folder: Path, name: str, edit: Callable[[bytes], bytes]) -> list[str]:
    path = folder / name
    path.write_bytes(edit(path.read_bytes()))
    return [str(fault) for fault in check_labels(folder)]


def test_clean_labels_have_no_fault_and_new_shoots_need_no_code(folder: Path) -> None:
    assert check_labels(folder) == []
    labels = read_labels(folder)
    assert [image.setting for image in labels] == ["shoot 7", "shoot 7"]
    assert labels.by_name["a.jpg"].distances_mm(ground=True)[0, 1] == 3000
    assert np.isnan(labels.by_name["a.jpg"].focal_mm)
    (folder / "settings.csv").write_text("shoot,setting\n7,garden\n")
    (folder / "focal_lengths.csv").write_text("filename,focal_length_mm\na.jpg,35\n")
    assert check_labels(folder) == []
    named = read_labels(folder).by_name["a.jpg"]
    assert (named.setting, named.focal_mm) == ("garden", 35)


@pytest.mark.parametrize("size", ["0,800", "1000,0", "-1000,800", "0.4,800"])
def test_a_photo_without_a_size_is_refused(folder: Path, size: str) -> None:
    body = folder / BODY
    body.write_text(body.read_text().replace("b.jpg,1000,800", f"b.jpg,{size}"))
    with pytest.raises(LabelsError, match=rf"{BODY}:3: '.*' where the photo's width or height is expected, in pixels"):
        read_labels(folder)


@pytest.mark.parametrize(
    ("name", "old", "new", "expected"),
    [
        (BODY, "P1,Torso", "P1,Knee", f"{BODY}:2: part 'Knee' is unknown; one of Eyes, Shoulder, Torso, Head"),
        (BODY, "P1,Torso", "P2,Torso", f"{BODY}:2: P2 is in a.jpg, but shoot 7 has no P2 in {TRUTH}"),
        (BODY, "300,220", "1000,220", f"{BODY}:2: x is 1000, outside the photo; 0 to 999 is expected"),
        (BODY, "300,220", "300,-2", f"{BODY}:2: y is '-2'; a whole number of pixels is expected"),
        (BODY, "300,220", "left,220", f"{BODY}:2: x is 'left'; a whole number of pixels is expected"),
        (BODY, "P1,Torso,300,220", "P0,Head,1,2", f"{BODY}:2: Head of P0 in a.jpg again; line 1 has it already"),
        (BODY, "300,220,a.jpg,1000,800", "300,220,a.jpg,800,1000", f"{BODY}:2: photo a.jpg is 800x1000 here, 1000x800"),
        (BODY, "300,220,a.jpg", "300,220,A.jpg", f"{BODY}:2: photo A.jpg has no row in {PHOTOS}"),
        (BODY, "P1,Torso,300,220", "P1,Torso,300", f"{BODY}:2: 6 columns; 7 are expected: person,part,x,y,filename"),
        (BODY, "P1,Torso", "Anna,Torso", f"{BODY}:2: person 'Anna'; P and a number is expected"),
        (BODY, "P1,Torso", "P1, Torso", f"{BODY}:2: blanks around a field"),
        (BODY, "P1,Torso", "\nP1,Torso", f"{BODY}:2: empty line"),
        (BODY, "P0,Head,5,6,b.jpg,1000,800\n", "", f"{PHOTOS}:2: photo b.jpg has no person in {BODY}"),
        (TRUTH, "3000,0,5000", "3000,0,nan", f"{TRUTH}:3: z is 'nan'; a number of millimetres is expected"),
        (TRUTH, "7,P1", "7,X1", f"{TRUTH}:3: tag 'X1'; P and a number"),
        (TRUTH, "7,P1,3000", "7,P0,3000", f"{TRUTH}:3: P0 of shoot 7 again; line 2 has it already"),
        (TRUTH, "3000,0,5000", "0,0,5000", f"{TRUTH}:3: P1 stands where the person of line 2 stands"),
        (PHOTOS, "7,C0,b", "7,C9,b", f"{PHOTOS}:2: shoot 7 has no camera C9 in {TRUTH}"),
        (PHOTOS, "b.jpg", "a.jpg", f"{PHOTOS}:2: photo a.jpg again; line 1 has it already"),
        (PHOTOS, "b.jpg", "A.JPG", f"{PHOTOS}:2: photo A.JPG differs in case alone from another name"),
    ],
)  # fmt: skip
def test_every_fault_is_found_where_it_is(folder: Path, name: str, old: str, new: str, expected: str) -> None:
    faults = change(folder, name, lambda content: content.replace(old.encode(), new.encode(), 1))
    assert any(fault.startswith(expected) for fault in faults), faults


def test_faults_of_whole_files(folder: Path) -> None:
    assert f"{TRUTH}:1: starts with a byte order mark" in change(folder, TRUTH, lambda c: b"\xef\xbb\xbf" + c)[0]
    assert len(read_labels(folder)) == 2  # and yet it can be read
    assert f"{PHOTOS}:1: note: lines end with CRLF" in change(folder, PHOTOS, lambda c: c.replace(b"\n", b"\r\n"))[0]
    assert len(read_labels(folder)) == 2
    mixed = change(folder, PHOTOS, lambda c: c.replace(b"\r\n", b"\n", 1))
    assert f"{PHOTOS}:2: line ends with CRLF, unlike the lines before: one kind, LF, is expected" in mixed
    assert f"{BODY}: empty; rows of person,part" in "\n".join(change(folder, BODY, lambda _: b""))
    assert f"{BODY}:1: not UTF-8 text" in change(folder, BODY, lambda _: b"P0,H\xffad")
    (folder / BODY).unlink()
    assert f"{BODY}: no such file" in str(check_labels(folder)[0])
    with pytest.raises(LabelsError, match="no such folder"):
        check_labels(folder / "nothing")


@pytest.mark.parametrize(
    ("name", "old", "new", "message"),
    [
        (BODY, "P1,Torso", "P2,Torso", "shoot 7 has no P2"),
        (BODY, "P1,Torso", "P1,Knee", "part 'Knee' is unknown"),
        (TRUTH, "3000,0", "3000", "4 columns where 5 are expected"),
        (PHOTOS, "7,C0,b.jpg\n", "", "no row for photo b"),
        (TRUTH, "P1,3000,0", "P1,0,0", "P0 and P1 of shoot 7 stand at one place"),
        (BODY, CLEAN[BODY], "", "no person is annotated in it"),
    ],
)
def test_reading_stops_at_what_cannot_be_used(folder: Path, name: str, old: str, new: str, message: str) -> None:
    (folder / name).write_text(CLEAN[name].replace(old, new))
    with pytest.raises(LabelsError, match=message):
        read_labels(folder)


def test_check_on_the_command_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["score", "--check", str(folder)]) == 0
    assert "no faults" in capsys.readouterr().out
    (folder / PHOTOS).write_text("7,C0,a.jpg\n7,C1,b.jpg\n")
    assert main(["score", "--check", str(folder)]) == 1
    assert f"{PHOTOS}:2" in capsys.readouterr().out
    assert main(["score", "--check", str(folder / "none")]) == 2
    assert main(["score", "x.json"]) == 2
    assert capsys.readouterr().err.count("\n") == 2


@needs_korte
def test_korte_as_published_and_put_right() -> None:
    published, corrected = read_labels(KORTE, errata=False), read_labels(KORTE)
    assert (sum(map(len, published)), sum(image.n_pairs for image in published)) == (426, 853)
    assert sum(map(len, corrected)) == 421  # five people exist by a wrong row alone
    assert len(corrected.errata) == len(load_errata()) == 6
    assert {image.setting for image in corrected} == {"outdoor", "indoor"}
    assert all(fault.harmless for fault in check_labels(KORTE))
    every = np.concatenate([i.distances_mm(ground=False)[np.triu_indices(len(i), 1)] for i in published])
    assert (every.min(), every.max().round(-1), np.median(every).round()) == (600, 5120, 2404)


@needs_korte
def test_errata_are_found_again_from_the_geometry() -> None:
    """Each wrong point lies within half a torso of whose it is, and farther from whose tag it bears."""
    published = read_labels(KORTE, errata=False)
    for erratum in load_errata():
        image = published.by_name[erratum.filename]
        tag, other = predicted_columns(image, erratum)
        assert abs(erratum.x - other) < 0.5 * abs(erratum.x - tag), (erratum, tag, other)


def predicted_columns(image: object, erratum: object) -> tuple[float, float]:
    """Return the columns in which a level camera at its measured place would show the two people in question.

    The camera's heading is what is unknown: it is taken from everyone whose points are not in doubt.
    """
    places = dict(image.places_mm)  # type: ignore[attr-defined]
    rows = [line.split(",") for line in (KORTE / TRUTH).read_text().splitlines()]
    camera = next(r for r in rows if r[:2] == [image.shoot, image.camera])  # type: ignore[attr-defined]
    centre = np.array([float(camera[2]), float(camera[4])])
    f_px = image.focal_mm * image.width / 36  # type: ignore[attr-defined]
    bearing = {t: np.arctan2(p[0] - centre[0], p[2] - centre[1]) for t, p in places.items()}
    doubtful = (erratum.tag, erratum.belongs_to)  # type: ignore[attr-defined]
    sure = [m for m in image.marks if m.tag not in doubtful or (m.x, m.y) != (erratum.x, erratum.y)]  # type: ignore[attr-defined]
    angle = np.array([np.arctan((m.x - image.width / 2) / f_px) for m in sure])  # type: ignore[attr-defined]
    bearings = np.array([bearing[m.tag] for m in sure])
    best = min(((spread(angle - sign * bearings), sign) for sign in (1, -1)), key=lambda s: s[0])[1]
    offset = float(np.angle(np.exp(1j * (angle - best * bearings)).sum()))
    columns = [
        image.width / 2 + f_px * np.tan(np.angle(np.exp(1j * (best * bearing[t] + offset))))
        for t in doubtful  # type: ignore[attr-defined]
    ]
    return float(columns[0]), float(columns[1])


def spread(angles: np.ndarray) -> float:
    return 1 - float(abs(np.exp(1j * angles).mean()))


def test_the_benchmark_needs_numpy_alone() -> None:
    code = (
        "import sys, proxemetry.benchmark.tables, proxemetry.benchmark.validate_labels, proxemetry.cli.score;"
        "heavy = {'cv2', 'matplotlib', 'duckdb', 'scipy', 'PIL', 'starlette', 'pooch', 'tqdm'} & set(sys.modules);"
        "sys.exit(', '.join(sorted(heavy)) or 0)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
