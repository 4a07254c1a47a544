"""Repeatability of the embedded back end's torso lengths and eye distances, and what each further look adds.

    python -m benchmarks.networks.steadiness --photos DIR [--most 6]

Every person found is detected again in crops that are slightly shifted, slightly larger or smaller, and mirrored every
other time, as a detection in the next photo of the same scene would be. Torso lengths (middle of the
shoulders to middle of the hips) and eye distances then scatter around a person's own mean; printed is the median over
people of that scatter, relative to the mean, for the mean of 1, 2 and 6 looks: a single look, effort normal (a look and
its mirror image), effort thorough. Eyes are those of the landmark network, and the pupils of face mesh and iris from
face boxes moved likewise.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from benchmarks.networks.backends import photos_in
from proxemetry.arrays import FloatArray
from proxemetry.photo import Photo
from proxemetry.pose import PoseOptions, backend_named
from proxemetry.pose.blazepose import BlazePose
from proxemetry.pose.blazepose.faces import Face, face_of
from proxemetry.pose.blazepose.proposals import in_boxes
from proxemetry.pose.blazepose.regions import Picture, Region
from proxemetry.pose.blazepose.score import person_score
from proxemetry.pose.blazepose.search import Search

_LOOKS = 12
#: Only people whom the back end itself is this sure of.
_SURE = 0.7
_ASIDE, _RESIZED = 0.03, 0.05
_EYES, _SHOULDERS, _HIPS = [2, 5], [11, 12], [23, 24]


def scatter(lengths: FloatArray, looks: int) -> float:
    """Return the standard deviation of the mean of `looks` values, relative to the mean of all; NaN for too few."""
    groups = lengths[: len(lengths) // looks * looks].reshape(-1, looks).mean(axis=1)
    return float(groups.std(ddof=1) / lengths.mean()) if len(groups) > 1 else float("nan")


def looked_at(backend: BlazePose, picture: Picture, region: Region, rng: np.random.Generator) -> FloatArray:
    """Return torso length and distance of the eyes of every look, shape (looks, 2)."""
    rows: list[tuple[float, float]] = []
    for number in range(_LOOKS):
        right, down = rng.normal(0, _ASIDE, 2)
        moved = region.moved(right, down, float(np.exp(rng.normal(0, _RESIZED))))
        look = backend._landmarks.look(picture, moved, mirrored=number % 2 == 1, quick=True)  # pyright: ignore
        points = look.keypoints_px
        torso = points[_SHOULDERS].mean(axis=0) - points[_HIPS].mean(axis=0)
        rows.append((float(np.linalg.norm(torso)), float(np.linalg.norm(points[_EYES[0]] - points[_EYES[1]]))))
    return np.array(rows)


def pupils(backend: BlazePose, picture: Picture, face: Face, rng: np.random.Generator) -> FloatArray:
    """Return the pupils' distance from face boxes moved and resized a little, shape (looks,)."""
    box, points = face.box_px, face.points_px
    side = float((box[2:] - box[:2]).max())
    found: list[float] = []
    for _ in range(_LOOKS):
        shift = rng.normal(0, _ASIDE, 2) * side
        grown = float(np.exp(rng.normal(0, _RESIZED)))
        middle = (box[:2] + box[2:]) / 2
        moved = np.concatenate([middle + (box[:2] - middle) * grown, middle + (box[2:] - middle) * grown])
        seen = backend._pupils.find(picture, moved + np.tile(shift, 2), points + shift)  # pyright: ignore
        if seen is not None:
            found.append(float(np.linalg.norm(seen.left_px - seen.right_px)))
    return np.array(found)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--photos", type=Path, default=Path("../shared/data/photos"))
    parser.add_argument("--most", type=int, default=6, help="people a photo at most, those with the best scores")
    args = parser.parse_args()
    backend = backend_named("blazepose", PoseOptions(threads=1))
    assert isinstance(backend, BlazePose)
    rng = np.random.default_rng(1)
    torsos: list[FloatArray] = []
    eyes: list[tuple[FloatArray, FloatArray]] = []
    for path in photos_in(args.photos):
        picture = Picture(Photo.open(path).pixels(2400))
        boxes = backend._boxes(picture)  # pyright: ignore
        if boxes is None:
            raise SystemExit("the person detector is not here: `proxemetry models fetch`")
        search = Search(picture, backend._landmarks, 40)  # pyright: ignore
        search.visit(in_boxes(boxes, picture))
        people: list[tuple[float, Region, Face | None]] = []
        for sighting in search.sightings:
            face = face_of(sighting.candidate, picture, backend._face)  # pyright: ignore
            sighting.face = 0.0 if face is None else face.score
            people.append((person_score(sighting), sighting.candidate.next_region, face))
        sure = sorted((p for p in people if p[0] > _SURE), key=lambda p: -p[0])
        for _, region, face in sure[: args.most]:
            lengths = looked_at(backend, picture, region, rng)
            torsos.append(lengths[:, 0])
            irises = np.zeros(0) if face is None else pupils(backend, picture, face, rng)
            if len(irises) == _LOOKS:
                eyes.append((lengths[:, 1], irises))
    print(f"{'scatter of the mean of':32s}  people   1 look  2 looks  6 looks")
    for label, rows in (
        ("torso length", torsos),
        ("eyes of the landmark network", [network for network, _ in eyes]),
        ("pupils of face mesh and iris", [iris for _, iris in eyes]),
    ):
        figures = "".join(f"{np.nanmedian([scatter(row, n) for row in rows]):9.1%}" for n in (1, 2, 6))
        print(f"{label:32s} {len(rows):7d}{figures}")


if __name__ == "__main__":
    main()
