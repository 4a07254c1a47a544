"""The tool's own run on the annotated photos, scored against them under both protocols."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..archive.store.folder import Folder
from ..archive.store.photos import find_photos
from ..benchmark import PROTOCOLS, Predictions, Score, read_labels, score, write_predictions
from ..benchmark.predictions import by_stated_distances
from ..camera.request import FocalRequest
from ..camera.table import CameraTable
from ..errors import LabelsError, OutputError, SettingsError
from ..evaluate import predict_photos
from ..locate import METHODS
from ..settings import Settings
from .label_files import CAMERA_TABLE, stated_rows
from .photos import OwnPhoto
from .project import NO_POSE, Project

if TYPE_CHECKING:
    from ..archive.run.schedule import Note, Progress

#: Results, predictions and scores lie here in the folder of annotations.
RUN_FOLDER = "run"
#: The methods that are scored unless others are asked for: this tool's, and the paper's.
DEFAULT_METHODS = ("scene", "combined")
#: Which camera table the results were made with.
_MADE_WITH = "camera_table.sha256"

#: Protocol -> method -> its score.
Scores = Mapping[str, Mapping[str, Score]]


def score_own_run(
    project: Project,
    methods: tuple[str, ...] = DEFAULT_METHODS,
    *,
    jobs: int | None = None,
    on_progress: Callable[[Progress | Note], None] = lambda _: None,
) -> Scores:
    """Measure the annotated photos as `proxemetry measure` does, and score each method under each protocol.

    Results are kept in the folder's `run`, and a run that was stopped is continued. Lenses that the annotator stated
    are used.
    Raises LabelsError where the label files cannot be scored yet, and what `predict_photos` raises.
    """
    for method in methods:
        if method not in METHODS:
            raise SettingsError(f"method {method!r} is unknown: use some of {', '.join(METHODS)}")
    project.write()
    counted = [(p, n) for p in project.photos if (n := project.now.photo(p.sha256)).named and not n.skipped]
    if not counted:
        raise LabelsError(f"{project.out}: nobody is annotated and named yet")
    labels = {name: read_labels(project.out, errata=p.errata) for name, p in PROTOCOLS.items()}
    run = project.out / RUN_FOLDER
    photos = [photo for photo, _ in counted]
    rows = tuple(stated_rows(counted))
    answers = predict_photos(
        [photo.path for photo in photos], run, {m: Settings(method=m) for m in methods},
        pose="auto" if project.pose == NO_POSE else project.pose,
        focal=FocalRequest(camera_table=CameraTable(rows, CAMERA_TABLE)) if rows else None,
        restart=_is_made_otherwise(run, rows), jobs=jobs, on_progress=on_progress,
    )  # fmt: skip
    answers = {method: _under_label_names(given, photos) for method, given in answers.items()}
    scores = {
        name: {
            method: score(labels[name], given, name)
            for method, given in (by_stated_distances(answers) if name == "seker2021" else answers).items()
        }
        for name in PROTOCOLS
    }
    _keep(run, answers, scores)
    return scores


def _is_made_otherwise(run: Path, rows: tuple[object, ...]) -> bool:
    """Note the stated lenses that a run is made with; return whether results there were made with others."""
    digest, path = hashlib.sha256(repr(rows).encode()).hexdigest(), run / _MADE_WITH
    try:
        before = path.read_text(encoding="utf-8") if path.exists() else None
        run.mkdir(parents=True, exist_ok=True)
        path.write_text(digest, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise OutputError(f"{run}: cannot be used for results ({error})") from error
    return before is not None and before != digest


def _under_label_names(given: Predictions, photos: list[OwnPhoto]) -> Predictions:
    """Return predictions under the names that the labels have: a run names photos by the folder that holds them all."""
    listing = find_photos([photo.path for photo in photos])
    by_path = {Path(photo.path): photo.name for photo in photos}
    names = {name: by_path.get(Path(listing.location(name)), name) for name in listing.names}
    known = [image for image in given if image.filename in names]
    return Predictions(tuple(replace(i, filename=names[i.filename]) for i in known), given.source)


def _keep(run: Path, answers: Mapping[str, Predictions], scores: Scores) -> None:
    for method, given in answers.items():
        write_predictions(run / f"predictions_{method}.json", given)
    folder = Folder(str(run))
    for protocol, of in scores.items():
        for method, one in of.items():
            folder.write(f"score_{method}_{protocol}.json", one.to_json().encode())
