"""How far a run is, in a log file: every pass over the photos has its end and its own pace."""

import re

import pytest

from proxemetry.archive.run.schedule import Note, Progress
from proxemetry.cli import progress
from proxemetry.cli.progress import Reporter


def test_two_passes_each_end_and_are_timed_apart(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with Reporter() as report:
        for total, seconds in ((10, 2.0), (4, 1.0)):
            for done in range(total + 1):
                report(Progress(done, total, int(done > 5)))
                now[0] += seconds
            report(Note(f"{total} are done"))
    first, note, second, _ = capsys.readouterr().err.splitlines()
    assert re.search(r"10/10 photos, 0\.4\d photos/s, 1 failed$", first)
    assert note == "proxemetry: 10 are done"
    assert re.search(r"4/4 photos, 0\.80 photos/s$", second)


def test_a_run_that_is_stopped_tells_how_far_it_came(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KeyboardInterrupt), Reporter() as report:
        report(Progress(3, 10, 0))
        report(Note("by the way"))
        raise KeyboardInterrupt
    note, end = capsys.readouterr().err.splitlines()
    assert note == "proxemetry: by the way"
    assert " 3/10 photos" in end
