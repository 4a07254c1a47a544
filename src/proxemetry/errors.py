"""Every error that proxemetry raises on purpose.

A message states what is wrong, where, and what to do. The command line prints it as one line; a batch writes it
into the row of the photo it belongs to. Anything else that escapes is a bug and shows its traceback.
"""

import re

#: Messages quote what is in files, which may be long, of several lines, or written to fool a terminal.
_LONGEST = 1000
_LINE_ENDS, _CONTROLS = re.compile(r"\s*[\r\n\v\f\x85\u2028\u2029]\s*"), re.compile(r"[\x00-\x1f\x7f-\x9f]")


class ProxemetryError(Exception):
    """The base class of every error that is not a bug. Its message is one line of at most 1,000 letters."""

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


def one_line(text: str) -> str:
    """Return a text as one line without control characters, its middle left out where it is long."""
    if len(text) > _LONGEST:
        text = f"{text[: _LONGEST * 2 // 3]} ... {text[-_LONGEST // 4 :]}"
    return _CONTROLS.sub(lambda found: repr(found[0])[1:-1], _LINE_ENDS.sub(" ", text).strip())


class PhotoError(ProxemetryError):
    """A photo cannot be read or decoded."""


class ClipError(ProxemetryError):
    """A clip cannot be read or decoded."""


class CameraError(ProxemetryError):
    """What is stated of a camera contradicts itself or cannot be used."""


class KeypointsError(ProxemetryError):
    """A file of keypoints or a pose back end's answer is malformed."""


class ModelError(ProxemetryError):
    """A network's file is absent, damaged or may not be fetched."""


class CacheError(ModelError):
    """Networks cannot be kept: no folder for them can be written, or the disk is full."""


class LabelsError(ProxemetryError):
    """A benchmark's label or prediction file is malformed."""


class SettingsError(ProxemetryError):
    """Options contradict each other or name something that does not exist."""


class AssumedFocalWarning(UserWarning):
    """A photo's focal length is unknown: its distances rest on those of published photos."""


class OutputError(ProxemetryError):
    """A result cannot be written, or a results folder cannot be read."""
