"""Every error that proxemetry raises on purpose.

A message says what is wrong, where, and what to do. The command line prints it as one line; a batch writes it
into the row of the photo it belongs to. Anything else that escapes is a bug and shows its traceback.
"""


class ProxemetryError(Exception):
    """The root: catching it catches all that is not a bug."""


class PhotoError(ProxemetryError):
    """A photo cannot be read or decoded."""


class CameraError(ProxemetryError):
    """What is stated of a camera contradicts itself or cannot be used."""


class KeypointsError(ProxemetryError):
    """A file of keypoints or a pose back end's answer is malformed."""


class ModelError(ProxemetryError):
    """A network's file is absent, damaged or may not be fetched."""


class LabelsError(ProxemetryError):
    """A benchmark's label or prediction file is malformed."""


class SettingsError(ProxemetryError):
    """Options contradict each other or name something that does not exist."""


class OutputError(ProxemetryError):
    """A result cannot be written, or a results folder cannot be read."""
