"""Which of a file's values to believe: what each implies about the sensor, which agree, and what stays possible.

Each value has its own way of being wrong. The focal plane resolution is a property of the pixels as the camera stored
them: a resize whose writer renews the stored size, a raw developer that keeps the preview's, firmware or a phone break
it, by any factor. The 35 mm equivalent and the crop factor speak of the whole picture: a crop breaks both. So

1. answers that agree win against one that does not, whatever their order;
2. the resolution alone must imply a sensor that was built, seen through a lens that was made;
3. against the equivalent or the crop factor it stands only where the stored size, being another than the file's, ties
   the pixels to such a sensor, or where the file's shape shows that it is a crop;
4. the interval holds every answer that stays possible, and a flag names each that was set aside, and why.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from ..intervals import HALF_WIDTH_SD
from ..photo import Photo
from .candidates import Found, zoom_of
from .estimate import Candidate
from .frame import Frame
from .sensors import (
    FULL_FRAME_DIAGONAL_MM,
    TOLERANCE,
    WIDEST_EQUIVALENT_MM,
    Sensor,
    equivalent_mm,
    may_be_full_frame,
    sensor_of,
    sensors_of_pixels,
)
from .sources import Doubt, Flag, FocalSource, Source

#: How far apart two answers may be that agree, however sure each is: tags are rounded, sensors' borders differ.
_AGREE = 0.05
#: Ratios by which cameras use a part of their sensor as if it were a smaller one, and how exactly.
_CROP_MODES = (1.2, 1.3, 1.5, 1.6, 1.7, 2.0)
_CROP_MODE_TOLERANCE = 0.035
#: A crop to the sensor's own shape leaves no trace where its metadata were rewritten. Larger cuts are the rarer story:
#: few people throw away 60 % of the picture and keep its shape, while most photos are made smaller.
_LIKELY_CROP = 1.6
#: Pixels along the long side of today's cameras with a sensor wider than 13 mm.
_LARGE_MM, _LARGE_SENSORS_PX = 13.0, 4900
#: Long sides of the pictures of compact cameras as they come from the sensor (makers' data sheets, 1999 to 2014, all
#: shapes); a photo made smaller has another one, mostly. Several of these are what pictures are made smaller to.
_COMPACTS_PX = frozenset({
    1024, 1280, 1600, 1632, 2048, 2080, 2112, 2240, 2272, 2288, 2304, 2560, 2576, 2592, 2608, 2640, 2816, 2832, 2848,
    2880, 2896, 3008, 3056, 3060, 3072, 3096, 3136, 3152, 3200, 3264, 3296, 3328, 3456, 3488, 3552, 3584, 3616, 3648,
    3664, 3680, 3712, 3776, 3888, 3968, 4000, 4032, 4048, 4096, 4128, 4160, 4224, 4256, 4288, 4320, 4352, 4384, 4416,
    4608, 4640, 4752, 4768, 4896, 4912, 5120, 5152, 5184, 5248, 5312, 5472,
})  # fmt: skip
_ALSO_MADE_SMALLER_TO = frozenset({1024, 1280, 1600, 2048, 2560, 3072, 3200, 3264, 4000, 4096})
#: Compact cameras with a smaller sensor than 1/2.5 inch had fewer pixels than this along the long side, until a year.
_SMALL_COMPACTS_MM, _SMALL_COMPACTS_PX, _COMPACTS_SINCE = 5.6, 2700, "2006"
#: A photo of such a size that was scaled down was so by less than this, mostly.
_LITTLE_SMALLER = 1.35
#: Such a crop's share, with which the optical centre is unknown.
_CROP_SHARE = 0.4


@dataclass(frozen=True)
class Verdict:
    """The candidate that won, its interval wide enough for all that stays possible.

    frame: the picture, with what was found out about crops. flags: what was set aside, and why. why: in words.
    made: whether the candidate is none of those weighed but was made from one.
    """

    chosen: Candidate
    frame: Frame
    why: str
    flags: tuple[Flag, ...] = ()
    made: bool = False

    def holding(self, other: Candidate) -> Verdict:
        """Return the verdict with an interval that holds another candidate."""
        apart = math.log(other.focal_px / self.chosen.focal_px)
        sd = max(self.chosen.rel_sd, math.hypot(self.chosen.rel_sd, apart / HALF_WIDTH_SD))
        return replace(self, chosen=replace(self.chosen, rel_sd=sd))

    def against(self, other: Candidate, reason: str = "") -> Verdict:
        """Return the verdict with a flag that names another candidate, and why it was set aside."""
        text = f"{other.source} says {other.focal_px:.0f} px, {self.chosen.source} {self.chosen.focal_px:.0f} px"
        flag = Flag(Doubt.CONTRADICTED, f"{text}{': ' if reason else ''}{reason}")
        return replace(self, flags=(*self.flags, flag))

    def setting_aside(self, plane: Candidate, reason: str) -> Verdict:
        """Return the verdict with a flag on why the focal plane resolution is not believed."""
        return replace(self.against(plane, reason), why="the focal plane resolution does not fit, and is set aside")


def agree(one: Candidate, other: Candidate) -> bool:
    """Whether two answers can both be right."""
    return _apart(one, other) <= max(2 * math.hypot(one.rel_sd, other.rel_sd), _AGREE)


def _apart(one: Candidate, other: Candidate) -> float:
    return abs(math.log(other.focal_px / one.focal_px))


def weigh(photo: Photo, found: Sequence[Found], frame: Frame) -> Verdict | None:
    """Return the verdict on the answers that one focal length gives with what is known of the sensor, None for none."""
    by_basis = {f.basis: f.candidate for f in found}
    plane, tag = by_basis.get(FocalSource.FOCAL_PLANE), by_basis.get(FocalSource.EQUIVALENT)
    body = by_basis.get(FocalSource.CROP_FACTOR)
    implied = None if plane is None else _Implied.by(photo, plane, frame)
    if plane is None or implied is None:
        return _without_plane(photo, tag, body, frame)
    if not implied.is_seen_by_a_lens:
        mm, whole = implied.equivalent_mm, _without_plane(photo, tag, body, frame)
        return whole and whole.setting_aside(
            plane, f"that would be a lens of {mm:.1f} mm equivalent, which does not exist"
        )
    if not frame.is_whole_known:
        return _part(photo, plane, implied, _without_plane(photo, tag, body, frame), frame)
    for second, third in ((tag, body), (body, tag)):
        if second is not None and agree(plane, second):
            verdict = Verdict(plane, frame, f"{second.source} agrees")
            return verdict if third is None or agree(plane, third) else verdict.against(third, "two agree against it")
    whole = _without_plane(photo, tag, body, frame)
    if whole is None:
        return _plane_alone(photo, plane, implied, frame)
    return _plane_against(photo, plane, implied, whole, body, frame)


@dataclass(frozen=True)
class _Implied:
    """What a focal plane resolution implies of the sensor, and whether there is such a thing."""

    size_mm: tuple[float, float]
    px_per_mm: float
    equivalent_mm: float
    sensor: Sensor | None

    @classmethod
    def by(cls, photo: Photo, plane: Candidate, frame: Frame) -> _Implied | None:
        px_per_mm = photo.metadata.focal_plane_px_per_mm
        if px_per_mm is None:
            return None
        stored_px = (frame.width_px / frame.scale, frame.height_px / frame.scale)
        size_mm = (stored_px[0] / px_per_mm, stored_px[1] / px_per_mm)
        seen = equivalent_mm(plane.focal_px, frame.diagonal_px) / zoom_of(photo.metadata)
        return cls(size_mm, px_per_mm, seen, sensor_of(size_mm, stored_px))

    @property
    def is_seen_by_a_lens(self) -> bool:
        return self.equivalent_mm >= WIDEST_EQUIVALENT_MM

    def __str__(self) -> str:
        return f"{max(self.size_mm):.1f} x {min(self.size_mm):.1f} mm"


def _without_plane(photo: Photo, tag: Candidate | None, body: Candidate | None, frame: Frame) -> Verdict | None:
    """Return the verdict of the 35 mm equivalent and the crop factor, which are about the whole picture."""
    if tag is None or body is None:
        one = tag or body
        return None if one is None else Verdict(one, frame, "the only evidence")
    if agree(tag, body):
        return Verdict(tag, frame, "the camera's sensor size agrees")
    ratio = tag.focal_px / body.focal_px
    focal_35mm, focal_mm = photo.metadata.focal_35mm, photo.metadata.focal_mm
    if focal_35mm is not None and focal_mm is not None and ratio < 1 and abs(focal_35mm - focal_mm) <= 1:
        verdict = Verdict(body, frame, "the 35 mm equivalent repeats the lens's own millimetres")
        return verdict.against(tag, "it repeats the lens's own millimetres")
    if _is_crop_mode(photo, ratio):
        verdict = Verdict(tag, frame, "the camera used a part of its sensor")
        return verdict.against(body, "the camera used a part of its sensor alone")
    return Verdict(tag, frame, "the first of two that disagree").holding(body).against(body)


def _is_crop_mode(photo: Photo, ratio: float) -> bool:
    from .lens import may_crop_in_camera

    near = any(abs(math.log(ratio / mode)) <= _CROP_MODE_TOLERANCE for mode in _CROP_MODES)
    return near and may_crop_in_camera(photo.metadata.make, photo.metadata.model)


def _part(photo: Photo, plane: Candidate, implied: _Implied, whole: Verdict | None, frame: Frame) -> Verdict:
    """Weigh a file that is an unknown part: cut at full size the resolution holds, made smaller since it is too long.

    The whole picture's answers, given for the file as if it were whole, are the other end.
    """
    if whole is None:
        verdict = Verdict(plane, frame, "the only evidence, of a photo that was cropped")
        sensors = list(sensors_of_pixels(implied.px_per_mm, max(implied.size_mm)))
        if frame.is_tied or not sensors:
            return verdict
        widest = max(sensor.width_mm for sensor in sensors)
        return verdict.holding(replace(plane, focal_px=plane.focal_px * max(implied.size_mm) / widest))
    if plane.focal_px < whole.chosen.focal_px * math.exp(-_AGREE):
        return whole.setting_aside(plane, f"a sensor of {implied} would be larger than the camera's")
    verdict = Verdict(plane, frame, "cut at full size, the resolution holds; the interval includes a scaled-down one")
    return verdict.holding(whole.chosen).against(whole.chosen, "that is of the whole picture")


def _plane_alone(photo: Photo, plane: Candidate, implied: _Implied, frame: Frame) -> Verdict | None:
    """Weigh a resolution that nothing else confirms: is there such a sensor, and was the file made smaller since?"""
    metadata = photo.metadata
    as_stored = metadata.stored_width_px is not None and not metadata.edited_by and _is_of_its_time(photo, implied)
    untouched = metadata.raw or frame.is_tied or as_stored
    if implied.sensor is not None and untouched:
        return Verdict(plane, frame, f"it implies a sensor that exists ({implied.sensor.name})")
    candidates = list(_if_made_smaller(photo, plane, implied, frame))
    if implied.sensor is not None:
        verdict = Verdict(plane, frame, f"it implies a sensor that exists ({implied.sensor.name})")
        smaller = [c for c in candidates if c.focal_px < plane.focal_px * math.exp(-_AGREE)]
        if not smaller:
            return verdict
        held = verdict.holding(min(smaller, key=lambda c: c.focal_px))
        if _may_be_native(photo, implied):
            near = [c for c in smaller if c.focal_px * _LITTLE_SMALLER > plane.focal_px]
            held = verdict.holding(min(near, key=lambda c: c.focal_px)) if near else verdict
        return replace(held, flags=(Flag(Doubt.SENSOR, "nothing shows that the photo still has its original size"),))
    if not candidates:
        return None
    low, high = (pick(c.focal_px for c in candidates) for pick in (min, max))
    middle = math.sqrt(low * high)
    sd = math.hypot(plane.rel_sd, math.log(high / low) / 2 / HALF_WIDTH_SD)
    source = Source(plane.source.kind, _joined(plane.source.detail, "of a photo scaled down by an unknown factor"))
    text = f"the focal plane resolution implies a sensor of {implied}, which was never built: the photo was scaled down"
    return Verdict(
        Candidate(middle, sd, source), frame, "any sensor that has such pixels", (Flag(Doubt.SENSOR, text),), made=True
    )


def _is_of_its_time(photo: Photo, implied: _Implied) -> bool:
    """Whether a photo has as many pixels as a camera had that the lens database does not know.

    The database has nearly all cameras with a large sensor but the latest, whose pictures are larger than what was made
    smaller for a page. Of a compact camera the long side must be one that such cameras had and that photos are not
    scaled to.
    """
    long_side = max(photo.width, photo.height)
    if max(implied.size_mm) >= _LARGE_MM:
        return long_side >= _LARGE_SENSORS_PX
    return long_side in _COMPACTS_PX - _ALSO_MADE_SMALLER_TO and not _is_too_small(photo, implied)


def _may_be_native(photo: Photo, implied: _Implied) -> bool:
    """Whether a long side is one that compact cameras have, and that photos are scaled to as well."""
    long_side = max(photo.width, photo.height)
    return long_side in _COMPACTS_PX and max(implied.size_mm) < _LARGE_MM and not _is_too_small(photo, implied)


def _is_too_small(photo: Photo, implied: _Implied) -> bool:
    """Whether a sensor is smaller than compact cameras had when they had so many pixels."""
    many = max(photo.width, photo.height) > _SMALL_COMPACTS_PX or (photo.metadata.date or "9999") >= _COMPACTS_SINCE
    return max(implied.size_mm) < _SMALL_COMPACTS_MM and many


def _joined(detail: str, more: str) -> str:
    return f"{detail}, {more}" if detail else more


def _if_made_smaller(photo: Photo, plane: Candidate, implied: _Implied, frame: Frame) -> Iterator[Candidate]:
    """Yield the focal length on each sensor that has such pixels and is no smaller, seen through a lens that exists.

    Medium format is left out where a smaller sensor will do: hardly any photo in an archive is one.
    """
    sensors = list(sensors_of_pixels(implied.px_per_mm, max(implied.size_mm)))
    usual = [sensor for sensor in sensors if sensor.width_mm <= 36]
    for sensor in usual or sensors:
        part = max(max(implied.size_mm) / sensor.width_mm, min(implied.size_mm) / sensor.height_mm)
        f_px = plane.focal_px * min(part, 1.0)
        if equivalent_mm(f_px, frame.diagonal_px) / zoom_of(photo.metadata) >= WIDEST_EQUIVALENT_MM:
            yield replace(plane, focal_px=f_px)


def _plane_against(
    photo: Photo, plane: Candidate, implied: _Implied, whole: Verdict, body: Candidate | None, frame: Frame
) -> Verdict:
    """Weigh a resolution that contradicts what is known of the whole picture."""
    ratio = plane.focal_px / whole.chosen.focal_px
    if ratio < 1:
        if body is not None or implied.sensor is None:
            built = "larger than the camera's" if body is not None else "one that was never built"
            return whole.setting_aside(plane, f"it implies a sensor of {implied}, {built}")
        return whole.holding(plane).against(plane)
    crop_mode = body is not None and _is_crop_mode(photo, ratio)
    tied = implied.sensor is not None and (frame.is_tied or (crop_mode and photo.metadata.stored_width_px is not None))
    if tied and (body is None or crop_mode):
        because = (
            "the camera may have used a part of its sensor" if crop_mode else "the stored size ties it to a sensor"
        )
        verdict = Verdict(plane, frame, because, whole.flags)
        return verdict.holding(whole.chosen).against(whole.chosen, because)
    if frame.is_tied:
        return whole.setting_aside(plane, f"it implies a sensor of {implied}, and the camera's is another")
    if ratio <= _LIKELY_CROP and _has_pixels_for(photo, plane, whole):
        return _unless_cropped(photo, plane, whole, ratio)
    return whole.setting_aside(
        plane, f"it implies a sensor of {implied}: the photo was scaled down, or the tag is wrong"
    )


def _has_pixels_for(photo: Photo, plane: Candidate, whole: Verdict) -> bool:
    """Whether the camera's sensor may have as many pixels as the resolution puts on it, which a crop would need."""
    px_per_mm, metadata = photo.metadata.focal_plane_px_per_mm or 0.0, photo.metadata
    equivalent = equivalent_mm(whole.chosen.focal_px, whole.frame.diagonal_px) / zoom_of(metadata)
    # The focal length in millimetres cancels out: pixels of the file a millimetre, times the equivalent's diagonal.
    focal_mm = plane.focal_px / px_per_mm / whole.frame.scale / zoom_of(metadata)
    diagonal_mm = FULL_FRAME_DIAGONAL_MM * focal_mm / equivalent
    aspect = whole.frame.aspect
    width_mm = diagonal_mm * aspect / math.hypot(aspect, 1)
    if abs(math.log(diagonal_mm / FULL_FRAME_DIAGONAL_MM)) <= TOLERANCE:
        return may_be_full_frame(metadata.make, px_per_mm * width_mm)
    return any(abs(math.log(s.width_mm / width_mm)) <= 0.1 for s in sensors_of_pixels(px_per_mm, 0.0))


def _unless_cropped(photo: Photo, plane: Candidate, whole: Verdict, ratio: float) -> Verdict:
    """Return the whole picture's verdict with an interval and an optical centre that allow for a crop of its shape."""
    long_side = max(photo.width, photo.height)
    shift = _CROP_SHARE * (ratio - 1) * long_side / math.sqrt(12)
    frame = replace(whole.frame, principal_sd_px=math.hypot(whole.frame.principal_sd_px, shift))
    held = replace(whole.holding(plane), frame=frame)
    return held.against(plane, "scaled down, or cropped to the sensor's own shape")
