"""For all tests: hypothesis measures laws, not the machine's speed, and tries the same examples on every run of CI.

What is printed is as wide as in a file, whatever the width of the terminal that the tests run in.
"""

import os

import pytest
from hypothesis import settings

from proxemetry.text_tables import WIDTH

settings.register_profile("laws", deadline=None, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("laws"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "laws")


@pytest.fixture(autouse=True)
def as_wide_as_in_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let tables and sentences break where they do in a file."""
    monkeypatch.setenv("COLUMNS", str(WIDTH))
