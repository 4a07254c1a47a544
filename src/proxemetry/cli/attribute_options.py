"""The option for whose pairs count, of every command that counts pairs."""

from __future__ import annotations

import argparse


def add_pairs_where(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:  # pyright: ignore[reportPrivateUsage]
    """Add `--pairs-where`, see `people.attributes.PairsWhere`."""
    parser.add_argument(
        "--pairs-where", action="append", default=[], metavar="ATTRIBUTE=VALUE",
        help="count only people recorded with this attribute, and pairs of two such people, like mask=no; again with "
        "another attribute: both hold; with the same one: either value",
    )  # fmt: skip
