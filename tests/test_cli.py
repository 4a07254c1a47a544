"""What every command shares: refusals of one line, help, and the check of the installation."""

import re
import shlex

import pytest

from proxemetry.cli import COMMANDS, command_parser, main
from proxemetry.pose import BACKENDS


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["measur"], "measur"),
        (["measure", "photos", "--out", "o", "--method", "guess"], "scene"),
        (["measure", "photos", "--out", "o", "--focal-35mm", "4,25"], "write it like 28 or 4.25"),
        (["measure", "photos", "--out", "o", "--sensor-mm", "36"], "like 36x24"),
        (["models"], "list"),
        (["report", "results", "--photos", "many"], "many"),
    ],
)
def test_a_wrong_command_line_is_refused_in_one_line(arguments, said, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert len(err.splitlines()) == 1
    assert err.startswith("proxemetry") and said in err and "--help" in err


def test_no_command_shows_what_there_is(capsys):
    assert main([]) == 2
    said = capsys.readouterr().err
    assert all(command in said for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_help_teaches_by_examples(command, capsys):
    with pytest.raises(SystemExit) as stop:
        main([command, "--help"])
    assert stop.value.code == 0
    assert f"proxemetry {command}" in capsys.readouterr().out.partition("options:")[2]


@pytest.mark.parametrize("command", COMMANDS)
def test_the_examples_of_the_help_are_command_lines(command, capsys):
    with pytest.raises(SystemExit):
        main([command, "--help"])
    examples = re.findall(r"^  proxemetry (.+?)(?:  .*)?$", capsys.readouterr().out, re.MULTILINE)
    assert examples
    for example in examples:
        words = shlex.split(example)
        assert command_parser(words).parse_args(words).command in COMMANDS


def test_photos_may_be_named_after_options():
    words = ["figures", "results", "--within", "1.5", "frame_00*.jpg", "--kind", "circles", "b.jpg"]
    args = command_parser(words).parse_args(words)
    assert (args.results, args.photos, args.within) == ("results", ["frame_00*.jpg", "b.jpg"], 1.5)
    words = ["measure", "a.jpg", "--out", "o", "b.jpg"]
    assert command_parser(words).parse_args(words).paths == ["a.jpg", "b.jpg"]


@pytest.mark.parametrize("words", [["report", "results", "more"], ["measure", "a.jpg", "--colour", "b.jpg"]])
def test_what_no_command_takes_is_still_refused(words, capsys):
    with pytest.raises(SystemExit) as stop:
        command_parser(words).parse_args(words)
    assert stop.value.code == 2 and "unrecognized arguments" in capsys.readouterr().err


def test_doctor_without_photos_says_what_is_missing(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("PROXEMETRY_CACHE", str(tmp_path))
    assert main(["doctor"]) == 0
    out = capsys.readouterr().out
    assert str(tmp_path) in out
    assert "proxemetry models fetch" in out and all(name in out for name in BACKENDS["yolox-tinypose"].models)
