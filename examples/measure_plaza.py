"""Measure the example photo and draw what came of it.

    python examples/measure_plaza.py

prints each distance beside the true one and writes docs/images/plaza.png, the README's picture.
"""

import csv
import math
from pathlib import Path

import proxemetry as px
from proxemetry import plots

HERE = Path(__file__).parent
PICTURE = HERE.parent / "docs" / "images" / "plaza.png"


def main():
    with (HERE / "plaza_truth.csv").open(newline="") as file:
        truth = [(float(row["right_m"]), float(row["ahead_m"])) for row in csv.DictReader(file)]
    photo = px.Photo.open(HERE / "plaza.jpg")
    scene = px.measure(photo, pose=f"recorded:{HERE / 'plaza.json'}")
    distances = scene.distances
    print("pair  true   measured")
    for a, b in distances.pairs():
        true, measured = math.dist(truth[a], truth[b]), distances.distance_m[a, b]
        low, high = distances.low_m[a, b], distances.high_m[a, b]
        print(f"{a}-{b}  {true:5.2f}  {measured:5.2f} [{low:.2f}, {high:.2f}]")
    PICTURE.parent.mkdir(exist_ok=True)
    plots.save(plots.overlay(scene, photo), PICTURE)


if __name__ == "__main__":
    main()
