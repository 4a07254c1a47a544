"""Synthetic photos to files: the benchmark's label files and recorded keypoints."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from synthetic.scenes import SyntheticPhoto


def write(folder: str | Path, photos: Iterable[SyntheticPhoto]) -> int:
    """Write the label files and `keypoints.json` of these photos; each is a shoot of its own. Returns how many."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    rows: dict[str, list[list[Any]]] = {
        "body_pixel_locations.csv": [], "ground_truth_locations.csv": [],
        "camera_locations_photoshoot_identifiers.csv": [], "settings.csv": [["shoot", "setting"]],
        "focal_lengths_recovered.csv": [
            ["filename", "photoshoot", "camera", "image_width_px", "image_height_px", "focal_length_mm"]
        ],
    }  # fmt: skip
    images = []
    for shoot, photo in enumerate(photos):
        size = [photo.camera.width, photo.camera.height]
        rows["ground_truth_locations.csv"].append([shoot, "C0", 0, 0, 0])
        for k, (x, z) in enumerate(photo.ground_mm):
            rows["ground_truth_locations.csv"].append([shoot, f"P{k}", f"{x:.2f}", 0, f"{z:.2f}"])
            for part, pixels in photo.parts_px.items():
                if np.isfinite(pixels[k]).all():
                    u, v = np.minimum(np.rint(pixels[k]), np.array(size) - 1).astype(int)
                    rows["body_pixel_locations.csv"].append([f"P{k}", part, u, v, photo.name, *size])
        rows["camera_locations_photoshoot_identifiers.csv"].append([shoot, "C0", photo.name])
        rows["settings.csv"].append([shoot, photo.kind])
        rows["focal_lengths_recovered.csv"].append([photo.name, shoot, "C0", *size, f"{photo.focal_mm:g}"])
        images.append(_recorded(photo))
    for name, table in rows.items():
        with (folder / name).open("w", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(table)
    skeleton = images[0].pop("skeleton") if images else "coco17"
    for image in images[1:]:
        del image["skeleton"]
    (folder / "keypoints.json").write_text(json.dumps({"skeleton": skeleton, "images": images}))
    return len(images)


def _recorded(photo: SyntheticPhoto) -> dict[str, Any]:
    camera, people = photo.camera, photo.people
    return {
        "skeleton": people.skeleton.name,
        "filename": photo.name,
        "width": camera.width,
        "height": camera.height,
        "camera": {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy},
        "people": [
            {
                "keypoints": [
                    [round(float(u), 2), round(float(v), 2), round(float(s), 3)] if s > 0 else [0, 0, 0]
                    for (u, v), s in zip(people.keypoints_px[k], people.scores[k], strict=True)
                ],
                "score": round(float(people.person_scores[k]), 3),
            }
            for k in range(len(people))
        ],
    }
