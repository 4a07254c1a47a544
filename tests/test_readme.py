"""The README runs: its Python prints what it says, its commands exist, its links lead somewhere."""

import contextlib
import io
import re
from pathlib import Path

import pytest

from proxemetry.cli import COMMANDS

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]


def test_the_python_prints_what_is_printed_below_it(monkeypatch):
    monkeypatch.chdir(ROOT)
    found = re.search(r"```python\n(.*?)```\n\n```text\n(.*?)```", TEXT, re.DOTALL)
    assert found is not None
    code, expected = found.groups()
    assert len(code.strip().splitlines()) <= 10
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, "README.md", "exec"), {})
    assert printed.getvalue() == expected


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: p.name)
def test_every_command_named_exists(path):
    text = path.read_text(encoding="utf-8")
    blocks = "\n".join(re.findall(r"^```.*?^```", text, re.DOTALL | re.MULTILINE))
    named = set(re.findall(r"^(?:\S*/)?proxemetry ([a-z]+)\b", blocks, re.MULTILINE))
    named |= set(re.findall(r"`(?:\S*/)?proxemetry ([a-z]+)\b", text))
    assert named <= set(COMMANDS)


def test_the_makefile_has_the_two_commands():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"^make ([a-z]+)", TEXT, re.MULTILINE):
        assert f"\n{target}:" in makefile


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda p: p.name)
def test_links_within_the_repository_lead_somewhere(path):
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        if "://" not in target:
            assert (path.parent / target).exists(), f"{path.name} links to {target}"


def test_every_figure_of_the_first_table_stands_on_the_page_that_it_names():
    rows = re.findall(r"^\| (.*) \| \[[^\]]+\]\((docs/[a-z_]+\.md)\) \|$", TEXT, re.MULTILINE)
    assert len(rows) >= 8
    for row, page in rows:
        text = (ROOT / page).read_text(encoding="utf-8").replace(",", "")
        shares = {f"{float(number):.2f}" for number in re.findall(r"0\.\d+", text)}
        for number in re.findall(r"\d+(?:\.\d+)?(?= %)", row):
            as_share = f"{float(number) / 100:.2f}"
            rounded = any(f"{float(n):.1f}" == number for n in re.findall(r"\d+\.\d\d\b", text))
            assert number in text or as_share in shares or rounded, f"{number} % is not on {page}"
