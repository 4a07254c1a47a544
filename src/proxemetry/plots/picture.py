"""A photo in a panel, brought to the size that it is drawn at."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from PIL import Image

from ..photo import RGBArray

#: Beyond this enlargement matplotlib draws a photo's own pixels as squares, which is left to it.
_SQUARES = 3.0


def draw_picture(axes: Axes, pixels: RGBArray, width: float, height: float) -> None:
    """Fill a panel with a picture (H, W, 3) that spans `width` times `height` of its data units, y down."""
    image = _Picture(
        axes, extent=(0, width, height, 0), interpolation="antialiased", origin="upper", resample=True,
    )  # fmt: skip
    image.set_data(pixels)
    image.set_clip_path(axes.patch)
    axes.add_image(image)
    axes.set(xlim=(0, width), ylim=(height, 0))


class _Picture(AxesImage):
    """An image that Pillow resamples in bytes: matplotlib does it in floating point with an alpha channel, slower."""

    def make_image(self, renderer: Any, magnification: float = 1.0, unsampled: bool = False) -> tuple[Any, ...]:
        """Return the image as drawn (h, w, 4), bottom row first, where its lower left corner is, and no transform."""
        panel = self.axes.bbox
        shown = self.get_window_extent()
        low, high = np.round(np.reshape(panel.extents, (2, 2)) * magnification)
        columns, rows = (int(n) for n in high - low)
        pixels = np.asarray(self.get_array())
        whole = np.allclose(shown.extents, panel.extents, atol=0.01)
        larger = min(columns / pixels.shape[1], rows / pixels.shape[0])
        if unsampled or not whole or min(columns, rows) < 1 or larger > _SQUARES:
            return super().make_image(renderer, magnification, unsampled)
        drawn = Image.fromarray(pixels).resize((columns, rows), Image.Resampling.HAMMING)
        drawn.putalpha(255)
        return np.asarray(drawn)[::-1], low[0] / magnification, low[1] / magnification, None
