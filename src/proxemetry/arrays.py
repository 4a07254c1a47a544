"""The kinds of arrays that values and functions hold, by name, and how they hold a missing number."""

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]

#: Colour pixels of shape (H, W, 3), red first.
RGBArray = NDArray[np.uint8]
#: Single precision, where the data are no better and time counts.
SingleArray = NDArray[np.float32]


def freeze(value: object) -> None:
    """Make the arrays of a frozen value's fields read-only: what others hold as well is not edited in place.

    The value gets views of its own, so that the arrays that it was made of stay as they are.
    """
    for name, array in vars(value).items():
        if isinstance(array, np.ndarray):
            view = array.view()
            view.setflags(write=False)
            object.__setattr__(value, name, view)


def nan_if_none(value: float | None) -> float:
    """Return a missing number of a table or of JSON as arrays have it."""
    return float("nan") if value is None else float(value)
