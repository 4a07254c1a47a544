"""What decides about a focal length is a type; its words are for print, and mean what the type does."""

from __future__ import annotations

import json

import pytest

from proxemetry.camera import Camera, CameraEstimate, Doubt, Flag, FocalBasis, FocalSource, Source


@pytest.mark.parametrize("kind", FocalSource)
def test_a_source_says_assumed_where_it_is_a_guess_and_nowhere_else(kind: FocalSource) -> None:
    assert kind.is_assumed == str(Source(kind, "x")).startswith("ASSUMED")
    assert kind.is_stated + kind.is_recorded + kind.is_assumed <= 1


def test_a_plain_text_is_the_users_word_and_decides_nothing() -> None:
    camera = Camera.centred(1000, 640, 480, source="ASSUMED, they say")
    assert camera.source == Source(FocalSource.USER, "ASSUMED, they say")
    assert not CameraEstimate(camera).is_assumed
    assert CameraEstimate(camera.with_focal(900, source=Source(FocalSource.ASSUMED_FOV, "60 degrees"))).is_assumed


def test_words() -> None:
    assert str(Source(FocalSource.USER)) == "user"
    assert str(Source(FocalSource.USER, "focal length in pixels")) == "user: focal length in pixels"
    assert str(Source(FocalSource.CAMERA_TABLE, "line 3: focal length")) == "camera table line 3: focal length"
    reviewed = Source(FocalSource.ASSUMED_EQUIVALENT, "35 mm", reviewed=True)
    assert str(reviewed) == "review: ASSUMED: 35 mm equivalent 35 mm" and reviewed.is_assumed


@pytest.mark.parametrize("source", [Source(kind, "x", reviewed=True) for kind in FocalSource])
def test_a_source_survives_json(source: Source) -> None:
    written = json.dumps({"kind": source.kind, "detail": source.detail, "reviewed": source.reviewed})
    assert Source.from_dict(json.loads(written)) == source
    with pytest.raises(ValueError, match="tarot"):
        Source.from_dict({"kind": "tarot", "detail": "", "reviewed": False})


def test_a_new_focal_length_settles_doubts_about_the_old_one_alone() -> None:
    kept = {doubt for doubt in Doubt if not doubt.is_settled_by_focal}
    assert kept == {Doubt.CROPPED, Doubt.ZOOMED, Doubt.LENS, Doubt.PROJECTION, Doubt.MOUNT, Doubt.DEPTH, Doubt.OTHER}
    assert str(Flag(Doubt.CROPPED, "cropped (x)")) == "cropped (x)"


def test_every_source_rests_on_one_basis() -> None:
    for source in FocalSource:
        found = [source.is_stated, source.is_recorded, source.is_estimated, source.is_assumed]
        assert found.count(True) == 1
        assert list(FocalBasis)[found.index(True)] is source.basis
