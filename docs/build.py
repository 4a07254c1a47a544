"""Build the site: `python docs/build.py [--strict]` writes site/, which opens from the folder and fetches nothing.

Its search needs a server: `python -m http.server -d site`.

The codebook is made from the tables' own definitions first. --strict fails where a link leads nowhere.
"""

import subprocess
import sys
from pathlib import Path

from proxemetry.clip.columns import codebook_page

ROOT = Path(__file__).resolve().parent.parent


def main() -> int:
    """Write the codebook and the site."""
    (ROOT / "docs" / "codebook.md").write_text(codebook_page(), encoding="utf-8")
    command = [sys.executable, "-m", "mkdocs", "build", "--config-file", str(ROOT / "mkdocs.yml")]
    return subprocess.run([*command, *sys.argv[1:]], cwd=ROOT, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
