"""`proxemetry review`: open the review page."""

from __future__ import annotations

import argparse
import importlib.util
import json
import math
from dataclasses import asdict
from functools import partial

from ..errors import SettingsError
from ..plots.faces import FACES
from . import end_as_by_ctrl_c

_EXAMPLES = """examples:
  proxemetry review results                    go through a run photo by photo and correct what is wrong
  proxemetry review                            drop photos onto the page, or measure a folder from it
  proxemetry review results --who ben --blind  a second reviewer who must not see the first one's corrections
  proxemetry review results --agreement ada ben  report how well the two agree
"""

_HOW_IT_ENDS = "Ctrl-C ends it; everything is saved as you go"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.epilog = _EXAMPLES
    parser.add_argument(
        "results", nargs="?", metavar="DIR", help="results folder; without it, drop photos or measure a folder"
    )
    parser.add_argument("--who", metavar="NAME", help="name to keep corrections under (default: reviewer)")
    parser.add_argument("--blind", action="store_true", help="hide and leave out other people's corrections")
    parser.add_argument("--faces", choices=FACES, default="show", help="blur: pixelate heads on the page")
    parser.add_argument("--port", type=int, default=0, metavar="N", help="port on this machine (default: any free one)")
    parser.add_argument("--no-browser", action="store_true", help="print the address and open nothing")
    parser.add_argument("--agreement", nargs=2, metavar=("ONE", "OTHER"), help="compare two reviewers, as JSON")


def run(args: argparse.Namespace) -> int:
    """Serve until Ctrl-C."""
    if importlib.util.find_spec("starlette") is None or importlib.util.find_spec("uvicorn") is None:
        raise SettingsError("the review page needs two more packages: pip install 'proxemetry[web]'")
    from ..web.app import create_app
    from ..web.serve import serve
    from ..web.session import Review
    from ..web.stores import DropStore, FolderStore

    end_as_by_ctrl_c()  # dropped photos are deleted at the end, whichever it is
    if args.agreement and not args.results:
        raise SettingsError("--agreement compares two reviewers of a results folder: name it")
    who = ("reviewer" if args.who is None else args.who).strip()
    if not who:
        raise SettingsError("--who is empty: corrections are kept under a name")
    store = FolderStore(args.results) if args.results else DropStore()
    review = Review(store, who, faces=args.faces, blind=args.blind)
    if args.agreement:
        found = review.agreement(*args.agreement)
        fields = {**asdict(found), "share_alike": found.share_alike}
        shown = {k: None if isinstance(v, float) and math.isnan(v) else v for k, v in fields.items()}
        print(json.dumps(shown, indent=2))
        return 0
    try:
        serve(
            partial(create_app, review), port=args.port, open_browser=not args.no_browser,
            on_ready=lambda address: print(f"review page: {address}\n{_HOW_IT_ENDS}", flush=True),
        )  # fmt: skip
    finally:
        if isinstance(store, DropStore):
            store.close()
    return 0
