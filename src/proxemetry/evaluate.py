"""A method on a benchmark: its photos, or its annotated points instead of them, to scenes that can be scored.

The annotated points as keypoints test the geometry on real measured places without a photo: the middle of the
shoulders is the neck, and the mid-hip lies as far below the middle of the torso as the neck lies above it. Pairs of
shoulders and of eyes are not annotated, so what needs them places no one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .benchmark import LabelImage, Labels, Prediction, Predictions
from .benchmark.scenes import prediction_of
from .camera import Camera, CameraEstimate, FocalSource, Source
from .camera.focal import FocalRequest
from .measure import place, remeasure
from .people import People
from .people.skeleton import KORTE_PARTS, PARTS
from .scene import Scene
from .settings import Settings

if TYPE_CHECKING:
    from .archive.run.schedule import Note, Progress


def people_of_labels(image: LabelImage) -> People:
    """Return the annotated people of a photo as keypoints of the skeleton `KORTE_PARTS`, in the labels' order."""
    part = {name: image.parts_px[:, PARTS.index(name)] for name in PARTS}
    mid_hip = part["Shoulder"] + 2 * (part["Torso"] - part["Shoulder"])
    keypoints = np.stack([part["Eyes"], part["Head"], part["Shoulder"], mid_hip], axis=1)
    return People(KORTE_PARTS, keypoints, np.isfinite(keypoints).all(axis=-1).astype(float))


def camera_of_labels(image: LabelImage) -> CameraEstimate:
    """Return the camera of a photo from the focal length among its labels."""
    if not math.isfinite(image.focal_mm):
        return CameraEstimate(None, reason="no focal length with the labels: add focal_lengths.csv to their folder")
    f_px = image.focal_mm * max(image.width, image.height) / max(image.sensor_mm)
    return CameraEstimate(Camera.centred(f_px, image.width, image.height, source=Source(FocalSource.LABELS)))


def scenes_of_labels(labels: Labels, settings: Settings) -> Iterator[Scene]:
    """Place the annotated people of every photo by a method."""
    for image in labels:
        people, camera = people_of_labels(image), camera_of_labels(image)
        yield place(image.filename, "", image.width, image.height, people, camera, settings)


def predict_labels(labels: Labels, settings: Settings) -> tuple[Prediction, ...]:
    """Return a method's answers from the annotated points of every photo, who is who being known."""
    scenes = scenes_of_labels(labels, settings)
    return tuple(
        replace(prediction_of(scene), points_px=image.parts_px) for image, scene in zip(labels, scenes, strict=True)
    )


def predict_photos(
    images: str | Path | Sequence[str] | None,
    out: str | Path,
    settings: Mapping[str, Settings],
    *,
    pose: str = "auto",
    focal: FocalRequest | None = None,
    jobs: int | None = None,
    restart: bool = False,
    on_progress: Callable[[Progress | Note], None] = lambda _: None,
) -> dict[str, Predictions]:
    """Find the people of a folder of photos, or of several files, and return the answers of each named method.

    images: None where `pose` is recorded keypoints, which need no photos. focal: what is stated of the cameras, as in a
    camera table, before what the files record. restart: measure again what `out` has.
    The results folder `out` keeps a run with default settings, whatever the methods: a run that was stopped is
    continued, people are looked for once, and each method places the same people. Corrections by hand do not count.
    on_progress is called with every step of the run. Raises what `archive.run` raises.
    """
    from .archive.run.run import run
    from .archive.run.work import Job
    from .archive.store.results import Results

    paths = [] if images is None else [str(images)] if isinstance(images, str | Path) else list(images)
    job = Job(str(out), pose, settings=Settings(focal=focal or FocalRequest()))
    run(paths, job, jobs=jobs, restart=restart, on_progress=on_progress)
    results = Results.open(str(out))
    results.require_whole()
    scenes = list(results.scenes(corrected=False))
    return {
        method: Predictions(
            tuple(prediction_of(scene if scene.status == "failed" else remeasure(scene, chosen)) for scene in scenes),
            f"{method} on {images if isinstance(images, str | Path) else pose}",
        )
        for method, chosen in settings.items()
    }
