"""Names of files in locales that know no UTF-8: the same in the tables as on any other machine."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from proxemetry.archive.store.results import Results
from synthetic.small_photos import write_photos


@pytest.mark.skipif(os.name != "posix", reason="other systems name files in Unicode")
def test_a_locale_without_utf_8_names_photos_as_any_other(tmp_path: Path) -> None:
    write_photos(tmp_path / "photos", 1)
    (photo,) = (tmp_path / "photos").rglob("*.jpg")
    photo.rename(tmp_path / "photos" / "Größe 東京.jpg")
    for name in (tmp_path / "photos").iterdir():
        if name.is_dir():
            name.rmdir()
    environment = {
        **os.environ, "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0",
        "PYTHONPATH": os.pathsep.join(filter(None, sys.path)),
    }  # fmt: skip
    command = [sys.executable, "-m", "proxemetry", "measure", "photos", "--out", "results", "--jobs", "0"]
    command += ["--pose", "python:synthetic.small_photos:two_people"]
    ended = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, check=False)
    assert ended.returncode == 0, ended.stderr.decode(errors="replace")
    assert [scene.photo for scene in Results.open(tmp_path / "results").scenes()] == ["Größe 東京.jpg"]
