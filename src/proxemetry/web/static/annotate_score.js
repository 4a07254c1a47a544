// What is missing in the label files, and how well the tool's own run does on them, under both protocols.

import * as api from "./annotate_api.js";
import { Problem } from "./api.js";
import { html, plural } from "./elements.js";

const ASK_EVERY_MS = 600;
const percent = (value) => (value === null ? "–" : value.toFixed(1));
const whole = (value) => (value === null ? "–" : value.toFixed(0));

const COLUMNS = [
  ["Method", "", (r) => r.method], ["Pairs", "num", (r) => `${r.pairs} of ${r.annotated_pairs}`],
  ["Error %", "num", (r) => percent(r.error)], ["95 %", "num", (r) => (r.ci ? `${percent(r.ci[0])}–${percent(r.ci[1])}` : "–")],
  ["Median %", "num", (r) => percent(r.median)], ["Bias %", "num", (r) => percent(r.bias)], ["Found %", "num", (r) => whole(r.found)],
  ["False %", "num", (r) => whole(r.false)], ["In interval %", "num", (r) => (r.intervals ? whole(r.coverage) : "–")],
];

function faultList({ faults, doubts, files }, out) {
  const real = faults.filter((f) => !f.harmless);
  const list = (items) => html("ul", { class: "faults" }, items.map((f) => html("li", {}, html("code", { text: f.line ? `${f.file}:${f.line}` : f.file }), ` ${f.text}`)));
  return html("section", { class: "card-like" },
    html("h2", { text: "Label files" }),
    html("p", { role: "status", class: real.length ? "verdict problem" : "verdict good", text: real.length ? plural(real.length, "fault", "faults") : "No faults: the files are complete and fit together." }),
    real.length ? list(real) : "",
    doubts.length ? html("div", {}, html("p", {}, html("a", { href: "#/places", text: "Places" }), " to look at:"), html("ul", { class: "remarks" }, doubts.map((text) => html("li", { class: "problem", text })))) : "",
    html("p", { class: "hint" }, `Written to ${out}: ${files.join(", ")}. The same check: `, html("code", { text: `proxemetry score --check ${out}` })));
}

function protocolTable(p) {
  const cells = (row) => COLUMNS.map(([, kind, value]) => html("td", { class: kind, text: value(row) }));
  return html("div", { class: "scroll" }, html("table", { class: "scores", "data-protocol": p.name },
    html("caption", {}, html("b", { text: p.name }), ` ${p.about}`),
    html("thead", {}, html("tr", {}, COLUMNS.map(([title, kind]) => html("th", { scope: "col", class: kind, text: title })))),
    html("tbody", {}, p.rows.map((row) => html("tr", {}, cells(row))),
      html("tr", { class: "baseline" }, html("td", { text: "1.70 m for every pair" }), html("td", {}), html("td", { class: "num", text: percent(p.baseline) }), COLUMNS.slice(3).map(() => html("td", {})))) ));
}

function photoTable(p) {
  return html("details", {}, html("summary", { text: `Photo by photo (${p.name}, ${p.rows[0].method})` }), html("div", { class: "scroll" }, html("table", {},
    html("thead", {}, html("tr", {}, ["Photo", "Annotated", "Found", "Matched", "Pairs", "Error %"].map((text, k) => html("th", { scope: "col", class: k ? "num" : "", text })))),
    html("tbody", {}, p.photos.map((r) => html("tr", {}, html("td", {}, r.id === null ? r.filename : html("a", { href: `#/photo/${r.id}`, text: r.filename })),
      [r.n_annotated, r.n_detected, r.n_matched, r.n_pairs].map((v) => html("td", { class: "num", text: v })), html("td", { class: "num", text: percent(r.pair_error_pct) })))))));
}

function results({ protocols }) {
  return [...protocols.map(protocolTable),
    html("p", { class: "hint", text: "Error: mean over photos of |measured − taped| / taped. Found: people of those annotated; false: found, but not annotated. In interval: taped distances inside the stated 90 % intervals. A method near the last line has learned nothing from the photo." }),
    html("p", { class: "hint", text: "Points that a back end proposed only tell who is who. Distances are judged by your places alone." }),
    ...protocols.slice(0, 1).map(photoTable),
    html("details", {}, html("summary", { text: "Everything, as text" }), html("pre", { tabindex: 0, text: protocols.map((p) => p.text).join("\n") }))];
}

export async function showScore(main, about) {
  const found = await api.check();
  const bar = html("progress", { max: 1, value: 0, hidden: true, "aria-label": "Photos measured" });
  const told = html("p", { class: "hint", role: "status" });
  const start = html("button", { type: "button", id: "run", class: "first", onclick: () => begin(), text: "Measure and score" });
  const stop = html("button", { type: "button", hidden: true, onclick: () => api.stopScoring(), text: "Stop" });
  const table = html("div", { id: "scores" });
  const area = html("section", { class: "card-like" }, html("h2", { text: "How well does the tool do on these photos?" }),
    html("p", { text: "Your annotated photos are measured as by “proxemetry measure”, and the answers are scored against your places." }),
    told, bar, html("div", { class: "row" }, stop, start), table);
  main.replaceChildren(html("div", { class: "sheet-like" }, faultList(found, about.out), area));
  let closed = false;

  async function begin() {
    try {
      await api.startScoring();
      await follow();
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      told.textContent = error.message;
    }
  }

  async function follow() {
    start.disabled = true;
    stop.hidden = bar.hidden = false;
    let state = await api.scoring();
    while (state.status === "running" && !closed) {
      if (state.total) bar.value = state.done / state.total;
      told.textContent = state.total ? `${state.done} of ${plural(state.total, "photo", "photos")} measured` : state.note ?? "starting ...";
      await new Promise((done) => setTimeout(done, ASK_EVERY_MS));
      state = await api.scoring();
    }
    if (closed) return;
    start.disabled = false;
    stop.hidden = bar.hidden = true;
    told.textContent = state.status === "failed" ? state.error : state.status === "stopped" ? "Stopped. What was measured stays; start again to continue." : "";
    told.classList.toggle("problem", state.status === "failed");
    if (state.status === "done") table.replaceChildren(...results(state.result));
  }

  const state = await api.scoring();
  if (state.status === "running") follow();
  else if (state.status === "done") table.replaceChildren(html("p", { class: "hint", text: "From the last run; measure again after changes." }), ...results(state.result));
  return { close: () => { closed = true; }, key: (event) => event.key.toLowerCase() === "g" && Boolean((location.hash = "#/")) };
}
