"""The tables of docs/benchmark.md: every method on the annotated points of KORTE, and on synthetic scenes.

    python -m benchmarks.accuracy.korte_tables ../shared/data/korte --write docs/benchmark.md

replaces the text between the markers `<!-- tables -->` and `<!-- end of tables -->`.
"""

from __future__ import annotations

import argparse
import csv
import io
import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

from benchmarks.accuracy.compare_methods import score_methods
from proxemetry.benchmark import PROTOCOLS, Predictions, Score, read_labels, score
from proxemetry.benchmark.predictions import by_stated_distances
from proxemetry.benchmark.tables import make_table
from proxemetry.evaluate import predict_labels
from proxemetry.locate import METHODS, LocateSettings
from proxemetry.people.skeleton import BODY_25
from proxemetry.settings import Settings
from synthetic.scenes import KINDS, Recipe, layouts_from_labels, scenes

START, END = "<!-- tables -->", "<!-- end of tables -->"


def score_annotated(folder: str, protocol: str, methods: Iterable[str] = tuple(METHODS)) -> dict[str, Score]:
    """Score methods on the annotated points under a protocol."""
    labels = read_labels(folder, errata=PROTOCOLS[protocol].errata)
    settings = {m: Settings(method=m, locate=LocateSettings(body_size="adults")) for m in methods}
    answers = {m: Predictions(predict_labels(labels, s), m) for m, s in settings.items()}
    if protocol == "seker2021":
        answers = by_stated_distances(answers)
    return {m: score(labels, given, protocol) for m, given in answers.items()}


def markdown(rows: list[list[str]]) -> str:
    """Return rows as a Markdown table, the first as its head, numbers to the right."""
    head, *body = rows
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def number(value: float, digits: int = 1) -> str:
    """Return a number, or a dash for NaN."""
    return f"{value:.{digits}f}" if math.isfinite(value) else "–"


def summary(scores: dict[str, Score], all_photos: bool) -> str:
    """Return one line a method; with `all_photos` the published averaging beside the mean over photos with pairs."""
    head = ["method", "pairs scored", "photos unscored", "error %, mean over photos with pairs"]
    head += ["error %, published averaging"] if all_photos else ["95 %"]
    head += ["median over pairs %", "bias %", "pairs found"] + ([] if all_photos else ["coverage of 90 %", "width m"])
    rows = [head]
    for name, result in scores.items():
        o = result.overall
        with_pairs = [image.pair_error_pct for image in result.images if image.n_pairs]
        row = [name, str(o.n_pairs), str(o.n_unscored)]
        row.append(number(sum(with_pairs) / len(with_pairs)) if with_pairs else "–")
        if all_photos:
            # the protocol counts a method without a single pair as one without error
            row.append(number(o.pair_error_pct_mean_over_images) if o.n_pairs else "–")
        else:
            low, high = o.ci95["pair_error_pct_mean_over_images"]
            row.append(f"{low:.1f}–{high:.1f}" if math.isfinite(low) else "–")
        row += [number(o.pair_error_pct_median_over_pairs), number(o.signed_bias_pct), number(o.pair_recall, 2)]
        row += [] if all_photos else [number(o.coverage_90, 2), number(o.interval_width_mm_mean / 1000, 2)]
        rows.append(row)
    base = next(iter(scores.values())).overall
    constant = ["1.70 m for every pair", str(base.n_annotated_pairs), "–"]
    constant += ["–", number(base.baseline_constant_pct)] if all_photos else [number(base.baseline_constant_pct), "–"]
    rows.append(constant + ["–"] * (len(head) - len(constant)))
    return markdown(rows)


def by_distance(result: Score) -> str:
    """Return one method's errors by the true distance: nearest pairs matter most to proxemics."""
    rows = [["true distance, m", "pairs", "mean error %", "median %", "bias %"]]
    for found in result.overall.by_distance:
        low, high = found.low_mm / 1000, found.high_mm / 1000
        name = f"{low:g} to {high:g}" if math.isfinite(high) else f"{low:g} and more"
        figures = (found.error_pct_mean, found.error_pct_median, found.bias_pct)
        rows.append([name, str(found.n_pairs), *(number(value) for value in figures)])
    return markdown(rows)


def paper_table(name: str, scores: dict[str, Score]) -> str:
    """Return one of the paper's tables for the methods that place anyone."""
    placing = {method: result for method, result in scores.items() if result.overall.n_pairs}
    return markdown(list(csv.reader(io.StringIO(make_table(name, placing).to_csv()))))


def synthetic(folder: str, count: int, seed: int) -> str:
    """Return a table of methods by kind of camera and posture."""
    rows = [["camera, people", "method", "error %, mean over photos", "median over pairs %", "bias %", "pairs found",
             "coverage of 90 %", "1.70 m for every pair %"]]  # fmt: skip
    measured = layouts_from_labels(str(Path(folder) / "ground_truth_locations.csv"))
    for kind, layouts in ((KINDS[1], measured), *((kind, ()) for kind in KINDS[:-1])):
        for posture in ("standing", "seated"):
            # The paper's estimators are made for the skeleton of its detector, whose neck refuses turned shoulders.
            recipe = Recipe(kind=kind, posture=posture, layouts=layouts, skeleton=BODY_25)
            if layouts:  # longer lenses would be set up much farther away than KORTE's were
                recipe = replace(recipe, focal_mm=tuple(f for f in recipe.focal_mm if f <= 105))
            photos = list(scenes(count, seed, recipe))
            places = ", KORTE's places, to 105 mm" if layouts else ""
            for name, result in score_methods(photos, ["torso", "combined", "scene"]).items():
                o = result.overall
                rows.append([
                    f"{kind.replace('_', ' ')}, {posture}{places}", name, number(o.pair_error_pct_mean_over_images),
                    number(o.pair_error_pct_median_over_pairs), number(o.signed_bias_pct), number(o.pair_recall, 2),
                    number(o.coverage_90, 2), number(o.baseline_constant_pct),
                ])  # fmt: skip
    return markdown(rows)


def tables(folder: str, count: int, seed: int) -> str:
    """Return all tables with their headings."""
    published, correct = score_annotated(folder, "seker2021"), score_annotated(folder, "v1")
    parts = [
        "### Annotated points, protocol `v1`, labels with errata\n", summary(correct, all_photos=False),
        "### The scene fit by true distance, protocol `v1`\n", by_distance(correct["scene"]),
        "### Annotated points, protocol `seker2021`, original labels\n", summary(published, all_photos=True),
    ]  # fmt: skip
    for name in ("all", "outdoor", "indoor", "elevated", "f1"):
        parts += [f"### Annotated points, protocol `seker2021`: {name}\n", paper_table(name, published)]
    parts += [f"### Synthetic scenes, protocol `v1`, {count} photos a row\n", synthetic(folder, count, seed)]
    return "\n".join(parts)


def main() -> None:
    """Print the tables, or write them into a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("labels")
    parser.add_argument("--write", metavar="PAGE")
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    text = tables(args.labels, args.count, args.seed)
    if not args.write:
        print(text)
        return
    page = Path(args.write)
    before, _, rest = page.read_text(encoding="utf-8").partition(START)
    _, _, after = rest.partition(END)
    page.write_text(f"{before}{START}\n{text}{END}{after}", encoding="utf-8")


if __name__ == "__main__":
    main()
