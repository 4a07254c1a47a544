"""`proxemetry` and `python -m proxemetry`."""

import os
import sys

#: What a shell returns for a command that Ctrl-C ended.
INTERRUPTED = 130


def main() -> int:
    """Run the command line; Ctrl-C while it is still loading ends without a traceback, too."""
    try:
        _name_files_in_utf8()
        from .cli import main

        code = main()
    except KeyboardInterrupt:
        code = INTERRUPTED
    # CPython remembers a KeyboardInterrupt that left an exec() of text, which dataclasses use while modules load, even
    # though it was caught: at its end this process would be killed by SIGINT instead of having an exit code. The next
    # exec() makes it forget (run_eval_code_obj in Python/pythonrun.c).
    exec("")
    return code


def _name_files_in_utf8() -> None:
    """Begin again in Python's UTF-8 mode where the locale would have files named otherwise, as ISO-8859-1 does.

    A photo's name in the tables is the same on every machine then, and no name is beyond what can be opened. Python
    does it by itself in the C locale, unless PYTHONUTF8=0 forbids it. What is printed stays in the terminal's encoding.
    """
    if os.name != "posix" or sys.flags.utf8_mode or sys.getfilesystemencoding() == "utf-8":
        return
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    environment = {**os.environ, "PYTHONUTF8": "1", "PYTHONIOENCODING": f"{encoding}:backslashreplace"}
    os.execve(sys.executable, [sys.executable, "-m", "proxemetry", *sys.argv[1:]], environment)


if __name__ == "__main__":
    sys.exit(main())
