"""A method's answers, wherever they are: a prediction file or the results folder of a run."""

from __future__ import annotations

from pathlib import Path

from .prediction_file import read_prediction_file
from .predictions import Predictions
from .results_folder import read_results_folder


def read_predictions(path: str | Path) -> Predictions:
    """Read a prediction file, or the results folder of a run; raises LabelsError saying what is wrong and where."""
    path = Path(path)
    return read_results_folder(path) if path.is_dir() else read_prediction_file(path)
