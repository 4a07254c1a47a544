"""What is known of a photo's camera, in words: candidates, which is used and why, evidence, what is missing."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ..camera import CameraEstimate, Candidate, Doubt, Flag, Witness
from ..camera.sensors import equivalent_mm
from ..errors import one_line
from ..intervals import HALF_WIDTH_SD
from ..photo import Photo
from .camera_options import ASK_THE_PEOPLE

#: Wider intervals than this, as half widths of the logarithm, are no plus and minus.
_LOPSIDED = 0.2
#: How a doubt is introduced: what is set aside has lost to the answer, the others are doubts about it.
_INTRODUCED = {Doubt.CONTRADICTED: "set aside", Doubt.PROJECTION: "refused"}


def words_of(photo: Photo, estimate: CameraEstimate, people_asked: bool) -> list[str]:
    """Return what is known of a photo's camera as lines of text."""
    metadata = photo.metadata
    named = ", ".join(filter(None, (metadata.model or metadata.make, metadata.lens))) or "camera not named"
    return [
        one_line(f"{photo.name}: {photo.width} x {photo.height}, {named}"),
        *_candidates(photo, estimate),
        *_asked(estimate, people_asked),
        *_camera(estimate),
        *(f"  {_introduced(flag, estimate)}: {flag}" for flag in estimate.flags if not _is_said(flag)),
        *_missing(estimate),
    ]


def _candidates(photo: Photo, estimate: CameraEstimate) -> Iterator[str]:
    """Yield every answer to the focal length, with an arrow at the chosen one and the reason for it."""
    camera = estimate.camera
    chosen = next((k for k, c in enumerate(estimate.candidates) if camera and c.source == camera.source), None)
    for k, candidate in enumerate(estimate.candidates):
        rel_sd = camera.focal_rel_sd if camera is not None and k == chosen else candidate.rel_sd
        yield f"  {'->' if k == chosen else '  '} {_answer(photo, candidate, rel_sd)}  {candidate.source}"
        if k == chosen and estimate.why and (len(estimate.candidates) > 1 or estimate.testimony):
            yield f"              why: {estimate.why}"


def _answer(photo: Photo, candidate: Candidate, rel_sd: float) -> str:
    equivalent = equivalent_mm(candidate.focal_px, (photo.width**2 + photo.height**2) ** 0.5)
    half = HALF_WIDTH_SD * rel_sd
    if half < _LOPSIDED:
        width = f"+-{100 * half:3.0f} %"
    else:
        low, high = (candidate.focal_px * math.exp(sign * half) for sign in (-1, 1))
        width = f"({low:.0f} to {high:.0f})"
    return f"{candidate.focal_px:8.0f} px  {width}  (equivalent: {equivalent:.0f} mm)"


def _asked(estimate: CameraEstimate, people_asked: bool) -> Iterator[str]:
    """Yield what lines, people and published photos say, or why nothing."""
    said = {testimony.witness: str(testimony) for testimony in estimate.testimony}
    if Witness.PUBLISHED in said and not people_asked:
        said[Witness.PEOPLE] = f"{Witness.PEOPLE.words}: not looked for ({ASK_THE_PEOPLE})"
    elif Witness.PUBLISHED in said:
        said.setdefault(Witness.PEOPLE, f"{Witness.PEOPLE.words}: no one was found")
    for witness in (Witness.LINES, Witness.PEOPLE, Witness.PUBLISHED, Witness.GRAVITY):
        if witness in said:
            yield f"  {said[witness]}"


def _camera(estimate: CameraEstimate) -> Iterator[str]:
    camera = estimate.camera
    if camera is not None and camera.principal_sd_px:
        yield f"  principal point: the middle, +-{HALF_WIDTH_SD * camera.principal_sd_px:.0f} px"
    if estimate.lens is not None:
        yield f"  distortion: {estimate.lens}"


def _introduced(flag: Flag, estimate: CameraEstimate) -> str:
    refused = flag.doubt is Doubt.PROJECTION and estimate.camera is None
    return "doubt" if flag.doubt is Doubt.PROJECTION and not refused else _INTRODUCED.get(flag.doubt, "doubt")


def _is_said(flag: Flag) -> bool:
    """Whether the line with the arrow says it."""
    return flag.doubt is Doubt.ASSUMED


def _missing(estimate: CameraEstimate) -> Iterator[str]:
    """Yield what the file lacks; what to do about it is said once, after all photos."""
    file = [testimony.words for testimony in estimate.testimony if testimony.witness is Witness.FILE]
    reason = (estimate.reason or "").partition("; ")[0]
    for words in file or filter(None, [reason]):
        yield f"  missing: {words}"
