"""For all tests: hypothesis measures laws, not the machine's speed, and tries the same examples on every run of CI."""

import os

from hypothesis import settings

settings.register_profile("laws", deadline=None, print_blob=True)
settings.register_profile("ci", parent=settings.get_profile("laws"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "laws")
