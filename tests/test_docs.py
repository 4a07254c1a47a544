"""The documentation: pictures and links that exist, options that exist, and a site that fetches nothing."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

from proxemetry.cli import COMMANDS
from proxemetry.clip.columns import codebook_page

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted((ROOT / "docs").glob("*.md"))
GUIDE = [ROOT / "docs" / f"{n}.md" for n in ("index", "quickstart", "review", "privacy", "modelcard", "data")]


def test_the_codebook_is_that_of_the_tables() -> None:
    assert (ROOT / "docs" / "codebook.md").read_text() == codebook_page()


@pytest.mark.parametrize("page", GUIDE, ids=lambda p: p.stem)
def test_links_and_pictures_lead_somewhere(page: Path) -> None:
    for text, target in re.findall(r"!?\[([^\]]*)\]\(([^)#]+)\)", page.read_text()):
        assert text, f"{target} has no words for who cannot see it"
        if not target.startswith("https://"):
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda p: p.stem)
def test_commands_that_are_named_exist(page: Path) -> None:
    for block in re.findall(r"^```\w*\n(.*?)^```", page.read_text(), re.M | re.S):
        for command in re.findall(r"^proxemetry ([a-z]+)", block, re.M):
            assert command in COMMANDS, command


def test_keys_of_the_guide_are_those_of_the_page() -> None:
    script = (ROOT / "src" / "proxemetry" / "web" / "static" / "dialogs.js").read_text()
    for key in re.findall(r"<kbd>(.+?)</kbd>", (ROOT / "docs" / "review.md").read_text()):
        # of the page as a whole, or of one of its questions
        listed = rf'\["{re.escape(key)}[" ]|, "{re.escape(key.lower())}"\]'
        assert key == "?" or re.search(listed, script), key


def test_the_site_builds_and_fetches_nothing(tmp_path: Path) -> None:
    if importlib.util.find_spec("material") is None:
        pytest.skip("mkdocs-material is not installed")
    site = ["build", "--strict", "-f", str(ROOT / "mkdocs.yml"), "-d", str(tmp_path)]  # a quiet one is not strict
    command = [sys.executable, "-m", "mkdocs", *site]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    pages = sorted(tmp_path.glob("*.html"))
    assert len(pages) >= len(GUIDE)
    for page in pages:
        text = page.read_text()
        fetched = re.findall(r"""<(?:script|link|img|iframe)[^>]+(?:src|href)=["']?(https?://[^"'\s>]+)""", text)
        assert fetched == [], page.name


@pytest.mark.parametrize(("page", "made"), [("cli", "cli_page"), ("api", "api_page")])
def test_the_reference_is_what_the_program_says(page: str, made: str) -> None:
    from docs import reference

    if sys.version_info[:2] != (3, 11):
        pytest.skip("argparse words its help otherwise in other versions of Python")
    written = (ROOT / "docs" / f"{page}.md").read_text()
    assert written == getattr(reference, made)(), "make it anew: python -m docs.reference"
