"""What a run's numbers depend on: which settings make a results folder another one, field by field."""

from dataclasses import fields, replace

import pytest

from proxemetry.archive.run.joining import _packages, settings_of
from proxemetry.archive.run.work import Job
from proxemetry.pose import PoseOptions
from proxemetry.settings import Settings

JOB = Job("out")
#: How many threads a network may use, and whether it may be fetched, changes no number; whether pupils are looked for
#: follows from the method, which is in the identity.
WITHOUT_EFFECT = {"threads", "offline", "pupils"}
OTHER = {"effort": "fast", "threads": 7, "offline": True, "device": "gpu", "flip": True, "pupils": True}


def test_every_option_of_the_back_end_has_another_value_here():
    assert set(OTHER) == {field.name for field in fields(PoseOptions)}


@pytest.mark.parametrize("name", OTHER)
def test_an_option_that_changes_a_number_is_in_the_identity(name):
    changed = replace(JOB, options=replace(JOB.options, **{name: OTHER[name]}))
    assert (settings_of(changed) == settings_of(JOB)) == (name in WITHOUT_EFFECT)


@pytest.mark.parametrize(
    "changed",
    [replace(JOB, with_names=True), replace(JOB, with_gps=True), replace(JOB, settings=Settings("torso")),
     replace(JOB, settings=Settings(undistort=False))],
)  # fmt: skip
def test_so_is_what_changes_a_row(changed):
    assert settings_of(changed) != settings_of(JOB)


def test_run_json_names_the_lens_database_and_the_decoders():
    """Another version of any of them may give another focal length, or other pixels."""
    named = _packages()
    assert {"numpy", "pillow", "lensfunpy", "opencv-python-headless", "ai-edge-litert"} <= set(named)
    assert all(version for version in named.values())
