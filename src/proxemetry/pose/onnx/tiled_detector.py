"""The people that a detector finds in the whole photo, and in tiles where people may be too small for that."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import ModelError
from ...photo import RGBArray
from ..detections import DECODERS, Detections, joined, suppressed, uncut
from .letterbox import Region, letterbox, tiles, tiles_around
from .network import Floats, Network
from .one_stage import ONE_STAGE
from .specification import DetectorInput, Input


class PhotoNetwork:
    """A detector or a one-stage network at work on photos, searching as thoroughly as the effort asks for."""

    def __init__(self, specification: DetectorInput, network: Network, effort: str) -> None:
        self.specification, self.network = specification, network
        self.size = input_size(specification, network)
        # not a method of its kind but the one decoder that the specification names, of either table
        decoder = DECODERS.get(specification.decode)
        of_boxes = partial(decoder, rivals_from=specification.score) if decoder else None
        self._decode: Any = of_boxes or ONE_STAGE[specification.decode]
        stated = {"fast": specification.fast_tiles, "thorough": specification.thorough_tiles}.get(effort)
        self._fractions = stated or specification.tiles
        whole_first = self._fractions[0] >= 1
        self._guided = specification.suspicion > 0 and effort != "thorough" and whole_first

    def detect(self, pixels: RGBArray) -> Detections:
        """Return the people seen in RGB pixels of shape (H, W, 3), in those pixels; a person seen twice is there twice.

        Tiles cover the photo, or lie only where the whole photo suspects a person, where the
        specification states from which score on it does. People cut by a tile's edge are left to another tile.
        """
        height, width = pixels.shape[:2]
        least, aspect = self.specification.score, self.size[0] / self.size[1]
        if not self._guided:
            regions = [r for fraction in self._fractions for r in tiles(width, height, fraction, aspect)]
            return joined(self._look_at(pixels, regions, least))
        whole = self._look(pixels, (0, 0, width, height), self.specification.suspicion)
        suspected = self._suspected(whole)
        regions = [r for f in self._fractions[1:] for r in tiles_around(suspected, width, height, f, aspect)]
        return joined([whole[whole.scores >= least], *self._look_at(pixels, regions, least)])

    def _suspected(self, whole: Detections) -> NDArray[np.float64]:
        """Return the boxes that are too unsure to be people and show no person who was found; the likeliest first."""
        distinct = suppressed(whole, self.specification.overlap)
        return distinct.boxes_px[distinct.scores < self.specification.score]

    def _look_at(self, pixels: RGBArray, regions: list[Region], least: float) -> list[Detections]:
        return self.network.each([lambda region=region: self._look(pixels, region, least) for region in regions])

    def _look(self, pixels: RGBArray, region: Region, least: float) -> Detections:
        spec = self.specification
        canvas, at = letterbox(pixels, region, self.size, fill=spec.fill, centred=spec.centred)
        found: Detections = self._decode(
            self.network.run_one(normalised(canvas[None], spec, self.network)), self.size, spec.person, least
        )
        placed = Detections(
            at.boxes_to_photo(found.boxes_px), found.scores, at.to_photo(found.keypoints_px), found.keypoint_scores,
            found.rivals,
        )  # fmt: skip
        return uncut(placed, region, (pixels.shape[1], pixels.shape[0]))


def input_size(part: Input, network: Network) -> tuple[int, int]:
    """Return the (width, height) of a network's input; raises ModelError where file and specification disagree."""
    fixed = network.input_size
    if fixed is None and min(part.size) <= 0:
        raise ModelError(f"{part.file} takes any size: state `size` in the specification")
    if fixed is not None and min(part.size) > 0 and tuple(part.size) != fixed:
        raise ModelError(f"{part.file} takes {fixed[0]} x {fixed[1]}, and the specification states {list(part.size)}")
    return fixed or (int(part.size[0]), int(part.size[1]))


def normalised(canvases: RGBArray, part: Input, network: Network) -> Floats:
    """Return RGB images (B, H, W, 3) as a network's input, (B, 3, H, W) where its channels do not come last."""
    import cv2

    ordered = [cv2.cvtColor(c, cv2.COLOR_RGB2BGR) for c in canvases] if part.colours == "bgr" else list(canvases)
    if any(part.mean) or set(part.std) != {1}:
        table = _values(part.mean, part.std)
        ordered = [cv2.LUT(canvas, table) for canvas in ordered]
    as_numbers = [np.asarray(canvas, np.float32) for canvas in ordered]
    values = as_numbers[0][None] if len(as_numbers) == 1 else np.stack(as_numbers)
    return values if network.channels_last else np.ascontiguousarray(values.transpose(0, 3, 1, 2))


@lru_cache(maxsize=16)
def _values(mean: tuple[float, ...], std: tuple[float, ...]) -> Floats:
    """Return what each of 256 levels is to a network, shape (1, 256, 3): looked up six times as fast as computed."""
    levels = np.arange(256, dtype=np.float32)[:, None]
    return ((levels - np.array(mean, np.float32)) / np.array(std, np.float32))[None]
