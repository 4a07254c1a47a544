"""The command line: one module a command, each a thin face that parses, calls the library and writes.

Exit codes: 0 done; 1 done, but some photos failed (each has a row with the reason); 2 nothing could be done (one line
on stderr: what, where, what to do).
"""

from __future__ import annotations

import argparse
import importlib
import importlib.util
import io
import signal
import sys
from collections.abc import Sequence
from typing import Any, NoReturn

from ..archive.store.signals import answered_afterwards, interruptible
from ..errors import ProxemetryError, SettingsError
from ..version import __version__

#: Command -> its line of `--help`. Module `cli.COMMAND` has `configure(parser)` and `run(args) -> exit code`.
COMMANDS: dict[str, str] = {
    "measure": "measure how far apart the people in photos stand",
    "review": "look through the photos in the browser and correct what is wrong",
    "report": "write one self-contained page on a results folder",
    "summary": "print an archive's figures by year, country, folder or any other column",
    "export": "write results for other programs: Excel, SPSS, CSV of other countries, COCO keypoints",
    "figures": "draw circles on the floor, or the floor as seen from above, for photos of a results folder",
    "doctor": "check this installation, or what photos state about their camera and what is missing",
    "models": "list, fetch and check the networks that find people",
    "calibrate": "find where a fixed camera is, once, for all its photos: from points, lengths or the people",
    "video": "measure in clips who was near whom, how near, and for how long",
    "annotate": "make a benchmark of your own photos: points, taped places, label files, scores",
    "score": "score predictions against a benchmark's labels, or check a labels folder",
    "benchmark": "run methods on a benchmark's photos, or its annotated points, and score them",
}

_EXAMPLES = """to begin:
  proxemetry models fetch                                fetch the networks that find people, once
  proxemetry measure my_photos --out results --overlays  measure a folder of photos
  proxemetry review results                              look through the photos and correct what is wrong
  proxemetry report results                              one page with figures and a methods paragraph

`proxemetry COMMAND --help` explains a command, with examples. Without a command, a page opens in the browser on which
you measure photos and folders.
"""

DONE, SOME_FAILED, NOTHING_DONE = 0, 1, 2

#: Address space below which DuckDB or numpy end the process without a word.
_LEAST_MEMORY_BYTES = 1_500_000_000


class _Parser(argparse.ArgumentParser):
    """A parser whose refusals are one line: the usage of a command with thirty options would bury what was wrong.

    Photos may be named after options too: argparse by itself takes all positional arguments from their first place.
    """

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: Any = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse; words left over go to the command's list of names, unless an unknown option is among them."""
        found, left = super().parse_known_args(args, namespace)
        if not left or any(word.startswith("-") for word in left):
            return found, left
        positional = self._get_positional_actions()  # pyright: ignore[reportPrivateUsage]
        if not positional or positional[-1].nargs not in ("*", "+"):
            return found, left
        setattr(found, positional[-1].dest, [*(getattr(found, positional[-1].dest) or []), *left])
        return found, []

    def error(self, message: str) -> NoReturn:
        """Print what was wrong and where help is, and leave with exit code 2."""
        problem = message.removeprefix("argument ")
        self.exit(NOTHING_DONE, f"{self.prog}: {problem}; `{self.prog} --help` explains\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a name that the terminal's encoding lacks ends nothing
            stream.reconfigure(errors="backslashreplace")
    try:
        _require_memory()
        with interruptible():
            return _run(arguments)
    except ProxemetryError as error:
        print(f"proxemetry: {error}", file=sys.stderr)
        return NOTHING_DONE
    except KeyboardInterrupt as stop:
        print(f"proxemetry: stopped; what was finished is kept{''.join(map(str, stop.args))}", file=sys.stderr)
        return 130
    except BrokenPipeError:
        sys.stderr.close()
        return DONE


def _print_completion(parser: argparse.ArgumentParser, shell: str) -> int:
    try:
        import shtab
    except ImportError as error:
        raise SettingsError("completion needs one more package: pip install 'proxemetry[completion]'") from error
    print(shtab.complete(parser, shell))
    return DONE


class Once(argparse.Action):
    """An option that may be given once: neither of two values is dropped silently."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: object, option: str | None = None
    ) -> None:
        """Take the value, or refuse the second."""
        given = f"_given_{self.dest}"
        if getattr(namespace, given, False):
            parser.error(f"{option} is given twice: it takes one value")
        setattr(namespace, given, True)
        setattr(namespace, self.dest, values)


def _require_memory() -> None:
    """Raise SettingsError where so little memory may be taken that a library would end the process."""
    if importlib.util.find_spec("resource") is None:
        return  # only POSIX limits it this way
    import resource

    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY and limit < _LEAST_MEMORY_BYTES:
        least = _LEAST_MEMORY_BYTES / 1e6
        raise SettingsError(
            f"this shell allows {limit / 1e6:.0f} MB of memory (ulimit -v), but {least:.0f} MB are needed"
        )


def end_as_by_ctrl_c() -> None:
    """Let this process unwind where a batch system ends it or its terminal closes: what is temporary goes."""
    import threading

    if threading.current_thread() is not threading.main_thread():
        return  # a program that runs a command in a thread handles the signals itself
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    hang_up = getattr(signal, "SIGHUP", None)
    if hang_up is not None and signal.getsignal(hang_up) != signal.SIG_IGN:  # nohup asks for that
        signal.signal(hang_up, lambda *_: signal.raise_signal(signal.SIGTERM))  # as whoever has taken that over since


def command_parser(arguments: Sequence[str]) -> argparse.ArgumentParser:
    """Return the parser; of the commands only those that the arguments name have their options."""
    parser = _Parser(
        prog="proxemetry",
        description="Measure how far apart people stand in ordinary photographs.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"proxemetry {__version__}")
    parser.add_argument(
        "--print-completion", choices=("bash", "zsh", "tcsh"), metavar="SHELL",
        help="print the script with which bash, zsh or tcsh completes commands (docs/install.md)",
    )  # fmt: skip
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND")
    chosen = {a for a in arguments if a in COMMANDS} if "--print-completion" not in arguments else set(COMMANDS)
    for command, summary in COMMANDS.items():
        subparser = subparsers.add_parser(
            command, help=summary, description=summary, formatter_class=argparse.RawDescriptionHelpFormatter
        )
        if command in chosen:  # only the command that runs is imported: `--help` stays quick
            with answered_afterwards():  # numpy, for one, would say that it is badly installed
                module = importlib.import_module(f"{__name__}.{command}")
            module.configure(subparser)
            subparser.set_defaults(run=module.run)
    return parser


def _run(arguments: list[str]) -> int:
    parser = command_parser(arguments)
    args = parser.parse_args(arguments)
    if args.print_completion is not None:
        return _print_completion(parser, args.print_completion)
    if args.command is None and sys.stdout.isatty() and importlib.util.find_spec("uvicorn") is not None:
        return _run(["review"])  # a user at a screen: the page on which photos are dropped and folders measured
    if args.command is None:
        parser.print_help(sys.stderr)
        return NOTHING_DONE
    return args.run(args)
