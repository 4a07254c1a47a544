"""Which files of a folder are photos: by their endings, without the thumbnails that programs keep beside them."""

from __future__ import annotations

from pathlib import Path

import pytest

from proxemetry.archive.store.photos import find_photos
from proxemetry.cli import main
from synthetic.camera_files import FOCAL_35, write


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).touch()


def test_jpegs_by_other_names_are_found_and_the_rest_is_counted(tmp_path: Path) -> None:
    touch(tmp_path, "a.jpg", "b.JFIF", "web.jpg_large", "c.jp2", "notes.txt", "x.psd", "y.PSD", "README", ".hidden.psd")
    listing = find_photos([str(tmp_path)])
    assert listing.names == ("a.jpg", "b.JFIF", "c.jp2", "web.jpg_large")
    assert listing.passed_over == "4 files passed over by their endings (2 .psd, 1 .txt, 1 without one)"
    many = tmp_path / "many"
    touch(many, "a.jpg", *(f"a.x{k}" for k in range(9)))
    assert find_photos([str(many)]).passed_over.endswith(" and 3 more endings)")


@pytest.mark.parametrize(
    "thumbnail",
    [
        "@eaDir/IMG_1.JPG/SYNOPHOTO_THUMB_M.jpg", "__MACOSX/a.jpg", ".thumbnails/a.jpg", ".AppleDouble/a.jpg",
        "Archive Previews.lrdata/0/a.jpg", "#recycle/a.jpg", "P.photoslibrary/resources/derivatives/a.jpg",
        "sub/@eaDir/a.jpg",
    ],
)  # fmt: skip
def test_copies_that_programs_keep_are_left_out(thumbnail: str, tmp_path: Path) -> None:
    touch(tmp_path, "IMG_1.JPG", thumbnail)
    listing = find_photos([str(tmp_path)])
    assert listing.names == ("IMG_1.JPG",)
    hidden = thumbnail.startswith(".")
    assert ("1 folder of thumbnails left out" in listing.passed_over) != hidden
    store = find_photos([tmp_path.as_uri()])
    assert [name for name in store.names if not name.startswith(".")] == ["IMG_1.JPG"]


def test_a_photo_managers_originals_are_photos_and_a_folder_named_outright_is_searched(tmp_path: Path) -> None:
    touch(tmp_path, "P.photoslibrary/originals/1/a.jpg", "@eaDir/b.jpg")
    assert find_photos([str(tmp_path)]).names == ("P.photoslibrary/originals/1/a.jpg",)
    assert find_photos([str(tmp_path / "@eaDir")]).names == ("b.jpg",)


def test_doctor_and_measure_say_what_was_passed_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    photos = tmp_path / "photos"
    photos.mkdir()
    write(photos / "a.jpg", 60, 40, {FOCAL_35: 28})
    touch(photos, "b.psd")
    main(["doctor", str(photos)])
    assert "1 file passed over by its ending (1 .psd)" in capsys.readouterr().out.replace("their endings", "its ending")
    (tmp_path / "kp.json").write_text('{"skeleton": "coco17", "images": [{"filename": "a.jpg", "people": []}]}')
    pose = f"recorded:{tmp_path / 'kp.json'}"
    main(["measure", str(photos), "--pose", pose, "--out", str(tmp_path / "out"), "--jobs", "0"])
    assert "1 file passed over" in capsys.readouterr().err
