"""The KORTE benchmark: truth, matching, scores and tables. It knows files, never a model, and needs numpy alone.

from proxemetry.benchmark import score_files
score = score_files("predictions.json", "labels/", protocol="v1")
score.overall.pair_error_pct_mean_over_images
"""

from .errata import Erratum, load_errata
from .image_score import ImageScore
from .labels import LabelImage, Labels, Mark, read_labels
from .metrics import Summary, error_by_distance, f1, summarise, zone_confusion
from .paired import Difference, difference
from .prediction_file import write_predictions
from .predictions import Prediction, Predictions
from .reading import read_predictions
from .scores import DEFAULT_PROTOCOL, PROTOCOLS, Group, Score, score, score_files

__all__ = [
    "DEFAULT_PROTOCOL", "PROTOCOLS", "Difference", "Erratum", "Group", "ImageScore", "LabelImage", "Labels", "Mark",
    "Prediction", "Predictions", "Score", "Summary", "difference", "error_by_distance", "f1", "load_errata",
    "read_labels", "read_predictions", "score", "score_files", "summarise", "write_predictions", "zone_confusion",
]  # fmt: skip
