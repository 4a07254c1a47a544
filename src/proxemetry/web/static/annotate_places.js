// Where people and cameras were: coordinates and tapes of a shoot, what follows from them, and what cannot be determined.

import * as api from "./annotate_api.js";
import { called, colourOf, numberOf, shootName } from "./annotate_names.js";
import { FloorPlan } from "./annotate_plan.js";
import { Problem } from "./api.js";
import { html, plural, tell } from "./elements.js";
import { NotANumber, typedMetres } from "./numbers.js";

const centimetres = (metres) => `${metres > 0 ? "+" : metres < 0 ? "−" : ""}${(Math.abs(metres) * 100).toFixed(1)} cm`;

class PlacesView {
  constructor(main, about, changed) {
    Object.assign(this, { main, about, changed });
    this.planHost = html("div", { class: "floor" });
    this.plan = new FloorPlan(this.planHost);
    this.remarks = html("ul", { class: "remarks", "aria-live": "polite" });
    this.tapes = html("section", { class: "card-like" });
    this.marks = html("section", { class: "card-like" });
    this.results = html("section", { class: "card-like" });
  }

  close() {
    this.plan.close();
  }

  async open(shoot) {
    this.fields = await api.places(shoot);
    const { about, fields } = this;
    const choice = html("select", { id: "shoot", onchange: (e) => (location.hash = `#/places/${e.target.value}`) },
      about.shoots.map((s) => html("option", { value: s.number, selected: s.number === fields.shoot, text: `${shootName(s, s.number)} (${plural(s.photos, "photo", "photos")})` })));
    const name = html("input", { type: "text", id: "shoot-name", maxlength: 100, value: fields.name, placeholder: "such as terrace, standing", onchange: (e) => this.act("name_shoot", { name: e.target.value }) });
    this.main.replaceChildren(html("div", { class: "places" },
      html("div", { class: "tools" }, html("label", {}, "Shoot", choice), html("label", {}, "Its name", name),
        html("details", {}, html("summary", { text: "The benchmark's rules for places" }), html("ul", {}, about.rules.places.map((text) => html("li", { text }))))),
      html("div", { class: "columns" },
        html("div", {}, this.marks, this.tapes),
        html("div", {}, html("section", { class: "card-like" }, html("h2", { text: "From above" }), this.planHost, this.remarks), this.results))));
    this.draw();
  }

  draw() {
    const focused = document.activeElement?.dataset?.control;
    this.drawMarks();
    this.drawTapes();
    this.drawResults();
    this.plan.show(this.fields, this.about);
    if (focused) {
      const field = this.main.querySelector(`[data-control="${focused}"]`);
      field?.focus();
      field?.select?.();
    }
  }

  text(tag) {
    return called(tag, tag.startsWith("C") ? Object.fromEntries(this.fields.tags.map((t) => [t.tag, t.name])) : this.about.names);
  }

  drawMarks() {
    const rows = this.fields.tags.map((t) => {
      const swatch = html("span", { class: t.tag.startsWith("C") ? "swatch camera" : "swatch" });
      if (!t.tag.startsWith("C")) swatch.style.background = colourOf(t.tag, this.about.colours).fill;
      const cell = (axis, k) => html("td", {}, html("input", { type: "text", inputmode: "decimal", class: "metres", autocomplete: "off", "data-control": `${t.tag}${axis}`, "aria-label": `${axis} of ${t.tag}, metres`,
        value: t.spot ? String(t.spot[k]) : "", placeholder: t.place ? t.place[k].toFixed(2) : "", onchange: () => this.spot(t) }));
      return html("tr", { class: t.suspect ? "suspect" : "", "data-tag": t.tag },
        html("th", { scope: "row" }, swatch, t.tag),
        html("td", {}, html("input", { type: "text", class: "label", maxlength: 100, autocomplete: "off", "data-control": `${t.tag}name`, "aria-label": `Name of ${t.tag}`, value: t.name, onchange: (e) => this.label(t.tag, e.target.value) })),
        cell("x", 0), cell("y", 1),
        html("td", { class: "status" }, t.suspect ? "contradicts" : t.spot ? "typed" : t.place ? "from tapes" : "no place yet"));
    });
    this.marks.replaceChildren(html("h2", { text: "People and cameras" }),
      rows.length ? html("table", { class: "marks" }, html("thead", {}, html("tr", {}, ["Mark", "Name", "x, m", "y, m", ""].map((text) => html("th", { scope: "col", text })))), html("tbody", {}, rows))
        : html("p", { class: "hint", text: "Nobody is named on this shoot's photos yet. Marks that you measure below appear here too." }),
      html("p", { class: "hint", text: "Type both coordinates where you know them, in metres on the floor; grey ones come from the tapes. Names are for you alone." }));
  }

  drawTapes() {
    const { tapes, tags } = this.fields;
    const contradictory = this.fields.tags.some((t) => t.suspect) || tapes.some((t) => t.suspect); // one bends all others
    const rows = tapes.map((t) => html("tr", { class: t.suspect ? "suspect" : "", "data-tape": `${t.a}-${t.b}` },
      html("th", { scope: "row", text: `${t.a} – ${t.b}` }),
      html("td", {}, html("input", { type: "text", inputmode: "decimal", class: "metres", autocomplete: "off", "data-control": `${t.a}${t.b}`, "aria-label": `Distance ${t.a} to ${t.b}, metres`, value: String(t.metres), onchange: (e) => this.tape(t.a, t.b, e.target, t) })),
      html("td", { class: t.checked ? "num off-by" : "num", text: t.residual_m === null ? "–" : t.checked ? centimetres(t.residual_m) : "unchecked" }),
      html("td", { class: "status", text: t.suspect ? `others say ${t.expected_m.toFixed(2)} m ± ${(t.expected_sd_m * 164.5).toFixed(1)} cm` : !contradictory && t.checked && t.z !== null && Math.abs(t.z) > 2 ? "a little off" : "" }),
      html("td", {}, html("button", { type: "button", "aria-label": `Remove the tape ${t.a} to ${t.b}`, onclick: () => this.act("set_tape", { a: t.a, b: t.b, metres: null }), text: "×" }))));
    const known = html("datalist", { id: "tags" }, tags.map((t) => html("option", { value: t.tag, label: t.name })));
    const end = (id, label) => html("input", { type: "text", id, class: "end", list: "tags", autocomplete: "off", maxlength: 4, "data-control": id, "aria-label": label, placeholder: id === "from" ? "P0" : "P1" });
    const length = html("input", { type: "text", id: "length", inputmode: "decimal", class: "metres", autocomplete: "off", "data-control": "length", "aria-label": "Taped distance, metres", placeholder: "2,40" });
    const sd = html("input", { type: "text", id: "sd", inputmode: "decimal", class: "metres", autocomplete: "off", "data-control": "sd", "aria-label": "Uncertainty of the tape, centimetres", placeholder: "1" });
    const form = html("form", { class: "row entry", onsubmit: (event) => { event.preventDefault(); this.added(form); } },
      end("from", "Taped from"), html("span", { text: "–" }), end("to", "Taped to"), length, html("span", { text: "m ±" }), sd, html("span", { text: "cm" }),
      html("button", { type: "submit", class: "first", text: "Add tape" }), known);
    const missing = this.missing();
    this.tapes.replaceChildren(html("h2", { text: "Taped distances" }),
      rows.length ? html("table", { class: "tapes" }, html("thead", {}, html("tr", {}, ["Between", "Metres", "Off by", "", ""].map((text) => html("th", { scope: "col", text })))), html("tbody", {}, rows)) : "",
      form, html("p", { class: "hint", text: "From mark to mark along the floor. Off by: taped less what all measurements together say. ± is one standard deviation, 1 cm unless you know better." }),
      missing ? html("p", {}, "Next: ", html("button", { type: "button", onclick: () => this.prepare(missing), text: `${missing[0]} – ${missing[1]}` })) : "");
  }

  // The most informative pair: a mark without a place to one that has one and is not taped to it.
  missing() {
    const { tags, tapes } = this.fields;
    const has = (a, b) => tapes.some((t) => (t.a === a && t.b === b) || (t.a === b && t.b === a));
    for (const open of tags.filter((t) => !t.place)) {
      const other = [...tags.filter((t) => t.place), ...tags].find((t) => t.tag !== open.tag && !has(open.tag, t.tag));
      if (other) return [other.tag, open.tag];
    }
    return null;
  }

  prepare([a, b]) {
    this.main.querySelector("#from").value = a;
    this.main.querySelector("#to").value = b;
    this.main.querySelector("#length").focus();
  }

  drawResults() {
    const { distances, remarks } = this.fields;
    this.remarks.replaceChildren(...remarks.map((r) => html("li", { class: r.problem ? "problem" : "", text: r.text })));
    this.results.replaceChildren(html("h2", { text: "Distances between people" }),
      distances.length ? html("table", { class: "distances" }, html("thead", {}, html("tr", {}, html("th", { scope: "col", text: "Pair" }), html("th", { scope: "col", class: "num", text: "Metres" }), html("th", { scope: "col", class: "num", text: "90 % within" }))),
        html("tbody", {}, distances.map((d) => html("tr", {}, html("td", { text: `${this.text(d.a)} – ${this.text(d.b)}` }), html("td", { class: "num", text: d.metres.toFixed(2) }), html("td", { class: "num", text: `± ${(d.sd_m * 164.5).toFixed(1)} cm` })))))
        : html("p", { class: "hint", text: "Distances appear as soon as two people have a place." }));
  }

  label(tag, name) {
    return tag.startsWith("C") ? this.act("name_camera", { tag, name }) : this.act("name_tag", { tag, name });
  }

  // Both coordinates, or neither: one alone is no place.
  spot(t) {
    const values = ["x", "y"].map((axis) => this.main.querySelector(`[data-control="${t.tag}${axis}"]`).value);
    const empty = values.filter((text) => text.trim() === "").length;
    if (empty === 1) return null;
    return this.typed(() => (empty === 2 ? null : values.map((text) => typedMetres(text, true))), (at) => {
      if (at !== null || t.spot) this.act("set_spot", { tag: t.tag, at });
    });
  }

  tape(a, b, input, before) {
    return this.typed(() => typedMetres(input.value), (metres) => this.act("set_tape", { a, b, metres, sd_m: before.sd_m }));
  }

  added(form) {
    const tagOf = (id) => {
      const text = form.querySelector(`#${id}`).value.trim().toUpperCase();
      if (!/^[PC]\d{1,3}$/.test(text)) throw new NotANumber("A mark is P or C and a number, as P2 or C0");
      return `${text[0]}${numberOf(text)}`;
    };
    return this.typed(() => ({ a: tagOf("from"), b: tagOf("to"), metres: typedMetres(form.querySelector("#length").value), sd_m: form.querySelector("#sd").value.trim() === "" ? null : typedMetres(form.querySelector("#sd").value) / 100 }), async (value) => {
      const { a, b } = value;
      if (await this.act("set_tape", value)) {
        this.main.querySelector("#from").value = a; // the next tape begins at the same mark more often than not
        this.main.querySelector("#to").focus();
        tell(`${a} – ${b} kept`);
      }
    });
  }

  typed(read, then) {
    try {
      return then(read());
    } catch (error) {
      if (!(error instanceof NotANumber)) throw error;
      tell(error.message, true);
      return null;
    }
  }

  async act(action, value) {
    const { shoot } = this.fields;
    try {
      await api.act(null, action, action === "name_tag" ? value : { shoot, ...value });
      [this.fields, this.about] = await Promise.all([api.places(shoot), api.about()]);
      this.draw();
      await this.changed(this.about);
      return true;
    } catch (error) {
      if (!(error instanceof Problem)) throw error;
      tell(error.message, true);
      this.draw();
      return false;
    }
  }

  key(event) {
    const keys = { g: () => (location.hash = "#/"), t: () => this.main.querySelector("#from").focus() };
    const run = keys[event.key.toLowerCase()];
    return Boolean(run) && (run(), true);
  }
}

export async function showPlaces(main, about, argument, changed) {
  const view = new PlacesView(main, about, changed);
  const shoot = argument === undefined ? about.shoots[0]?.number ?? 0 : Number(argument);
  await view.open(Number.isInteger(shoot) ? shoot : 0);
  return view;
}
