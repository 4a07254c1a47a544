"""Write docs/cli.md and docs/api.md from the program itself: `python -m docs.reference`. A test keeps them current."""

from __future__ import annotations

import inspect
import os
import re
import subprocess
import sys
from pathlib import Path

import proxemetry
from proxemetry.cli import COMMANDS

ROOT = Path(__file__).resolve().parent.parent


def cli_page() -> str:
    """Return every command's own help."""
    lines = ["# Command line reference", "", "What `proxemetry COMMAND --help` prints.", ""]
    for command in ("", *COMMANDS):
        lines += [f"## proxemetry {command}".rstrip(), "", "```text", _help(command), "```", ""]
    return "\n".join(lines)


def _help(command: str) -> str:
    arguments = [sys.executable, "-m", "proxemetry", *filter(None, [command]), "--help"]
    environment = {**os.environ, "COLUMNS": "110"}
    return subprocess.run(arguments, capture_output=True, text=True, check=True, env=environment).stdout.rstrip()


def api_page() -> str:
    """Return the public names with their signatures and docstrings."""
    lines = ["# Python reference", "", "`import proxemetry as px`; everything else is internal and may change.", ""]
    for name in sorted(proxemetry.__all__, key=str.casefold):
        thing = getattr(proxemetry, name)
        if name.startswith("__") or not (inspect.isclass(thing) or inspect.isfunction(thing)):
            continue
        lines += [f"## px.{name}", "", "```python", _signature(name, thing), "```", "", _text(thing), ""]
        if inspect.isclass(thing):
            for method, function in sorted(vars(thing).items()):
                inner = getattr(function, "__func__", function)
                inner = getattr(inner, "fget", None) or getattr(inner, "func", None) or inner
                if method.startswith("_") or not inspect.isfunction(inner) or not inner.__doc__:
                    continue
                lines += [f"**`{method}`** {' '.join(inspect.cleandoc(inner.__doc__).split())}", ""]
    return "\n".join(lines)


def _signature(name: str, thing: object) -> str:
    try:
        signature = f"{name}{inspect.signature(thing)}".replace("'", "")  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return name
    return re.sub(r"<function .+? at 0x[0-9a-f]+>", "...", signature)  # where it lies in memory is another each time


def _text(thing: object) -> str:
    return inspect.cleandoc(thing.__doc__ or "").replace("\n    ", "\n")


def main() -> None:
    """Write both pages."""
    (ROOT / "docs" / "cli.md").write_text(cli_page(), encoding="utf-8")
    (ROOT / "docs" / "api.md").write_text(api_page(), encoding="utf-8")


if __name__ == "__main__":
    main()
