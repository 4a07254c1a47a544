"""A figure that stands on several pages is the same on all of them; scripts and options that pages name exist.

The first place of each figure is the table that the script named there prints; the others quote it.
"""

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
PAGES = sorted(path for path in (ROOT / "docs").glob("*.md") if path.stem not in ("cli", "api", "codebook"))

#: What is measured -> where it stands: a page, and a pattern that takes the number (a share of 0.96 is 96 %).
FIGURES = {
    "simulated settings, error": [
        ("docs/accuracy.md", r"^\| all \| 1561 \| ([\d.]+) "),
        ("README.md", r"simulated KORTE settings[^|]*\| ([\d.]+) %"),
    ],
    "simulated settings, coverage": [
        ("docs/accuracy.md", r"^\| all \| 1561 \| [\d.]+ \| \S+ \| (\d+) "),
        ("README.md", r"simulated KORTE settings[^|]*\| [\d.]+ %, (\d+) % in"),
        ("docs/modelcard.md", r"(\d+) % in simulated photos"),
    ],
    "simulated settings, combined": [
        ("docs/accuracy.md", r"^\| all \| 1561 (?:\|[^|]*){6}\| (\d+) \|"),
        ("README.md", r"simulated KORTE settings.*?(\d+) % for `combined` \("),
    ],
    "captured people, error": [
        ("docs/accuracy.md", r"captured_people.py`\): pairs ([\d.]+) % off"),
        ("README.md", r"six captured people[^|]*\| ([\d.]+) %"),
    ],
    "captured people, coverage": [
        ("docs/accuracy.md", r"common to all, and (\d+) % of pairs in"),
        ("README.md", r"six captured people[^|]*\| [\d.]+ %, (\d+) % in"),
        ("docs/limits.md", r"4 % too large together, and (\d+) % of pairs"),
        ("docs/modelcard.md", r"(\d+) % of six captured people"),
        ("README.md", r"where the assumptions do not: (\d+) %\s+for people of small build"),
    ],
    "KORTE v1, scene": [
        ("docs/benchmark.md", r"^\| scene \| \d+ \| \d+ \| ([\d.]+) "),
        ("docs/accuracy.md", r"mean error over images is ([\d.]+) %"),
        ("README.md", r"corrected protocol `v1` \| ([\d.]+) %"),
    ],
    "KORTE v1, scene, coverage": [
        ("docs/benchmark.md", r"^\| scene \| \d+ \| \d+ \|(?:[^|]*\|){5} (0\.\d+) "),
        ("docs/accuracy.md", r"mean error over images is [\d.]+ %, with (\d+) % of pairs"),
        ("README.md", r"corrected protocol `v1` \| [\d.]+ %, (\d+) % of pairs"),
        ("docs/modelcard.md", r"(\d+) % of KORTE's annotated pairs"),
    ],
    "KORTE v1, combined": [
        ("docs/benchmark.md", r"^\| combined \| \d+ \| \d+ \| ([\d.]+) "),
        ("docs/accuracy.md", r"torso and combined have ([\d.]+) %"),
        ("README.md", r"corrected protocol `v1` \|[^|]*\| ([\d.]+) %"),
    ],
    "KORTE v1, constant": [
        ("docs/benchmark.md", r"^\| 1.70 m for every pair \| 841 \| – \| ([\d.]+) "),
        ("docs/benchmark.md", r"under `seker2021` and ([\d.]+) % under `v1`"),
        ("docs/accuracy.md", r"constant answer 1.70 m has ([\d.]+) %"),
        ("README.md", r"corrected protocol `v1`.*?([\d.]+) % for 1.70 m"),
    ],
    "KORTE seker2021, constant": [
        ("docs/benchmark.md", r"for every pair scores ([\d.]+) % under `seker2021`"),
        ("README.md", r"under the published protocol.*?([\d.]+) % for 1.70 m"),
    ],
    "KORTE v1, nearest": [
        ("docs/benchmark.md", r"^\| 0 to 1 \| 33 \| ([\d.]+) "),
        ("README.md", r"less than 1 m apart \| ([\d.]+) %"),
    ],
    "a mast, uncalibrated, error": [
        ("docs/fixed_cameras.md", r"each frame by itself \| ([\d.]+) %"),
        ("README.md", r"each frame by itself \| ([\d.]+) %"),
        ("docs/limits.md", r"too\s+low: pairs are ([\d.]+) % off"),
    ],
    "a mast, uncalibrated, coverage": [
        ("docs/fixed_cameras.md", r"each frame by itself \|[^|]*\|[^|]*\|[^|]*\| (\d+) %"),
        ("README.md", r"each frame by itself \| [\d.]+ %, (\d+) %"),
        ("docs/limits.md", r"mostly too far, and intervals hold (\d+) %"),
        ("docs/modelcard.md", r"and (\d+) % under a camera on a\s+mast"),
    ],
    "a mast, from people": [
        ("docs/fixed_cameras.md", r"people of 200 frames, focal length known \| ([\d.]+) %"),
        ("README.md", r"each frame by itself \|[^|]*\| ([\d.]+) %, \d+ % with the camera estimated"),
    ],
    "a mast, from people, coverage": [
        ("docs/fixed_cameras.md", r"people of 200 frames, focal length known (?:\|[^|]*){3}\| (\d+) %"),
        ("README.md", r"each frame by itself \|[^|]*\| [\d.]+ %, (\d+) % with the camera estimated"),
    ],
    "a mast, four points": [
        ("docs/fixed_cameras.md", r"four points, focal length known \| ([\d.]+) %"),
        ("README.md", r"each frame by itself .*?([\d.]+) %, \d+ % with four points"),
    ],
    "odd postures, lying": [
        ("docs/accuracy.md", r"^\| lying (?:\|[^|]*){2}\| (\d+) \|"),
        ("docs/limits.md", r"(\d+) % are inside their interval instead\s+of 90"),
    ],
    "odd postures, child": [
        ("docs/accuracy.md", r"^\| child \| ([\d.]+) "),
        ("docs/limits.md", r"too far away \((\d+) % in simulations\)"),
    ],
    "shoulder's intervals": [
        ("docs/accuracy.md", r"^\| `shoulder` \| (\d+),"),
        ("docs/limits.md", r"`shoulder` hold (\d+) %"),
    ],
    "pupil's intervals": [
        ("docs/accuracy.md", r"^\| `pupil` \| (\d+),"),
        ("docs/limits.md", r"`pupil` (\d+) %"),
    ],
    "again, yolox-tinypose": [
        ("docs/backends_measured.md", r"\| `yolox-tinypose` \| \*\*all of its own\*\* \| \d+ \| (\d+) "),
        ("README.md", r"measured again[^|]*\| (\d+) %"),
        ("docs/limits.md", r"\(`yolox-tinypose`: (\d+) %\)"),
    ],
    "again, nanodet-movenet": [
        ("docs/backends_measured.md", r"\| `nanodet-movenet` \| \*\*all of its own\*\* \| \d+ \| (\d+) "),
        ("README.md", r"measured again[^|]*\| \d+ % \(`yolox-tinypose`\), (\d+) %"),
    ],
    "again, blazepose": [
        ("docs/backends_measured.md", r"\| `blazepose` \| \*\*all of its own\*\* \| \d+ \| (\d+) "),
        ("docs/limits.md", r"after a change, (\d+) % of its second answers"),
    ],
}

#: The first table of docs/backends.md: its row -> the row of docs/backends_measured.md that each column quotes.
SUMMARY = {
    "clear people found, of 52": r"^\| `{name}` normal \| (\d+) of 52 ",
    r"hard people found \(small, hidden, cut\), of 27": r"^\| `{name}` normal \|[^|]*\| (\d+) of 27 ",
    "found twice; false people": r"^\| `{name}` normal (?:\|[^|]*){{2}}\| (\d+) \| (\d+) ",
    "same photo, changed and measured again[^|]*": r"^\| `{name}` \| \*\*all of its own\*\* \| \d+ \| (\d+) ",
    "people under a camera on a mast[^|]*": r"^\| `{name}` (?:\| [\d.]+ %? ?){{4}}\| ([\d.]+) % [^|]*\| (\d+) ",
    "rendered people seen from above[^|]*": r"^\| all \| `{name}` (?:\|[^|]*){{4}}\| ([\d.]+) % \| (\d+) ",
}


def _values(page: str, pattern: str) -> list[float]:
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(pattern.replace(" ", r"\s+"), text, re.MULTILINE | re.DOTALL)  # wherever lines are broken
    assert found, f"{page} has no {pattern}"
    return [100 * float(text) if text.startswith("0.") else float(text) for text in found[:1]]


@pytest.mark.parametrize("what", FIGURES)
def test_a_figure_is_the_same_wherever_it_stands(what: str) -> None:
    (page, pattern), *others = FIGURES[what]
    (measured,) = _values(page, pattern)
    for other, other_pattern in others:
        (quoted,) = _values(other, other_pattern)
        exact = quoted == pytest.approx(measured, abs=1e-9)
        assert exact or quoted == round(measured), f"{what}: {measured} on {page}, {quoted} on {other}"


@pytest.mark.parametrize("row", SUMMARY)
@pytest.mark.parametrize("column", range(3))
def test_the_summary_of_back_ends_quotes_the_tables(row: str, column: int) -> None:
    page = (ROOT / "docs" / "backends.md").read_text(encoding="utf-8")
    record = (ROOT / "docs" / "backends_measured.md").read_text(encoding="utf-8")
    names = re.findall(r"`([a-z-]+)`", page[page.index("| | `") :].partition("\n")[0])
    summary = re.search(rf"^\| {row} \|(.*)\|$", page, re.MULTILINE)
    measured = re.search(SUMMARY[row].format(name=names[column]), record, re.MULTILINE)
    assert summary is not None and measured is not None
    cell = summary.group(1).split("|")[column]
    assert tuple(re.findall(r"[\d.]+", cell)) == measured.groups(), (row, names[column])


def test_the_summary_of_back_ends_rounds_their_times() -> None:
    page = (ROOT / "docs" / "backends.md").read_text(encoding="utf-8")
    record = (ROOT / "docs" / "backends_measured.md").read_text(encoding="utf-8")
    names = re.findall(r"`([a-z-]+)`", page[page.index("| | `") :].partition("\n")[0])
    row = re.search(r"^\| processor time for a photo \|(.*)\|$", page, re.MULTILINE)
    times_ms = [re.search(rf"^\| `{name}` normal \|.*\| (\d+) \| \d+ \|$", record, re.MULTILINE) for name in names]
    assert row is not None and all(times_ms)
    assert re.findall(r"[\d.]+", row.group(1)) == [f"{int(found.group(1)) / 1000:.1f}" for found in times_ms if found]


def test_people_found_are_the_same_in_the_readme_and_on_the_page() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    page = (ROOT / "docs" / "backends_measured.md").read_text(encoding="utf-8")
    quoted = re.findall(r"(\d+), (\d+), (\d+), (\d+) \(`([a-z-]+)`\)", readme)
    assert len(quoted) == 2
    for *numbers, name in quoted:
        row = re.search(
            rf"^\| `{name}` normal \| (\d+) of \d+ \| (\d+) of \d+ \| (\d+) \| (\d+) \|", page, re.MULTILINE
        )
        assert row is not None and list(row.groups()) == numbers


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda p: p.name)
def test_scripts_that_are_named_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for path in re.findall(r"`((?:benchmarks|examples|synthetic|tests)/[\w/.]+\.\w+)", text):
        assert (ROOT / path).exists(), path
    for module in re.findall(r"python -m ((?:benchmarks|synthetic|docs)\.[\w.]+)", text):
        assert importlib.util.find_spec(module) is not None, module
