"""The words that every report has in common, and its looks on a screen and on paper."""

from __future__ import annotations

#: Method -> what it does, in a paragraph that may be quoted.
METHODS = {
    "scene": (
        "People are found as body keypoints. One joint fit for the photo then places all people: bodies of plausible "
        "proportions (ANSUR II and CDC body measurements) stand on a shared floor under one camera height and tilt, "
        "and the fit weighs every keypoint by its own uncertainty. The curvature of the fit gives the intervals."
    ),
    "combined": (
        "People are found as body keypoints. Each is placed by the pinhole camera from a body length taken as parallel "
        "to the sensor: pupils, shoulders or torso, whichever puts the person nearest (Seker et al. 2021, combined)."
    ),
    "": (
        "People are found as body keypoints. Each is placed by the pinhole camera from one body length taken as "
        "parallel to the sensor (Seker et al. 2021)."
    ),
}

LIMITS = (
    "Distances are between body centres as seen in one photo; a single image cannot show what it hides.",
    "People who were not found are not counted. Small, hidden and cropped people are missed more often, so counts are "
    "low.",
    "A focal length that is 10 % too long stretches depth by 10 %; people side by side stay as far apart. A cropped "
    "photo no longer shows what its recorded focal length implies.",
    "Bodies differ: a child taken for an adult is placed about a quarter too far away, an adult taken for a child too "
    "near.",
    "Long lenses compress depth: for two people one behind the other, quote the interval rather than the number.",
    "Zones are Hall's (1966) limits applied to distances. They do not show what standing there means to the people.",
    "Intervals hold 90 % only as far as the settings hold: they do not cover an unnoticed crop or a second floor.",
)

CITE = (
    "Cite the software with its version as in CITATION.cff, and the method's origin: Seker, Männistö, Iosifidis "
    "and Raitoharju, Automatic social distance estimation for photographic studies: Performance evaluation, test "
    "benchmark, and algorithm, Machine Learning with Applications 10, 2022, doi 10.1016/j.mlwa.2022.100427. State "
    "the method, the pose back end, where focal lengths came from, and how many photos were corrected or refused."
)

STYLE = """
:root{font:15px/1.5 system-ui,"Segoe UI","Liberation Sans","DejaVu Sans",sans-serif;color:#1c2126;background:#f3f5f6}
body{margin:0}main{max-width:62rem;margin:0 auto;padding:2rem 2.4rem;background:#fff}
h1{font-size:1.9rem;margin:.1rem 0 .4rem;line-height:1.2;overflow-wrap:anywhere}
h2{margin:2.2rem 0 .5rem;font-size:1.3rem;border-bottom:2px solid #14324a;padding-bottom:.2rem}
h3{margin:1.3rem 0 .3rem;font-size:1.02rem}p{margin:.3rem 0 .7rem;max-width:48rem}
.brand{color:#0b5cad;font-weight:700;letter-spacing:.03em;margin:0}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(11rem,1fr));gap:.8rem;margin:1.2rem 0}
.tiles div{background:#eef3f7;border-radius:10px;padding:.8rem 1rem}
.tiles strong{display:block;font-size:1.35rem;font-variant-numeric:tabular-nums}.tiles span{color:#4f5860}
table{border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums;margin:.4rem 0 1rem}
th,td{text-align:left;padding:.25rem .6rem .25rem 0;border-bottom:1px solid #e2e6e9;vertical-align:top}
thead th{color:#4f5860;font-size:.85rem}tbody th{font-weight:500;overflow-wrap:anywhere}
.counts{width:auto;min-width:55%}.counts td{text-align:right;padding-left:2rem}
.chart{width:100%;height:auto}.chart text,.zones text{font-size:11px}.chart text{fill:#1c2126}
.chart .tick,.chart .zone,.zones .part{text-anchor:middle}.chart .count{text-anchor:end}
.chart .rule{stroke:#e3e6e9}.chart .limit{stroke:#59636b;stroke-dasharray:3 3}
.chart .median{stroke:#1c2126;stroke-width:2.4}.chart .band{fill:#1c2126;fill-opacity:.16}
.zones{width:100%;min-width:12rem;height:1.25rem}
.legend{display:flex;flex-wrap:wrap;gap:.3rem 1.2rem;max-width:none}.legend svg{width:.8em;height:.8em}
.links{font-size:.82rem;font-weight:400;white-space:nowrap;margin-left:.4rem}
figure{margin:0 0 1.4rem}figure img{width:100%;border:1px solid #d9dde1;border-radius:8px}
dl{display:grid;grid-template-columns:auto 1fr;gap:.15rem 1rem}dt{font-weight:600}dd{margin:0;overflow-wrap:anywhere}
pre{background:#f3f5f6;padding:.8rem;border-radius:8px;white-space:pre-wrap;overflow-wrap:anywhere;font-size:.82rem}
@page{margin:16mm 14mm}
@media print{.links{display:none}:root{background:#fff;font-size:10.5pt}main{max-width:none;padding:0}
figure,.block,tr,.tiles,li{break-inside:avoid}h2,h3{break-after:avoid}*{print-color-adjust:exact}}
"""
