"""Who does not move for minutes: statues, mannequins, posters, signs and coats that are taken for people.

A person who stands or sits still sways, looks about and shifts from foot to foot; what is no person stays within a
fraction of a pixel. No single frame shows this, and half a minute does not either: some people keep that still. Limits
are measured by `benchmarks/networks/motionless.py`.
"""

from __future__ import annotations

import numpy as np

from ..arrays import FloatArray

#: A joint's place is its median over so many seconds, which the noise of single frames hardly moves.
WINDOW_S = 10.0
#: Who is seen for less may be a person who happens to keep still, seconds: the head of someone who sits at a screen
#: strays by 4 mm within one minute at the stillest, 7 mm within two, 13 mm within three.
LEAST_S = 180.0
#: Who strays less than this from the usual place, as a share of the body's size in the picture, does not move: 10 mm of
#: someone seen whole. People frozen in a clip, 70 to 110 pixels tall, stray by 0.004 to 0.009.
MOST_STRAYED = 0.008
#: The body strays as far as this share of its joints at most, for this share of the time: a head that turns or a hand
#: that moves is a person's; a passer-by who hides the body for a moment makes no person of it.
_OF_JOINTS, _OF_TIME = 0.75, 0.8
#: A joint counts if it was seen in this share of the windows; with fewer such joints nothing is known.
_LEAST_SEEN, _FEWEST_JOINTS = 0.5, 5


def is_motionless(t_s: FloatArray, keypoints_px: FloatArray) -> bool:
    """Return whether a body was seen for long enough, at times (n,) with joints (n, K, 2), and never moved."""
    windows = np.unique(_windows(t_s))
    return len(windows) * WINDOW_S >= LEAST_S and strayed_share(t_s, keypoints_px) < MOST_STRAYED


def strayed_share(t_s: FloatArray, keypoints_px: FloatArray) -> float:
    """Return how far a body strays from its usual place before a fixed camera, as a share of its size.

    t_s: shape (n,). keypoints_px: shape (n, K, 2), NaN where a joint was not seen. The body's size is the longer side
    of the rectangle around its joints. NaN where too few joints are seen, or all in one place.
    """
    places = _by_window(_windows(t_s), keypoints_px)
    counted = np.isfinite(places).all(axis=-1).mean(axis=0) >= _LEAST_SEEN if len(places) else np.zeros(0, dtype=bool)
    if counted.sum() < _FEWEST_JOINTS:
        return float("nan")
    places = places[:, counted]
    places = places[np.isfinite(places[..., 0]).any(axis=-1)]
    usual = np.nanmedian(places, axis=0)
    size = float(np.ptp(usual, axis=0).max())
    if not size > 0:
        return float("nan")
    strayed = np.linalg.norm(places - usual, axis=-1) / size
    return float(np.quantile(np.nanquantile(strayed, _OF_JOINTS, axis=1), _OF_TIME))


def _windows(t_s: FloatArray) -> FloatArray:
    """Return in which stretch of `WINDOW_S` from the first each time lies, shape (n,)."""
    return np.floor((t_s - t_s[:1]) / WINDOW_S)


def _by_window(windows: FloatArray, keypoints_px: FloatArray) -> FloatArray:
    """Return the median places of joints in each window, shape (W, K, 2), NaN where a joint was not seen in it."""
    numbers, starts = np.unique(windows, return_index=True)
    places = np.full((len(numbers), *keypoints_px.shape[1:]), np.nan)
    for row, of_window in enumerate(np.split(keypoints_px, starts[1:])):
        seen = np.isfinite(of_window).all(axis=-1).any(axis=0)
        places[row, seen] = np.nanmedian(of_window[:, seen], axis=0)
    return places
