"""How crowded a floor is: persons per square metre, classic and by Voronoi cells, and maps of it over time.

Classic: people within a region by its area. Voronoi (Steffen and Seyfried 2010): each person has the part of the floor
that is nearer to them than to anyone else; density is its inverse, averaged over the region. The second jumps less
when a person steps over the line.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Region:
    """A part of the floor: a simple polygon of corners (n, 2) in metres, in either order, convex or not."""

    corners_m: FloatArray

    def __post_init__(self) -> None:
        corners = np.array(self.corners_m, dtype=float).reshape(-1, 2)
        if len(corners) > 1 and np.allclose(corners[0], corners[-1]):
            corners = corners[:-1]
        corners = corners if signed_area(corners) >= 0 else corners[::-1]
        corners = np.ascontiguousarray(corners)
        corners.setflags(write=False)
        object.__setattr__(self, "corners_m", corners)

    @property
    def area_m2(self) -> float:
        """Its area."""
        return signed_area(self.corners_m)

    def holds(self, places_m: FloatArray) -> NDArray[np.bool_]:
        """Return which places (n, 2) lie in it, by the even-odd rule."""
        x, y = places_m[:, 0], places_m[:, 1]
        inside = np.zeros(len(places_m), dtype=bool)
        for (x0, y0), (x1, y1) in zip(self.corners_m, np.roll(self.corners_m, -1, axis=0), strict=True):
            crosses = (y0 > y) != (y1 > y)
            with np.errstate(divide="ignore", invalid="ignore"):
                inside ^= crosses & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
        return inside

    @classmethod
    def around(cls, places_m: FloatArray, margin_m: float = 0.5) -> Region:
        """Return the convex hull of places (n, 2), each with a square of this margin about it."""
        corners = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]]) * margin_m
        spread = (places_m[:, None] + corners).reshape(-1, 2).astype(np.float32)
        return cls(cv2.convexHull(spread)[:, 0].astype(float))


def signed_area(corners: FloatArray) -> float:
    """Return the area of a polygon (n, 2), positive where its corners turn from x towards y."""
    x, y = corners[:, 0], corners[:, 1]
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) / 2)


def classic_density(places_m: FloatArray, region: Region) -> float:
    """Return how many of the places (n, 2) lie in the region, per square metre."""
    return float(region.holds(places_m).sum()) / region.area_m2


def voronoi_cells(places_m: FloatArray, floor: Region) -> list[FloatArray]:
    """Return each person's part of the floor as corners (m, 2); an empty one for a person off it.

    Two at one place share: each is moved by less than a millimetre.
    """
    places = np.asarray(places_m, dtype=float).reshape(-1, 2)
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1)
    inside = floor.holds(places)
    cells: list[FloatArray] = []
    for k in range(len(places)):
        cell = floor.corners_m if inside[k] else np.zeros((0, 2))
        for other in np.argsort(apart[k], kind="stable"):
            if other == k or not len(cell) or not inside[other]:
                continue
            if apart[k, other] > 2 * np.linalg.norm(cell - places[k], axis=1).max():
                break
            cell = _clipped(cell, places[k], places[other], 1 if k < other else -1)
        cells.append(cell)
    return cells


def _clipped(cell: FloatArray, mine: FloatArray, theirs: FloatArray, sign: int) -> FloatArray:
    """Return the part of a polygon nearer to `mine` than to `theirs` (Sutherland and Hodgman 1974)."""
    normal = theirs - mine
    if np.abs(normal).max() < 1e-6:
        normal = np.array([1e-4, 0.0]) * sign
        mine, theirs = mine - normal / 2, mine + normal / 2
    return _below(cell, normal, float(normal @ (mine + theirs) / 2))


def _below(polygon: FloatArray, normal: FloatArray, offset: float) -> FloatArray:
    """Return the part of a polygon where normal . x <= offset."""
    side = polygon @ normal - offset
    kept: list[FloatArray] = []
    for k in range(len(polygon)):
        here, there = side[k - 1], side[k]
        if (here > 0) != (there > 0):
            kept.append(polygon[k - 1] + (polygon[k] - polygon[k - 1]) * (here / (here - there)))
        if there <= 0:
            kept.append(polygon[k])
    return np.array(kept).reshape(-1, 2)


def voronoi_density(places_m: FloatArray, region: Region, floor: Region | None = None) -> float:
    """Return the Voronoi density of a region, in persons per square metre.

    Each person counts by the share of the cell that lies in the region. floor: where people can be, which bounds the
    cells; the region itself where it is not given, and then the result is the classic density. The region must be
    convex where it is not the floor.
    """
    if floor is None or floor is region:
        return classic_density(places_m, region)
    people = 0.0
    for cell in voronoi_cells(places_m, floor):
        area = signed_area(cell) if len(cell) > 2 else 0.0
        if area > 0:
            people += signed_area(_within(cell, region)) / area
    return people / region.area_m2


def _within(polygon: FloatArray, convex: Region) -> FloatArray:
    corners = convex.corners_m
    for here, there in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if not len(polygon):
            break
        normal = np.array([there[1] - here[1], here[0] - there[0]])
        polygon = _below(polygon, normal, float(normal @ here))
    return polygon if len(polygon) else np.zeros((0, 2))


def personal_space_m2(places_m: FloatArray, floor: Region) -> FloatArray:
    """Return the area of each person's Voronoi cell, shape (n,); NaN for a person off the floor."""
    areas = [signed_area(c) if len(c) > 2 else np.nan for c in voronoi_cells(places_m, floor)]
    return np.array(areas, dtype=float).reshape(-1)


#: Maps have cells of this size, and at most so many of them along a side and so many moments.
CELL_M, _MOST_CELLS, MOST_MOMENTS = 0.5, 400, 60


@dataclass
class Maps:
    """What is summed over time on a grid of the floor; rows are y, columns x, the first cell at `origin_m`.

    presence_s: shape (T, Y, X), person-seconds in each cell in each of T stretches of time. exposure_s: shape (L, Y,
    X), seconds within each limit of another person, of the people in each cell. stretch_s: how long a stretch is.
    """

    origin_m: FloatArray
    cell_m: float
    stretch_s: float
    limits_m: tuple[float, ...]
    presence_s: FloatArray
    exposure_s: FloatArray

    @classmethod
    def over(cls, region: Region, seconds: float, limits_m: tuple[float, ...]) -> Maps:
        """Return empty maps of a region and of so many seconds."""
        low, high = region.corners_m.min(axis=0), region.corners_m.max(axis=0)
        cell = max(CELL_M, float((high - low).max()) / _MOST_CELLS)
        width, height = (max(1, int(np.ceil(v / cell))) for v in high - low)
        moments = int(min(MOST_MOMENTS, max(1, np.ceil(seconds / 10))))
        stretch = max(seconds, 1e-9) / moments
        return cls(
            low, cell, stretch, limits_m, np.zeros((moments, height, width)), np.zeros((len(limits_m), height, width))
        )

    def _cells(self, places_m: FloatArray) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        index = np.floor((places_m - self.origin_m) / self.cell_m).astype(np.intp)
        height, width = self.presence_s.shape[1:]
        inside = (index >= 0).all(axis=1) & (index[:, 0] < width) & (index[:, 1] < height)
        return index[inside, 1], index[inside, 0], inside

    def add_presence(self, places_m: FloatArray, t_s: FloatArray, weight_s: FloatArray) -> None:
        """Count a person's path in: places (n, 2) at times (n,) that stand for weight_s (n,)."""
        rows, columns, inside = self._cells(places_m)
        moments = np.clip((t_s[inside] / self.stretch_s).astype(int), 0, len(self.presence_s) - 1)
        np.add.at(self.presence_s, (moments, rows, columns), weight_s[inside])

    def add_exposure(self, places_m: FloatArray, seconds: FloatArray) -> None:
        """Count one person's seconds (n, L) within each limit of another in, at that person's places (n, 2)."""
        rows, columns, inside = self._cells(places_m)
        for k in range(len(self.limits_m)):
            np.add.at(self.exposure_s[k], (rows, columns), seconds[inside, k])

    def density(self) -> FloatArray:
        """Return persons per square metre, shape (T, Y, X)."""
        return self.presence_s / (self.stretch_s * self.cell_m**2)

    def risk(self) -> FloatArray:
        """Return person-seconds within each limit per square metre, shape (L, Y, X)."""
        return self.exposure_s / self.cell_m**2

    def arrays(self) -> dict[str, Any]:
        """Return everything by name, as `maps.npz` holds it."""
        return {
            "origin_m": self.origin_m, "cell_m": np.array(self.cell_m), "stretch_s": np.array(self.stretch_s),
            "limits_m": np.array(self.limits_m), "density_persons_m2": self.density(), "risk_s_m2": self.risk(),
        }  # fmt: skip
