"""`proxemetry models`: the networks' files - what there is, where they are, whether they are intact."""

from __future__ import annotations

import argparse
import sys
import textwrap

from .. import weights
from ..errors import ModelError
from ..pose import BACKENDS
from ..pose.default_eyes import choose
from ..text_tables import Columns, in_blocks, terminal_width
from ..weights import Model
from . import DONE, SOME_FAILED

_EXAMPLES = """examples:
  proxemetry models list                        what there is, its licence, and what is here
  proxemetry models fetch                       the best back end available, which --pose auto then uses
  proxemetry models fetch yolox_nano.onnx       a single network
  proxemetry models add ~/Downloads/FILE        a file that you already have
  proxemetry models verify                      check every file that is here
  proxemetry models path pose_detection         where the file is

PROXEMETRY_CACHE names the folder, or several as in PATH: all are searched, the first writable one receives new files.
PROXEMETRY_OFFLINE=1 forbids fetching. PROXEMETRY_MIRROR is a web address that is tried first.
"""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add this command's options."""
    parser.epilog = _EXAMPLES
    actions = parser.add_subparsers(dest="action", metavar="list|fetch|verify|path|add", required=True)
    actions.add_parser("list", help="every network: licence, size, origin, and whether it is here")
    fetch = actions.add_parser("fetch", help="fetch networks (without names: those of the best back end available)")
    fetch.add_argument("names", nargs="*", metavar="NAME", help="a network, or all those of a back end")
    fetch.add_argument(
        "--accept-licence", action="store_true", help="needed for networks whose licence forbids commercial use"
    )
    fetch.add_argument(
        "--offline", action="store_true", help="fetch nothing: fail if something needed is not on this machine"
    )
    verify = actions.add_parser("verify", help="check hashes (without names: of every file that is here)")
    verify.add_argument("names", nargs="*", metavar="NAME")
    path = actions.add_parser("path", help="print where a network is (without names: the cache folders)")
    path.add_argument("names", nargs="*", metavar="NAME")
    add = actions.add_parser("add", help="copy a file that you already have into the cache, if its hash is right")
    add.add_argument("file", metavar="FILE")
    add.add_argument("--name", help="which network it is; without it the hash decides")


def run(args: argparse.Namespace) -> int:
    """Run one action and return the exit code."""
    return {"list": _list, "fetch": _fetch, "verify": _verify, "path": _path, "add": _add}[args.action](args)


def _list(args: argparse.Namespace) -> int:
    models = list(weights.MODELS.values())
    names = Columns("", ("name",), tuple((model.name,) for model in models))
    facts = Columns("", ("here", "MB", "commercial", "sha256"), tuple(map(_facts, models)))
    width = terminal_width()
    head, *lines = in_blocks(names, [facts], width)
    _say(head)
    for model, line in zip(models, lines, strict=True):
        _say(line)
        trained = f"; trained on {model.training_data}" if model.training_data else ""
        text = f"{model.licence}; {model.origin}{trained}"
        for part in textwrap.wrap(text, width, initial_indent="    ", subsequent_indent="    "):
            _say(part)
    _say("commercial: whether the licence allows commercial use; sha256 (its beginning): of the file")
    return DONE


def _facts(model: Model) -> tuple[str, ...]:
    try:
        here = "yes" if weights.is_here(model.name) else "no"
    except ModelError:
        here = "NOT A FILE"
    size = f"{model.size_bytes / 1e6:.1f}" if model.size_bytes else "?"
    return (here, size, "yes" if model.commercial_use else "NO", model.sha256[:12])


def _fetch(args: argparse.Namespace) -> int:
    shown = _Shown()
    if args.names:
        names = [model for name in args.names for model in _networks_of(name)]
        located = weights.fetch(
            names, accept_licence=args.accept_licence, offline=args.offline, log=shown.log, progress=shown.progress
        )
    else:
        name = choose(offline=args.offline, log=shown.log, progress=shown.progress)
        located = [weights.obtain(model) for model in BACKENDS[name].models]
        located += [weights.verify(model) for model in BACKENDS[name].wants if weights.locate(model) is not None]
    shown.finish()
    for one in located:
        _say(f"{one.path}  {one.sha256}")
    return DONE


def _networks_of(name: str) -> tuple[str, ...]:
    """Return a back end's networks, or the name itself, which is that of a network."""
    return BACKENDS[name].models if name in BACKENDS and BACKENDS[name].models else (name,)


class _Shown:
    """Lines and a percentage on standard error; the percentage only on a terminal."""

    def __init__(self) -> None:
        self._last = ""

    def log(self, line: str) -> None:
        self.finish()
        sys.stderr.write(line + "\n")

    def progress(self, done: int, total: int | None) -> None:
        text = f"{done / 1e6:.0f} MB" + (f", {min(100 * done // total, 100)} %" if total else "")
        if text != self._last and sys.stderr.isatty():
            self._last = text
            sys.stderr.write(f"\r{text} ")
            sys.stderr.flush()

    def finish(self) -> None:
        """Clear the percentage."""
        if self._last:
            sys.stderr.write("\r" + " " * (len(self._last) + 1) + "\r")
            self._last = ""


def _verify(args: argparse.Namespace) -> int:
    names = args.names or [name for name in weights.MODELS if _lies_there(name)]
    failed = 0
    for name in names:
        try:
            located = weights.verify(name)
        except ModelError as error:
            _say(str(error))
            failed += 1
        else:
            _say(f"{located.path}: intact ({located.sha256})")
    if not names:
        _say("no network is here yet: `proxemetry models fetch`")
    return SOME_FAILED if failed else DONE


def _lies_there(name: str) -> bool:
    """Return whether anything has a network's name in the cache, be it a file or not."""
    try:
        return weights.locate(name) is not None
    except ModelError:
        return True


def _path(args: argparse.Namespace) -> int:
    if not args.names:
        for folder in weights.cache_folders():
            _say(str(folder))
    for name in args.names:
        _say(str(weights.verify(name).path))
    return DONE


def _add(args: argparse.Namespace) -> int:
    located = weights.add(args.file, args.name)
    _say(f"{located.path}  {located.sha256}")
    return DONE


def _say(line: str) -> None:
    sys.stdout.write(line + "\n")
