"""The methods paragraph says what was run: whatever option changes numbers changes the paragraph."""

from __future__ import annotations

from dataclasses import replace

import pytest

import proxemetry as px
from proxemetry.archive.figures.methods import ground_in_words, methods_paragraph
from proxemetry.archive.store.folder import Folder
from proxemetry.scene import Scene
from synthetic.reviewing import make_results, write_results


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    return make_results(tmp_path_factory.mktemp("made")).folder


def _said(tables: Folder, settings: px.Settings) -> str:
    return methods_paragraph({"version": "1", "pose": "drawn", "settings": settings.to_dict()}, tables)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (px.Settings(), "as 5% of all, children (ANSUR II and CDC"),
        (px.Settings(locate=px.LocateSettings(child_weight=0.3)), "as 30% of all, children"),
        (px.Settings(locate=px.LocateSettings("women")), "of women (ANSUR II body"),
        (px.Settings(locate=px.LocateSettings("men")), "of men (ANSUR II body"),
        (px.Settings(locate=px.LocateSettings("adults")), "of adults (ANSUR II body"),
        (px.Settings(locate=px.LocateSettings("children")), "children aged 2 to 14 (CDC"),
        (px.Settings(locate=px.LocateSettings(floor="none")), "without a shared floor"),
        (px.Settings("torso"), "Seker et al. 2021, torso)"),
        (px.Settings("combined"), "nearest (Seker et al. 2021, combined)."),
        (
            px.Settings("torso", px.LocateSettings(quirks={"code-torso-length"})),
            "published code's peculiarities code-torso-length",
        ),
        (px.Settings(undistort=False), "Lens distortion was not corrected."),
        (px.Settings(lines=False), "Straight lines in the pictures were not used."),
        (px.Settings(other_photos=False, drone=False), "by itself, without evidence from others"),
        (px.Settings(same_camera=True), "of one camera and lens, size by size"),
    ],
)
def test_an_option_that_changes_numbers_is_named(tables, settings, said):
    paragraph = _said(tables, settings)
    assert said in paragraph
    if settings != px.Settings():
        assert paragraph != _said(tables, px.Settings())


def test_a_floor_that_was_not_shared_is_not_said_to_be(tables):
    assert "on a shared floor" in _said(tables, px.Settings())
    assert "on a shared floor" not in _said(tables, px.Settings(locate=px.LocateSettings(floor="none")))


def test_a_paragraph_tells_how_many_distances_are_along_the_ground():
    assert ground_in_words(0.996) == "along the ground"
    assert ground_in_words(0.004).startswith("in space")
    assert ground_in_words(0.55) == "along the ground for 55 % of the pairs, in space for the rest"


def test_no_switch_of_the_settings_is_forgotten(tables):
    """A switch that comes to `Settings` later must come to the paragraph as well."""
    usual = px.Settings()
    for name in [name for name, value in vars(usual).items() if isinstance(value, bool)]:
        turned = replace(usual, **{name: not getattr(usual, name)})
        assert _said(tables, turned) != _said(tables, usual), name


def test_copies_are_told_and_photos_without_a_hash_are_none(tmp_path):
    photos = tmp_path / "photos"
    scenes = [Scene.failed(f"{k}.jpg", "cannot be read") for k in range(3)]
    scenes += [replace(Scene.failed(f"{k}.jpg", "cut short"), sha256="ab" * 32) for k in range(3, 5)]
    photos.mkdir()
    for scene in scenes:
        (photos / scene.photo).write_bytes(b"cut short")
    said = _said(write_results(tmp_path / "results", photos, scenes).folder, px.Settings())
    assert "Of the photographs, 5 could not be read; 1 is the same file as another." in said
