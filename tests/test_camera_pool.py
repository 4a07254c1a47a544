"""Photos of a run tell each other's cameras: whatever the order, stopped anywhere, never a narrow wrong number."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from proxemetry.archive.figures.shoots import shoots_in_words
from proxemetry.archive.run import run as run_module
from proxemetry.archive.run.camera_pool import CameraPool, Shoot
from proxemetry.archive.run.run import run
from proxemetry.archive.run.work import Job
from proxemetry.archive.store import parts
from proxemetry.archive.store.folder import Folder
from proxemetry.archive.store.results import Results
from proxemetry.camera import Camera, FocalSource
from proxemetry.camera.focal import estimate_camera
from proxemetry.camera.others import CropRange, Others, SameModel, SameShoot, shoot_from_dict, shoot_to_dict
from proxemetry.camera.unstated import WIDEST_RATIO
from proxemetry.cli import main
from proxemetry.photo import Photo
from proxemetry.photo.metadata import Metadata
from proxemetry.settings import Settings
from synthetic.modelled import photo

SIZE = (1920, 1080)
#: A camera that no database knows, with a sensor of crop factor 2.
MAKE, MODEL, CROP = "Nobody", "N-1", 2.0
DIAGONAL_35MM = math.hypot(36, 24)


def px_of(focal_mm: float) -> float:
    return focal_mm * CROP / DIAGONAL_35MM * math.hypot(*SIZE)


def exif(focal_mm=None, focal_35mm=None, zoom=None, model=MODEL):
    tags = Image.Exif()
    tags[0x010F], tags[0x0110] = MAKE, model
    inner = tags.get_ifd(0x8769)
    for tag, value in ((0x920A, focal_mm), (0xA405, focal_35mm), (0xA404, zoom)):
        if value is not None:
            inner[tag] = value
    return tags


def folder_of(where: Path, files: dict[str, Image.Exif | None], focal_px=None, pitch=0.05) -> Path:
    """Write photos and, beside them, a keypoint file of the people in them; focal_px: of all, or by name."""
    where.mkdir()
    images = []
    for seed, (name, tags) in enumerate(files.items()):
        told = focal_px.get(name, 1200.0) if isinstance(focal_px, dict) else focal_px or 1200.0
        shade = Image.new("RGB", SIZE, (seed, 90, 120))  # no two files alike
        shade.save(where / name, **({} if tags is None else {"exif": tags}))
        tilt = pitch + 0.05 * (seed % 4)
        people, _ = photo(seed, 5, pitch=tilt, height_m=4.0 if pitch > 0.1 else 1.6, depths_m=(5, 14),
                          camera=Camera.centred(told, *SIZE))  # fmt: skip
        points = np.concatenate([people.keypoints_px, people.scores[..., None]], axis=-1)
        images.append({"filename": name, "width": SIZE[0], "height": SIZE[1],
                       "people": [{"keypoints": np.nan_to_num(p).tolist()} for p in points]})  # fmt: skip
    (where.parent / f"{where.name}.json").write_text(json.dumps({"skeleton": "coco17", "images": images}))
    return where


def measured(where: Path, out: Path, jobs=0, **settings):
    """Measure a folder and return its rows by name, without what the clock says."""
    told = Settings(lines=False, **settings)
    run([str(where)], Job(str(out), f"recorded:{where}.json", settings=told), jobs=jobs)
    return rows_of(out)


def rows_of(out: Path):
    return {s.photo: s for s in Results.open(out).scenes()}


def numbers(rows):
    """Return all that must not depend on the way: cameras and distances."""
    return {name: (str(s.camera.source), s.camera.camera and round(s.camera.camera.f_px, 6),
                   [str(f) for f in s.camera.flags], np.nan_to_num(np.round(s.distances.distance_m, 6)).tolist())
            for name, s in rows.items()}  # fmt: skip


DONORS = {f"a{k}.jpg": exif(10 + k, round((10 + k) * CROP)) for k in range(4)}


def test_others_of_the_model_tell_the_sensor(tmp_path):
    where = folder_of(tmp_path / "photos", {**DONORS, "b.jpg": exif(17.0), "c.jpg": exif(17.0, model="N-2")})
    rows = measured(where, tmp_path / "out")
    told = rows["b.jpg"].camera
    assert told.source.kind is FocalSource.SAME_CAMERA and "4 of N-1" in str(told.source)
    assert told.camera.f_px == pytest.approx(px_of(17.0), rel=0.03) and 0.03 <= told.camera.focal_rel_sd < 0.06
    assert rows["c.jpg"].camera.source.kind is not FocalSource.SAME_CAMERA  # another model
    assert rows["a0.jpg"].camera.source.kind is FocalSource.EQUIVALENT
    alone = measured(where, tmp_path / "alone", other_photos=False)
    assert alone["b.jpg"].camera.source.kind is not FocalSource.SAME_CAMERA
    assert not (tmp_path / "alone" / "cameras.json").exists()


def test_too_few_and_those_who_disagree_tell_nothing(tmp_path):
    two = dict(list(DONORS.items())[:2])
    where = folder_of(tmp_path / "few", {**two, "b.jpg": exif(17.0)})
    assert measured(where, tmp_path / "out1")["b.jpg"].camera.source.kind is not FocalSource.SAME_CAMERA
    phones = {f"p{k}.jpg": exif(2.0 + 2 * (k % 2), 13 + 64 * (k % 2)) for k in range(6)}  # a sensor for each lens
    where = folder_of(tmp_path / "phones", {**phones, "b.jpg": exif(3.0), "d.jpg": exif(4.0)})
    rows = measured(where, tmp_path / "out2")
    assert rows["b.jpg"].camera.source.kind is not FocalSource.SAME_CAMERA
    assert rows["d.jpg"].camera.camera.f_px == pytest.approx(77 / DIAGONAL_35MM * math.hypot(*SIZE), rel=0.03)


@pytest.mark.parametrize("counts", [True, False])
def test_others_tell_whether_the_equivalent_counts_the_zoom(tmp_path, counts):
    true_mm = 12 * CROP * 2
    zoomed = exif(12.0, round(true_mm if counts else true_mm / 2), zoom=2.0)
    where = folder_of(tmp_path / "photos", {**DONORS, "z.jpg": zoomed})
    told = measured(where, tmp_path / "out")["z.jpg"].camera.camera
    right = true_mm / DIAGONAL_35MM * math.hypot(*SIZE)
    assert told.f_px == pytest.approx(right, rel=0.04) and told.focal_rel_sd < 0.08
    alone = measured(where, tmp_path / "alone", other_photos=False)["z.jpg"].camera.camera
    assert alone.focal_rel_sd > 0.3  # either way


def test_a_photo_without_any_focal_length_is_as_others_of_its_model(tmp_path):
    fixed = {f"a{k}.jpg": exif(12.0, 24) for k in range(6)}
    where = folder_of(tmp_path / "fixed", {**fixed, "b.jpg": exif()})
    told = measured(where, tmp_path / "out1")["b.jpg"].camera
    right = 24 / DIAGONAL_35MM * math.hypot(*SIZE)
    assert told.source.kind is FocalSource.SAME_CAMERA and not told.is_assumed
    assert abs(math.log(told.camera.f_px / right)) < 1.645 * told.camera.focal_rel_sd
    zooms = {f"a{k}.jpg": exif(8.0 * 1.6**k, round(16 * 1.6**k)) for k in range(6)}
    where = folder_of(tmp_path / "zooms", {**zooms, "b.jpg": exif()})
    told = measured(where, tmp_path / "out2")["b.jpg"].camera
    assert told.is_assumed and 2 * 1.645 * told.camera.focal_rel_sd > math.log(WIDEST_RATIO)


SHOOT = {f"s{k:02d}.jpg": None for k in range(14)}


def test_one_shoot_is_told_by_all_its_people(tmp_path, capsys):
    files = {**SHOOT, "odd.jpg": None}
    where = folder_of(tmp_path / "photos", files, {"odd.jpg": 2900.0}, pitch=0.3)
    Image.new("RGB", (900, 600)).save(where / "other_size.jpg")
    argv = ["measure", str(where), "--pose", f"recorded:{where}.json", "--jobs", "0", "--no-lines"]
    assert main([*argv, "--same-camera", "--out", str(tmp_path / "out")]) in (0, 1)
    said = capsys.readouterr().err
    assert "photos of 1920 x 1080 pixels without a focal length" in said
    assert "of another camera or zoom by their people: odd.jpg" in said
    assert main(["summary", str(tmp_path / "out")]) == 0
    assert "photos of 1920 x 1080 pixels without a focal length" in " ".join(capsys.readouterr().out.split())
    assert main(["report", str(tmp_path / "out")]) == 0
    assert "of another camera or zoom by their people: odd.jpg" in (tmp_path / "out" / "report.html").read_text()
    rows = rows_of(tmp_path / "out")
    for name in SHOOT:
        told = rows[name].camera
        assert str(told.source) == "estimated from the people of 14 photos"
        low, high = (told.camera.f_px * math.exp(s * 1.645 * told.camera.focal_rel_sd) for s in (-1, 1))
        assert low < 1200 < high and any("14 photos" in str(flag) for flag in told.flags)
        assert told.mount is None  # nothing but shades behind them: nobody can say that the camera stayed
    odd = rows["odd.jpg"].camera
    assert odd.source.kind is not FocalSource.PEOPLE_OF_PHOTOS
    assert any("not of the same camera" in str(flag) for flag in odd.flags)
    assert main([*argv, "--out", str(tmp_path / "alone")]) in (0, 1)
    assert rows_of(tmp_path / "alone")["s00.jpg"].camera.source.kind is not FocalSource.PEOPLE_OF_PHOTOS


def test_a_level_shoot_says_that_its_people_do_not_tell(tmp_path):
    where, said = folder_of(tmp_path / "photos", SHOOT, pitch=0.0), []
    job = Job(str(tmp_path / "out"), f"recorded:{where}.json", settings=Settings(lines=False, same_camera=True))
    run([str(where)], job, jobs=0, on_progress=lambda told: said.append(getattr(told, "text", "")))
    assert any("leave it open" in text for text in said)
    assert any("leave it open" in text for text in shoots_in_words(Folder(tmp_path / "out")))
    assert all(s.camera.source.kind is not FocalSource.PEOPLE_OF_PHOTOS for s in rows_of(tmp_path / "out").values())


def test_a_folder_without_a_shoot_is_told_so(tmp_path):
    where, said = folder_of(tmp_path / "photos", dict(list(SHOOT.items())[:2]), pitch=0.3), []
    job = Job(str(tmp_path / "out"), f"recorded:{where}.json", settings=Settings(lines=False, same_camera=True))
    run([str(where)], job, jobs=0, on_progress=lambda told: said.append(getattr(told, "text", "")))
    assert any("--same-camera had no effect: no 3 photos of one size" in text for text in said)


def test_a_camera_that_stayed_tells_its_place_to_the_photos_taken_there(tmp_path):
    where = folder_of(tmp_path / "photos", SHOOT, pitch=0.3)
    rng = np.random.default_rng(0)
    blocks = rng.integers(0, 255, (27, 48, 3)).astype(np.uint8)
    wall = Image.fromarray(np.kron(blocks, np.ones((40, 40, 1), np.uint8)))
    images = json.loads(Path(f"{where}.json").read_text())
    still = [photo(k, 5, pitch=0.3, height_m=4.0, depths_m=(5, 14), camera=Camera.centred(1200, *SIZE))[0]
             for k in range(14)]  # fmt: skip
    for image, people in zip(images["images"], still, strict=True):
        points = np.concatenate([people.keypoints_px, people.scores[..., None]], axis=-1)
        image["people"] = [{"keypoints": np.nan_to_num(p).tolist()} for p in points]
    Path(f"{where}.json").write_text(json.dumps(images))
    for k, name in enumerate(SHOOT):
        shifted = 0 if k != 5 else 200
        Image.fromarray(np.roll(np.asarray(wall), shifted, axis=1)).save(where / name, quality=90 + k % 5)
    rows = measured(where, tmp_path / "out", same_camera=True)
    at = {name: s.camera.mount for name, s in rows.items()}
    assert at["s05.jpg"] is None and all(mount is not None for name, mount in at.items() if name != "s05.jpg")
    assert abs(math.log(at["s00.jpg"].height_m / 4.0)) < 3 * at["s00.jpg"].sd[2]
    assert abs(at["s00.jpg"].pitch_rad - 0.3) < 3 * at["s00.jpg"].sd[0]
    assert rows["s05.jpg"].camera.source.kind is FocalSource.PEOPLE_OF_PHOTOS  # the lens is the same


def test_whatever_the_order_and_wherever_it_was_stopped(tmp_path, monkeypatch):
    shoot = dict(list(SHOOT.items())[:6])
    where = folder_of(tmp_path / "photos", {**DONORS, "b.jpg": exif(17.0), **shoot}, pitch=0.3)
    whole = numbers(measured(where, tmp_path / "whole", same_camera=True))
    assert numbers(measured(where, tmp_path / "whole", same_camera=True)) == whole  # nothing is left to do
    assert numbers(measured(where, tmp_path / "two", jobs=2, same_camera=True)) == whole

    def stopped(*args, **kwargs):
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:  # between the passes
        patch.setattr(run_module, "write_pool", stopped)
        with pytest.raises(KeyboardInterrupt):
            measured(where, tmp_path / "between", same_camera=True)
    assert numbers(measured(where, tmp_path / "between", same_camera=True)) == whole

    written, there = parts.write, [0]
    n_parts = len(parts.names_of(Results.open(tmp_path / "whole").folder))

    def some(*args, **kwargs):
        there[0] += 1
        if there[0] == n_parts + 4:
            raise KeyboardInterrupt
        written(*args, **kwargs)

    with monkeypatch.context() as patch:  # within the second
        patch.setattr(parts, "write", some)
        with pytest.raises(KeyboardInterrupt):
            measured(where, tmp_path / "within", same_camera=True)
    assert numbers(measured(where, tmp_path / "within", same_camera=True)) == whole

    part_of_them = tmp_path / "part"  # photos that come later are asked and tell
    part_of_them.mkdir()
    for name in ("b.jpg", *list(shoot)[:3]):
        shutil.copy2(where / name, part_of_them / name)
    shutil.copy2(f"{where}.json", f"{part_of_them}.json")
    measured(part_of_them, tmp_path / "later", same_camera=True)
    for name in (*DONORS, *shoot):
        shutil.copy2(where / name, part_of_them / name)
    assert numbers(measured(part_of_them, tmp_path / "later", same_camera=True)) == whole


def test_values_survive_their_files():
    shoot = SameShoot(7.1, 0.1, 12, 5)
    assert shoot_from_dict(json.loads(json.dumps(shoot_to_dict(shoot)))) == shoot
    assert Settings.from_dict(Settings(same_camera=True, other_photos=False).to_dict()).same_camera


def test_a_database_that_knows_the_sensor_knows_better():
    model = SameModel("Canon", "Canon EOS 6D", (CropRange(50.0, 1.5, 1.5, 9),))
    known = Photo("a", 5472, 3648, "", Metadata(make="Canon", model="Canon EOS 6D", focal_mm=50.0))
    estimate = estimate_camera(known, None, Others(model))
    assert estimate.source.kind is FocalSource.CROP_FACTOR and len(estimate.candidates) == 1


def test_crops_are_told_by_the_same_lens_first():
    model = SameModel("P", "Phone", (CropRange(2.2, 5.9, 5.95, 4), CropRange(6.8, 3.5, 3.55, 9)))
    assert model.crop_at(6.81).photos == 9 and model.crop_at(2.2).low == 5.9
    assert model.crop_at(4.0) is None
    one = SameModel("C", "Zoom", (CropRange(10.0, 1.99, 2.01, 1), CropRange(30.0, 1.98, 2.0, 2)))
    assert one.crop_at(20.0).photos == 3


def test_what_is_told_of_many_photos_is_encoded_once(monkeypatch):
    background = np.random.default_rng(0).integers(0, 255, (270, 480), dtype=np.uint8)
    pool = CameraPool({}, {SIZE: Shoot(SameShoot(math.log(1200.0), 0.1, 30, 4), "said", background)})
    asked = []
    monkeypatch.setattr(Shoot, "to_dict", lambda shoot, real=Shoot.to_dict: asked.append(1) or real(shoot))
    row = {"camera_make": None, "camera_model": None, "own_focal": "none", "width_px": 1080, "height_px": 1920}
    assert len({pool.digest_for(row) for _ in range(50)} - {""}) == 1
    assert len(asked) == 1
    assert pool.digest_for({**row, "width_px": 1081}) == ""
    other = CameraPool({}, {SIZE: Shoot(SameShoot(math.log(1300.0), 0.1, 30, 4), "said", background)})
    assert other.digest_for(row) != pool.digest_for(row)
