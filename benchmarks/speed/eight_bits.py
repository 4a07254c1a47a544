"""Time saved by convolutions in 8 bits: processor time a run by the least number of weights, in interleaved runs.

    python -m benchmarks.speed.eight_bits [--networks A.tflite,B.tflite] [--models DIR] [--least 1,32,64] [--runs N]

A column for the network as it is, and one for each least number of weights in an output channel from which on a
convolution computes in 8 bits (`LEAST_WEIGHTS`), with its share of the time as it is. How much is saved depends
on the processor: those with instructions for integer products (VNNI on x86, dot products on Arm) save most.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import numpy as np

from benchmarks.networks.networks_at_hand import add_models_option
from proxemetry import weights
from proxemetry.pose.litert import interpreter
from proxemetry.weights.conversion.eight_bits import LEAST_WEIGHTS, in_eight_bits

_NETWORKS = "nanodet_g.tflite,movenet_thunder.tflite,yolox_nano.tflite,tinypose_256x192.tflite"
_AT_ONCE = 4


def loaded(content: bytes, name: str) -> Any:
    """Return an interpreter with a picture of noise in it, which every form of a network gets."""
    network = interpreter(content, 1, name)
    given = network.get_input_details()[0]
    noise = np.random.default_rng(0).uniform(0, 255, given["shape"])
    network.set_tensor(given["index"], noise.astype(given["dtype"]))
    network.invoke()
    return network


def milliseconds(forms: list[Any], runs: int) -> list[float]:
    """Return each form's processor time a run, the median of runs that take turns."""
    times: list[list[float]] = [[] for _ in forms]
    for _ in range(max(1, runs // _AT_ONCE)):
        for form, taken in zip(forms, times, strict=True):
            form.invoke()  # back into the processor's cache
            for _ in range(_AT_ONCE):
                started = time.process_time()
                form.invoke()
                taken.append(1000 * (time.process_time() - started))
    return [float(np.median(taken)) for taken in times]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--networks", default=_NETWORKS)
    add_models_option(parser)
    parser.add_argument("--least", default=f"1,32,{LEAST_WEIGHTS},128")
    parser.add_argument("--runs", type=int, default=24)
    args = parser.parse_args()
    leasts = [int(number) for number in args.least.split(",")]
    cells = ["network", "ms as it is", *(f"from {least} on" for least in leasts)]
    print("| " + " | ".join(cells) + " |\n|" + " --- |" * len(cells))
    for name in args.networks.split(","):
        content = weights.verify(name).path.read_bytes()
        forms = [content, *(in_eight_bits(content, least) for least in leasts)]
        running = [loaded(form, name) for form in forms]
        own, *others = milliseconds(running, args.runs)
        shares = [f"{ms:.1f} ({ms / own:.2f})" for ms in others]
        print("| " + " | ".join([f"`{name}`", f"{own:.1f}", *shares]) + " |", flush=True)


if __name__ == "__main__":
    main()
