"""The kinds of arrays that values and functions hold, by name."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]

#: Colour pixels of shape (H, W, 3), red first.
RGBArray = NDArray[np.uint8]
