"""The option for which pairs count, of every command that counts pairs."""

from __future__ import annotations

import argparse


def add_pairs_where(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:  # pyright: ignore[reportPrivateUsage]
    """Add `--pairs-where`, see `people.attributes.PairsWhere`."""
    parser.add_argument(
        "--pairs-where", action="append", default=[], metavar="ATTRIBUTE=VALUE",
        help="count only people with this attribute, like mask=no, and pairs of two such people; doubt=none leaves out "
        "doubtful people; given again with another attribute, both must hold; with the same one, either will do",
    )  # fmt: skip
