"""Names in letters that matplotlib's font lacks are drawn from a font that has them, or spelled; never as boxes."""

import logging
import math
import warnings
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.ft2font import FT2Font
from PIL import Image

from proxemetry import plots
from proxemetry.archive.figures import charts
from proxemetry.archive.figures.summary import Group, Share, Summary
from proxemetry.camera import Camera, CameraEstimate
from proxemetry.measure import Settings, place
from proxemetry.plots import fonts
from proxemetry.plots.figure import ShownFigure
from synthetic.drawn import people_at

FAMILY, HAS = "Made Up Sans", "日本"
TRIP = "日本/Ausflug für 🦩 é.jpg"
HARD = "two\nlines\tand\rmore $^$ of\u3000them.jpg"


def _forget() -> None:
    for cached in (fonts._speller, fonts._is_in, fonts._letters, fonts._family_of, fonts._coverage):
        cached.cache_clear()


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    """Keep the fonts of one test from another."""
    known = list(fontManager.ttflist)
    _forget()
    yield
    fontManager.ttflist[:] = known
    _forget()


@pytest.fixture
def bare(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have no fonts but those that come with matplotlib."""
    fontManager.ttflist[:] = [entry for entry in fontManager.ttflist if "mpl-data" in entry.fname]
    monkeypatch.setattr(fonts.font_manager, "findSystemFonts", lambda: [])


@pytest.fixture
def with_font(bare: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have one more, installed since matplotlib listed its fonts: a square for each of two letters."""
    builder = FontBuilder(1000, isTTF=True)
    names = [".notdef", *(f"uni{ord(letter):04X}" for letter in HAS)]
    pen = TTGlyphPen(None)
    for k, corner in enumerate(((100, 0), (100, 700), (800, 700), (800, 0))):
        (pen.lineTo if k else pen.moveTo)(corner)
    pen.closePath()
    square = pen.glyph()
    builder.setupGlyphOrder(names)
    builder.setupCharacterMap({ord(letter): name for letter, name in zip(HAS, names[1:], strict=True)})
    builder.setupGlyf(dict.fromkeys(names, square))
    builder.setupHorizontalMetrics(dict.fromkeys(names, (900, 100)))
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": FAMILY, "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    path = tmp_path / "made_up.ttf"
    builder.save(path)
    monkeypatch.setattr(fonts.font_manager, "findSystemFonts", lambda: [str(path), str(tmp_path / "gone.ttf")])


def _drawn(text: str, size: float = 20) -> np.ndarray:
    figure = Figure(figsize=(3, 0.5), dpi=80)
    canvas = FigureCanvasAgg(figure)
    figure.text(0.05, 0.3, text, size=size)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fonts.use_known_letters(figure)
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())


@pytest.mark.usefixtures("bare")
def test_what_no_font_has_is_spelled() -> None:
    assert fonts.drawable("plain $5") == "plain $5"
    assert fonts.drawable("Äpfel, Ελλάδα, Москва – ½") == "Äpfel, Ελλάδα, Москва – ½"
    assert fonts.drawable("日本 a") == r"\u65e5\u672c a"
    assert fonts.drawable("\U0001fae0") == r"\U0001fae0"
    assert fonts.drawable("x\ufe0f\u2060y") in ("xy", "x\ufe0f\u2060y")  # signs without a look of their own
    assert (_drawn("日") == _drawn(r"\u65e5")).all()


@pytest.mark.usefixtures("with_font")
def test_a_font_that_has_the_letters_is_used() -> None:
    assert fonts.drawable("日本語") == r"日本\u8a9e"
    figure = Figure()
    text = figure.text(0, 0, "日 a")
    fonts.use_known_letters(figure)
    assert text.get_text() == "日 a"
    assert list(text.get_fontfamily())[-1] == FAMILY
    square = _drawn("日")
    assert (square[..., 0] < 128).sum() > 100
    assert (square == _drawn("本")).all()


@pytest.mark.usefixtures("with_font")
def test_a_font_of_pictures_alone_is_no_help(monkeypatch: pytest.MonkeyPatch) -> None:
    def of_pictures(path: str) -> SimpleNamespace:
        return SimpleNamespace(scalable="made_up" not in path, get_charmap=FT2Font(path).get_charmap)

    monkeypatch.setattr(fonts, "FT2Font", of_pictures)
    assert fonts.drawable("日本") == r"\u65e5\u672c"


@pytest.mark.usefixtures("bare")
def test_letters_that_are_joined_are_spelled_where_matplotlib_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fonts, "_JOINS_LETTERS", True)
    assert fonts.drawable("حفل") == "حفل"
    _forget()
    monkeypatch.setattr(fonts, "_JOINS_LETTERS", False)
    assert fonts.drawable("حفل a") == r"\u062d\u0641\u0644 a"


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("ending", [".png", ".pdf", ".svg"])
@pytest.mark.parametrize("name, shown", [
    (TRIP, r"\u65e5\u672c/Ausflug für"), (HARD, r"two\nlines\tand\rmore \$^\$ of\u3000them.jpg"),
])  # fmt: skip
def test_a_figure_of_such_a_photo_says_nothing(
    name: str,
    shown: str,
    ending: str,
    tmp_path: Path,
    recwarn: pytest.WarningsRecorder,
    caplog: pytest.LogCaptureFixture,
) -> None:
    camera = Camera.centred(700, 640, 480)
    people = people_at([(-0.5, 0.0, 4.0), (0.5, 0.0, 4.0)], camera)
    scene = place(name, "", 640, 480, people, CameraEstimate(camera), Settings())
    figure = plots.overlay(scene, None)
    plots.save(figure, tmp_path / f"a{ending}")
    assert shown in " ".join(text.get_text() for text in figure.texts)
    assert not [w for w in recwarn if "lyph" in str(w.message)]
    assert not [r for r in caplog.records if r.levelno >= logging.WARNING]
    assert isinstance(figure, ShownFigure) and figure._repr_png_().startswith(b"\x89PNG")
    if ending == ".png":
        assert Image.open(tmp_path / "a.png").width > 300


@pytest.mark.usefixtures("bare")
def test_groups_by_such_names_say_nothing(tmp_path: Path) -> None:
    nothing = Share(math.nan, math.nan, math.nan)
    half = Share(0.5, 0.4, 0.6)
    groups = tuple(
        Group((name, year), 5, 5, 10, 5, {}, half, (half,) * 4, nothing)
        for name in ("日本", "Suomi", "京") for year in ("1990", "1991")
    )  # fmt: skip
    summary = Summary(("folder", "year"), groups, np.full(12, 1.5), np.repeat(np.arange(6), 2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(charts.draw(summary, tmp_path)) == 4
    (left, _) = charts.by_group(summary).axes
    assert left.get_yticklabels()[0].get_text().startswith(r"\u65e5\u672c, 1990")


def test_a_tab_is_spelled_whatever_fonts_have() -> None:
    assert fonts.drawable("a\tb\r\n\u2028") == r"a\tb\r\n\u2028"


def _summary(names: list[str]) -> Summary:
    """Return a summary by folder and year, of the folders of these names in two years each."""
    half = Share(0.5, 0.4, 0.6)
    groups = tuple(Group((n, year), 5, 5, 10, 5, {}, half, (half,) * 4, half) for n in names for year in ("90", "91"))
    return Summary(("folder", "year"), groups, np.full(2 * len(groups), 1.5), np.repeat(np.arange(len(groups)), 2))


def test_names_of_groups_are_no_formulas_and_none_is_left_out(tmp_path: Path) -> None:
    names = ["_hidden", "$^$", "a\tb"]
    assert len(charts.draw(_summary(names), tmp_path)) == 4
    (legend,) = charts.over_time(_summary(names), 1).legends
    assert [text.get_text() for text in legend.get_texts()] == ["_hidden", r"\$^\$", r"a\tb"]


def test_groups_that_a_figure_has_no_room_for_are_counted() -> None:
    summary = _summary([f"folder {k}" for k in range(20)])
    assert "24 groups with the most pairs; 16 more" in charts.by_group(summary).axes[0].get_xlabel()
    assert "6 groups with the most pairs; 14 more" in charts.over_time(summary, 1).axes[0].get_xlabel()
    assert "more" not in charts.by_group(_summary(["a"])).axes[0].get_xlabel()
