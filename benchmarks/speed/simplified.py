"""Time saved by fewer layers: a network as stored and as simplified, processor time a run, in interleaved runs.

    python -m benchmarks.speed.simplified [--networks A.tflite,B.tflite] [--models DIR] [--runs N]

For each network its layers as the file has them and as they run (`proxemetry.weights.conversion.simplified`), the
milliseconds of both, their ratio, and how much the outputs for a picture of noise differ, as a share of the largest.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from benchmarks.networks.networks_at_hand import add_models_option
from benchmarks.speed.eight_bits import loaded, milliseconds
from proxemetry import weights
from proxemetry.weights.conversion.graph import read_graph
from proxemetry.weights.conversion.simplified import simplified

_NETWORKS = "tinypose_256x192.tflite,yolox_nano.tflite,nanodet_g.tflite"


def layers(content: bytes) -> int:
    """Return how many layers a network has, of those that the rewriting knows."""
    graph = read_graph(content)
    return 0 if graph is None else len(graph.operators)


def apart(one: Any, other: Any) -> float:
    """Return the largest difference between two interpreters' answers, as a share of the largest answer."""
    shares: list[float] = []
    for a, b in zip(one.get_output_details(), other.get_output_details(), strict=True):
        answer = one.get_tensor(a["index"])
        shares.append(float(np.abs(answer - other.get_tensor(b["index"])).max() / np.abs(answer).max()))
    return max(shares)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--networks", default=_NETWORKS)
    add_models_option(parser)
    parser.add_argument("--runs", type=int, default=80)
    args = parser.parse_args()
    print("| network | layers | as it runs | ms | as it runs | ratio | apart |\n|" + " --- |" * 7)
    for name in args.networks.split(","):
        content = weights.verify(name).path.read_bytes()
        simpler = simplified(content)
        if simpler is content:
            print(f"| `{name}` | {layers(content)} | the file's | | | | |")
            continue
        running = [loaded(form, name) for form in (content, simpler)]
        own, less = milliseconds(running, args.runs)
        cells = [layers(content), layers(simpler), f"{own:.1f}", f"{less:.1f}", f"{less / own:.2f}"]
        print(f"| `{name}` | " + " | ".join(map(str, cells)) + f" | {apart(*running):.0e} |", flush=True)


if __name__ == "__main__":
    main()
