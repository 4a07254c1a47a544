"""The options of commands that measure: the back end, the bodies to expect, and how the run works."""

from __future__ import annotations

import argparse

from ..errors import SettingsError
from ..locate import BODY_SIZES, LocateSettings
from ..pose import DEVICES, EFFORTS, PoseOptions
from .camera_options import number

#: A parser, or a group of its options.
Options = argparse.ArgumentParser | argparse._ArgumentGroup  # pyright: ignore[reportPrivateUsage]


def add_pose_options(parser: Options) -> None:
    """Add the options for the back end that finds the people."""
    parser.add_argument(
        "--pose", default="auto", metavar="NAME", help="back end: auto, a name, or recorded:FILE (default: auto)"
    )
    parser.add_argument(
        "--effort", default="normal", choices=EFFORTS, help="how thoroughly people are searched for (default: normal)"
    )
    parser.add_argument(
        "--device", default="cpu", choices=DEVICES, help="what the networks of ONNX back ends run on (default: cpu)"
    )
    parser.add_argument("--flip", action="store_true", help="detect each person in the mirrored photo too, and average")


def pose_options(args: argparse.Namespace) -> PoseOptions:
    """Return the options of the back end."""
    return PoseOptions(effort=args.effort, offline=args.offline, device=args.device, flip=args.flip)


def add_body_options(parser: Options) -> None:
    """Add the options for the body lengths to expect."""
    defaults = LocateSettings()
    parser.add_argument(
        "--body-size", default=defaults.body_size, choices=BODY_SIZES,
        help=f"body sizes to expect; mixed: adults and some children (default: {defaults.body_size})",
    )  # fmt: skip
    parser.add_argument(
        "--child-weight", type=number, metavar="SHARE",
        help=f"share of children where --body-size is mixed (default: {defaults.child_weight:g})",
    )  # fmt: skip


def child_weight(args: argparse.Namespace) -> float:
    """Return the share of children that the options state, or the usual one."""
    return LocateSettings().child_weight if args.child_weight is None else args.child_weight


def add_run_options(parser: Options) -> None:
    """Add the options for how the work is done."""
    parser.add_argument(
        "--jobs", type=int, metavar="N", help="worker processes (default: one per core; 0: none, for debugging)"
    )
    parser.add_argument("--restart", action="store_true", help="start over: measure again what the folder already has")
    parser.add_argument(
        "--offline", action="store_true", help="fetch nothing: fail if a network is not on this machine"
    )


def require_jobs(args: argparse.Namespace) -> None:
    """Refuse a negative number of worker processes."""
    if args.jobs is not None and args.jobs < 0:
        raise SettingsError(f"--jobs {args.jobs}: it must be 0 or more")
