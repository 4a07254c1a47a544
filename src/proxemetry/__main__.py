"""`proxemetry` and `python -m proxemetry`."""

import sys

#: What a shell returns for a command that Ctrl-C ended.
INTERRUPTED = 130


def main() -> int:
    """Run the command line; Ctrl-C while it is still loading ends without a traceback, too."""
    try:
        from .cli import main
    except KeyboardInterrupt:
        return INTERRUPTED
    return main()


if __name__ == "__main__":
    sys.exit(main())
