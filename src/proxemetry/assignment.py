"""The exact minimum-cost assignment, for the dozens of people of a photo: shortest augmenting paths."""

from __future__ import annotations

import numpy as np

from .arrays import FloatArray


def assign(costs: FloatArray) -> list[tuple[int, int]]:
    """Return the pairs (row, column) of least total cost, min(N, M) of them, by row.

    costs: shape (N, M), finite. O(N^2 M) by the Hungarian method with potentials (Kuhn 1955, Munkres 1957, in the
    form of Jonker and Volgenant 1987).
    """
    if costs.size == 0:
        return []
    if costs.shape[0] > costs.shape[1]:
        return sorted((row, column) for column, row in assign(costs.T))
    rows, columns = costs.shape
    row_potential, column_potential = np.zeros(rows), np.zeros(columns + 1)
    owner = np.full(columns + 1, -1)  # owner[column] is its row; the last column is where each search starts
    for row in range(rows):
        owner[columns], column = row, columns
        slack, parent = np.full(columns, np.inf), np.full(columns, columns)
        done = np.zeros(columns + 1, dtype=bool)
        while owner[column] >= 0:
            done[column] = True
            here = owner[column]
            reduced = costs[here] - row_potential[here] - column_potential[:columns]
            better = ~done[:columns] & (reduced < slack)
            slack[better], parent[better] = reduced[better], column
            open_slack = np.where(done[:columns], np.inf, slack)
            column = int(open_slack.argmin())
            step = open_slack[column]
            row_potential[owner[done]] += step
            column_potential[done] -= step
            slack[~done[:columns]] -= step
        while column != columns:
            owner[column] = owner[parent[column]]
            column = int(parent[column])
        owner[columns] = -1
    return sorted((int(owner[c]), c) for c in range(columns) if owner[c] >= 0)
