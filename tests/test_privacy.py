"""Nothing leaves the machine, and nothing is written but results and the caches that docs/privacy.md names.

Every command runs with its sockets and its files watched: by Python's audit events in its own and every worker process,
and by strace, where it may be used, for what libraries do below Python.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from proxemetry import telemetry
from synthetic.network_files import joints_network, yolox_detector
from synthetic.small_photos import write_photos

#: Caches that docs/privacy.md names, below the home folder.
NAMED_CACHES = (".cache/proxemetry", ".cache/matplotlib", ".config/matplotlib", ".cache/fontconfig")
_SYSTEM = ("/dev/", "/proc/")

#: Loaded by every Python process that is watched: writes down who connects where and what is opened to be written.
WATCHER = """
import os, sys
_log = os.open(os.environ["WATCH_LOG"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
def _hook(event, args):
    if event in ("socket.connect", "socket.sendto", "socket.getaddrinfo", "socket.gethostbyname"):
        where = args[1] if event in ("socket.connect", "socket.sendto") else args[0]
        os.write(_log, f"network {where!r}\\n".encode())
    elif event == "open" and isinstance(args[0], str):
        mode, flags = args[1], args[2]
        if isinstance(flags, int) and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            os.write(_log, f"file {os.path.abspath(args[0])}\\n".encode(errors="replace"))
sys.addaudithook(_hook)
"""

#: Runs every command in one process; each announces itself by a look at a path that is not there.
COMMANDS = '''
import json, os, sys, threading, urllib.request
import proxemetry.cli as cli

def asking(review, **options):
    """Serve a review as the command does, ask it for a page and a picture, and end it."""
    def ask(address):
        opener = urllib.request.build_opener(urllib.request.HTTPCookieProcessor())
        base = address.partition("?")[0]
        for path in (address, base + "api/photos", base + "api/photos/0", base + "api/photos/0/picture?size=320"):
            assert opener.open(path, timeout=30).status == 200
        os.kill(os.getpid(), 2)
    serve(review, **{**options, "on_ready": lambda a: threading.Thread(target=ask, args=(a,), daemon=True).start()})

if __name__ == "__main__":
    import proxemetry.web.serve as module
    serve, module.serve = module.serve, asking
    os.chdir(sys.argv[1])
    codes = {}
    for line in json.load(open("commands.json")):
        try:
            codes[" ".join(line)] = cli.main(line)
        except SystemExit as end:
            codes[" ".join(line)] = end.code
    json.dump(codes, open("results/codes.json", "w"))
'''


def _commands() -> list[list[str]]:
    onnx = ["measure", "photos", "--out", "results", "--pose", "onnx:spec.toml", "--assume-fov", "60", "--jobs", "1"]
    return [
        [*onnx, "--offline", "--overlays"],
        ["measure", "--out", "again", "--pose", "recorded:keypoints.json", "--jobs", "0"],
        ["report", "results"],
        ["export", "results"],
        ["export", "results", "--format", "spss"],
        ["export", "results", "--format", "coco"],
        ["summary", "results"],
        ["review", "results", "--no-browser"],
        ["annotate", "photos", "--out", "annotated", "--pose", "recorded:keypoints.json", "--no-browser"],
        ["annotate", "photos", "--out", "annotated", "--pose", "none", "--who", "ada", "--no-browser"],
        ["doctor"],
        ["doctor", "photos"],
        ["models", "list"],
        ["score", "predictions.json", "--labels", "labels"],
        ["--help"],
    ]


@pytest.fixture(scope="module")
def watched(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[str], str]:
    """Run all commands; return their folder, the audited events, and what strace saw ("" where there is none)."""
    pytest.importorskip("onnxruntime")
    pytest.importorskip("starlette")
    folder = tmp_path_factory.mktemp("watched")
    work, home, site, scratch = (folder / name for name in ("work", "home", "site", "tmp"))
    for path in (work, home, site, scratch):
        path.mkdir()
    write_photos(work / "photos", 1)
    yolox_detector(work / "detector.onnx", 416, (75, 125))
    joints_network(work / "pose.onnx", "simcc", 1)
    (work / "spec.toml").write_text(
        'skeleton = "coco17"\nperson_score = 0.1\nkeypoint_score = 0.05\n'
        '[detector]\nfile = "detector.onnx"\ndecode = "yolox"\ncolours = "bgr"\n'
        '[pose]\nfile = "pose.onnx"\ndecode = "simcc"\nmean = [0, 0, 0]\nstd = [1, 1, 1]\n'
    )
    person = {"keypoints": [[100 + 7 * k % 60, 90 + 11 * k, 0.9] for k in range(17)]}
    camera = {"fx": 700, "fy": 700, "cx": 320, "cy": 240}
    image = {"filename": "a.jpg", "width": 640, "height": 480, "camera": camera, "people": [person]}
    (work / "keypoints.json").write_text(json.dumps({"skeleton": "coco17", "images": [image]}))
    _write_labels(work)
    (work / "commands.json").write_text(json.dumps(_commands()))
    (site / "sitecustomize.py").write_text(WATCHER)
    (folder / "commands.py").write_text(COMMANDS)
    source = Path(telemetry.__file__).parents[1]
    environment = {
        "PATH": os.environ["PATH"], "HOME": str(home), "TMPDIR": str(scratch), "WATCH_LOG": str(folder / "audit.log"),
        "PYTHONPATH": f"{site}{os.pathsep}{source}", "PYTHONDONTWRITEBYTECODE": "1", "ORT_DISABLE_TELEMETRY": "0",
    }  # fmt: skip
    program = [sys.executable, str(folder / "commands.py"), str(work)]
    strace = _strace(folder / "strace.log")
    done = subprocess.run([*strace, *program], env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-3000:]
    codes = json.loads((work / "results/codes.json").read_text())
    assert set(codes.values()) <= {0, 130}, (codes, done.stderr[-3000:])  # the review ends by Ctrl-C
    trace = (folder / "strace.log").read_text(errors="replace") if strace else ""
    return folder, (folder / "audit.log").read_text().splitlines(), trace


def _write_labels(folder: Path) -> None:
    """Write labels of two people a metre apart, and the prediction that finds them there."""
    labels = folder / "labels"
    labels.mkdir()
    (labels / "body_pixel_locations.csv").write_text("P1,Torso,100,100,a.jpg,640,480\nP2,Torso,300,100,a.jpg,640,480\n")
    (labels / "ground_truth_locations.csv").write_text("0,P1,0,0,0\n0,P2,1000,0,0\n0,C1,0,0,3000\n")
    (labels / "camera_locations_photoshoot_identifiers.csv").write_text("0,C1,a.jpg\n")
    people = [{"position_mm": [x, 0, 3000], "points": {"Torso": [u, 100]}} for x, u in ((0, 100), (1000, 300))]
    image = {"filename": "a.jpg", "width": 640, "height": 480, "people": people}
    (folder / "predictions.json").write_text(json.dumps({"images": [image]}))


def _strace(log: Path) -> list[str]:
    """Return the beginning of a command line that traces sockets and files, nothing where that is not allowed."""
    if shutil.which("strace") is None or subprocess.run(["strace", "-f", "true"], capture_output=True).returncode:
        return []
    return ["strace", "-f", "-qq", "-s", "300", "-o", str(log), "-e", "trace=connect,sendto,sendmsg,openat,stat,access"]


def test_no_command_talks_to_another_machine(watched: tuple[Path, list[str], str]) -> None:
    _, audited, trace = watched
    addresses = [line.removeprefix("network ") for line in audited if line.startswith("network ")]
    assert addresses, "the review page was not asked"
    outside = [a for a in addresses if "127.0.0.1" not in a and "localhost" not in a and not a.startswith(("'/", "b'"))]
    assert not outside
    far = re.findall(r"(?:connect|sendto|sendmsg)\(.*sa_family=AF_INET6?.*", trace)
    assert not [line for line in far if 'inet_addr("127.' not in line and '"::1"' not in line]


def test_nothing_is_written_but_results_and_named_caches(watched: tuple[Path, list[str], str]) -> None:
    folder, audited, trace = watched
    written = {line.removeprefix("file ") for line in audited if line.startswith("file ")}
    for path, flags in re.findall(r'openat\([^,]+, "([^"]+)", ([A-Z_|]+)[^)]*\) = \d', trace):
        if {"O_WRONLY", "O_RDWR", "O_CREAT"} & set(flags.split("|")):
            written.add(os.path.normpath(folder / "work" / path))
    allowed = [f"{folder}/{name}" for name in ("work/results", "work/again", "work/annotated", "tmp/", "audit.log")]
    allowed += [f"{folder}/home/{name}" for name in NAMED_CACHES]
    assert any("results" in path for path in written)
    assert not [path for path in written if not path.startswith((*allowed, *_SYSTEM))]
    assert list((folder / "tmp").iterdir()) == []
    left = {str(p.relative_to(folder / "home")) for p in (folder / "home").rglob("*") if p.is_file()}
    assert not [path for path in left if not path.startswith(NAMED_CACHES)]


def test_reporting_is_off_whatever_the_environment_says() -> None:
    program = "import os, proxemetry; print([os.environ[name] for name in ('ORT_DISABLE_TELEMETRY', 'DO_NOT_TRACK')])"
    environment = {**os.environ, "ORT_DISABLE_TELEMETRY": "0", "PYTHONPATH": str(Path(telemetry.__file__).parents[1])}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "['1', '1']"


def test_every_dependency_was_looked_at() -> None:
    root = Path(__file__).parents[1]
    page = (root / "docs/privacy.md").read_text().lower()
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    listed = [*project["dependencies"], *(p for extra in project["optional-dependencies"].values() for p in extra)]
    names = {re.split(r"[<>=\[ ]", line)[0].lower() for line in listed} - {"proxemetry"}
    assert not [name for name in names if f"`{name}`" not in page]
