"""How many measured photos have a focal length that is stated, recorded, estimated or assumed: counted by its type."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from ...camera import FocalBasis

#: How each is named where photos are counted, in the order of their trust.
WORDS: Mapping[FocalBasis, str] = MappingProxyType({
    FocalBasis.STATED: "stated",
    FocalBasis.RECORDED: "recorded in the file",
    FocalBasis.ESTIMATED: "estimated",
    FocalBasis.ASSUMED: "ASSUMED",
})  # fmt: skip


def focal_bases(duck: Any, photos: str) -> dict[FocalBasis, int]:
    """Return how many measured photos of a table (SQL) there are of each basis, all of them named."""
    rows = duck.execute(f"SELECT focal_basis, count(*) FROM {photos} WHERE status = 'ok' GROUP BY focal_basis")
    found = {FocalBasis(basis): int(number) for basis, number in rows.fetchall() if basis is not None}
    return {basis: found.get(basis, 0) for basis in FocalBasis}


def in_words(counts: Mapping[FocalBasis, int]) -> str:
    """Return counts as a phrase, without those of nothing: "3 stated, 2 estimated"; empty where all are zero."""
    return ", ".join(f"{counts[basis]:,} {words}" for basis, words in WORDS.items() if counts[basis])
