"""Scenes of a run as predictions: our own methods are scored as any other is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..people.skeleton import PARTS
from .predictions import Prediction

if TYPE_CHECKING:
    from ..scene import Scene

_MM = 1000.0


def prediction_of(scene: Scene) -> Prediction:
    """Return a scene as a prediction; people who could not be placed stay, without a position.

    Like a results folder it hands on the distances that were stated, where gravity was known: a method that states its
    uncertainty answers with another distance than that between its best positions.
    """
    known = scene.width_px > 0 and scene.height_px > 0
    distances = scene.distances
    return Prediction(
        scene.photo,
        scene.width_px if known else None,
        scene.height_px if known else None,
        np.stack([scene.people.part(part) for part in PARTS], axis=1),
        scene.bodies.positions_m * _MM,
        distances.distance_m * _MM if distances.on_ground else None,
        distances.low_m * _MM,
        distances.high_m * _MM,
        scene.bodies.up,
    )
