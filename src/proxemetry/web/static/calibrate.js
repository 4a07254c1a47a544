// Where a fixed camera is: points of the floor and taped lines clicked on a picture, their metres typed beside it; the
// metre grid and the horizon lie on the picture as soon as there is enough.

import * as api from "./api.js";
import { CalibrateCanvas } from "./calibrate_canvas.js";
import { askFocal } from "./dialogs.js";
import { html, tell } from "./elements.js";
import { NotANumber, typedMetres } from "./numbers.js";

const WAIT_MS = 250;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const NAME = /^[A-Za-z0-9][\w.-]{0,59}$/;

export class CalibrateView {
  constructor(main, fields, query) {
    Object.assign(this, { fields, query });
    this.place = `calibrate ${fields.photo}`;
    this.marks = { points: [], lengths: [], lens: null };
    this.before = [];
    this.state = { mode: "point", chosen: null, cursor: null, begun: null, hidden: false, found: null };
    this.recall();
    const on = {
      clicked: (at) => this.clicked(at),
      choose: (what) => this.choose(what),
      moved: (what, to) => this.change(() => this.setPixel(what, to)),
      failed: () => this.say("The photo file is missing: points cannot be clicked without it."),
    };
    this.notice = html("div", { class: "notice" });
    this.canvas = html("div", { class: "canvas" });
    this.actions = html("div", { class: "actions", role: "toolbar", "aria-label": "Calibration" });
    this.panel = html("div", { class: "panel calibration" });
    this.root = html("div", { class: "photo calibrating" },
      html("section", { class: "stage", "aria-label": "Picture" },
        html("div", { class: "head" }, html("a", { class: "button", href: this.photoAddress, text: "Photo" }), html("h1", { text: `Calibrate: ${fields.photo}` })),
        this.notice, this.canvas, this.actions),
      html("aside", { class: "side", "aria-label": "Points, lengths and what they show" }, this.panel));
    main.replaceChildren(this.root);
    this.overlay = new CalibrateCanvas(this.canvas, on);
    this.overlay.show(fields, this.marks, this.state);
    this.draw();
    this.ask();
  }

  get photoAddress() {
    return `#/photo/${this.fields.id}?${api.searchOf(this.query)}`;
  }

  close() {
    clearTimeout(this.timer);
    this.overlay.close();
  }

  // What was clicked survives a reload of the page, and a visit to a photo's page.
  recall() {
    try {
      const kept = JSON.parse(sessionStorage.getItem(this.place));
      if (kept) this.marks = kept;
    } catch { /* what another version stored is not needed */ }
  }

  // `again`: the same mark moved on by the arrow keys, which is one change to undo. `anew`: whether rows came or went; where
  // only metres were typed the fields stay, and so does the place in them.
  change(run, { again = false, anew = true } = {}) {
    const copy = structuredClone(this.marks);
    run();
    if (!(again && this.nudged)) this.before.push(copy);
    this.nudged = again;
    this.changed(anew);
  }

  changed(anew = true) {
    sessionStorage.setItem(this.place, JSON.stringify(this.marks));
    this.overlay.show(this.fields, this.marks, this.state);
    if (anew) this.draw();
    else this.buttons();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), WAIT_MS);
  }

  undo() {
    if (!this.before.length) return tell("There is nothing to undo", true);
    this.marks = this.before.pop();
    this.nudged = false;
    Object.assign(this.state, { chosen: null, begun: null });
    this.changed();
  }

  // Only what is whole is sent: points with both metres, lines with a length.
  get request() {
    const whole = this.marks.points.filter((p) => p.x !== null && p.y !== null);
    const taped = this.marks.lengths.filter((l) => l.metres !== null);
    return {
      points: whole.map((p) => [...p.at, p.x, p.y]),
      lengths: taped.map((l) => [...l.from, ...l.to, l.metres]),
      lens: this.marks.lens,
    };
  }

  async ask() {
    const mine = (this.turn = (this.turn ?? 0) + 1);
    const asked = { points: this.marks.points.filter((p) => p.x !== null && p.y !== null), lengths: this.marks.lengths.filter((l) => l.metres !== null) };
    let found;
    try {
      found = await api.calibrate(this.fields.id, this.request);
    } catch (error) {
      if (!(error instanceof api.Problem)) throw error;
      found = { status: "problem", text: error.message };
    }
    if (mine !== this.turn || !this.root.isConnected) return;
    this.state.found = found;
    this.misses = new Map((found.points ?? []).map((p, k) => [asked.points[k], p]));
    this.comesOut = new Map((found.lengths ?? []).map((l, k) => [asked.lengths[k], l]));
    this.overlay.misses = this.misses;
    this.overlay.draw();
    this.tellFound();
    this.showMisses();
  }

  clicked(at) {
    if (this.state.mode === "length") {
      if (!this.state.begun) {
        this.state.begun = at;
        this.overlay.draw();
        return this.banner();
      }
      const from = this.state.begun;
      this.state.begun = null;
      this.change(() => this.marks.lengths.push({ from, to: at, metres: null }));
      this.choose(["length", this.marks.lengths.length - 1]);
    } else {
      this.change(() => this.marks.points.push({ at, x: null, y: null }));
      this.choose(["point", this.marks.points.length - 1]);
    }
    this.field(this.state.chosen)?.focus();
  }

  choose(what) {
    const same = what && this.state.chosen && what.join() === this.state.chosen.join();
    this.state.chosen = same ? null : what;
    this.overlay.draw();
    this.buttons();
    this.lightRows();
  }

  lightRows() {
    const chosen = this.state.chosen?.slice(0, 2).join("-");
    for (const row of this.panel.querySelectorAll("tr[data-mark]")) row.classList.toggle("chosen", row.dataset.mark === chosen);
  }

  field = (what) => this.panel.querySelector(`tr[data-mark="${what.slice(0, 2).join("-")}"] input`);

  // A mark's pixel: of a line, which end is the third part of `what`.
  pixel([kind, k, end]) {
    return kind === "point" ? this.marks.points[k].at : this.marks.lengths[k][end ?? "from"];
  }

  setPixel([kind, k, end], to) {
    const { width, height } = this.fields;
    const at = [Math.min(Math.max(to[0], 0), width), Math.min(Math.max(to[1], 0), height)].map((v) => Math.round(v * 10) / 10);
    if (kind === "point") this.marks.points[k].at = at;
    else this.marks.lengths[k][end ?? "from"] = at;
  }

  remove(what = this.state.chosen) {
    if (!what) return;
    this.state.chosen = null;
    this.change(() => this.marks[`${what[0]}s`].splice(what[1], 1));
  }

  setMode(mode) {
    Object.assign(this.state, { mode, begun: null });
    this.overlay.draw();
    this.buttons();
    this.banner();
  }

  draw() {
    this.buttons();
    this.banner();
    this.panel.replaceChildren(...this.pointTable(), ...this.lengthTable(), this.lensLine(), this.answer = html("section", { class: "found", "aria-label": "What the points show", "aria-live": "polite" }), this.saving());
    this.tellFound();
    this.showMisses();
    this.lightRows();
  }

  buttons() {
    const { mode, chosen, hidden } = this.state;
    const button = (id, text, key, run, options = {}) => html("button", { type: "button", id, "aria-keyshortcuts": key, onclick: run, ...options }, `${text} `, html("kbd", { text: key }));
    this.actions.replaceChildren(
      button("mode-point", "Points", "P", () => this.setMode("point"), { "aria-pressed": String(mode === "point") }),
      button("mode-length", "Taped line", "L", () => this.setMode("length"), { "aria-pressed": String(mode === "length") }),
      button("remove", "Remove", "X", () => this.remove(), { disabled: !chosen }),
      button("undo", "Undo", "U", () => this.undo(), { disabled: !this.before.length }),
      button("focal", "Focal length", "F", () => this.focal()),
      button("hide", "Hide the grid", "H", () => this.hide(), { "aria-pressed": String(hidden) }));
  }

  banner() {
    const { mode, begun } = this.state;
    const text = mode === "length"
      ? (begun ? "Click the line's other end." : "Click one end of a straight line on the floor that you taped.")
      : "Click a spot of the floor that you measured, then type where it is, in metres from any corner you like.";
    this.notice.replaceChildren(html("div", { class: "banner", role: "status", text }));
  }

  say(text) {
    this.notice.replaceChildren(html("div", { class: "banner", role: "alert", text }));
  }

  pointTable() {
    const row = (p, k) => html("tr", { "data-mark": `point-${k}`, onclick: (e) => e.target.tagName !== "INPUT" && e.target.tagName !== "BUTTON" && this.choose(["point", k]) },
      html("th", { scope: "row", text: String(k + 1) }),
      html("td", {}, this.input(`Point ${k + 1}, x in metres`, p.x, true, (v) => (this.marks.points[k].x = v))),
      html("td", {}, this.input(`Point ${k + 1}, y in metres`, p.y, true, (v) => (this.marks.points[k].y = v))),
      html("td", { class: "num miss" }),
      html("td", {}, this.removal(["point", k], `Remove point ${k + 1}`)));
    if (!this.marks.points.length) return [html("h2", { text: "Points" }), html("p", { class: "hint", text: "None yet. Four or more, spread over where people walk and not on one line; a fifth shows whether they are right." })];
    return [html("h2", { text: "Points" }), html("table", {},
      html("thead", {}, html("tr", {}, ["", "x m", "y m", "misses by", ""].map((text) => html("th", { scope: "col", text })))),
      html("tbody", {}, this.marks.points.map(row)))];
  }

  lengthTable() {
    if (!this.marks.lengths.length) return [];
    const row = (l, k) => html("tr", { "data-mark": `length-${k}`, onclick: (e) => e.target.tagName !== "INPUT" && e.target.tagName !== "BUTTON" && this.choose(["length", k]) },
      html("th", { scope: "row", text: String.fromCharCode(65 + (k % 26)) }),
      html("td", {}, this.input(`Line ${String.fromCharCode(65 + (k % 26))}, metres`, l.metres, false, (v) => (this.marks.lengths[k].metres = v))),
      html("td", { class: "num miss" }),
      html("td", {}, this.removal(["length", k], `Remove line ${String.fromCharCode(65 + (k % 26))}`)));
    return [html("h2", { text: "Taped lines" }), html("table", {},
      html("thead", {}, html("tr", {}, ["", "metres", "comes out at", ""].map((text) => html("th", { scope: "col", text })))),
      html("tbody", {}, this.marks.lengths.map(row)))];
  }

  removal(what, label) {
    return html("button", { type: "button", class: "plain", "aria-label": label, title: label, onclick: () => this.remove(what), text: "✕" });
  }

  // A field of metres: what is typed holds from the moment it is left; Enter goes on to the next one.
  input(label, value, signed, set) {
    let held = value;
    const read = (field) => {
      try {
        field.setCustomValidity("");
        return field.value.trim() === "" ? null : typedMetres(field.value, signed);
      } catch (error) {
        if (!(error instanceof NotANumber)) throw error;
        field.setCustomValidity(error.message);
        tell(error.message, true);
        return undefined;
      }
    };
    return html("input", {
      type: "text", inputmode: "decimal", autocomplete: "off", "aria-label": label, value: value ?? "",
      onchange: (event) => {
        const now = read(event.target);
        if (now === undefined) event.target.value = held ?? "";
        if (now === undefined || now === held) return;
        held = now;
        this.change(() => set(now), { anew: false });
      },
      onkeydown: (event) => {
        if (event.key === "Enter") {
          const row = [...event.target.closest("tr").querySelectorAll("input")];
          const next = row[row.indexOf(event.target) + 1];
          if (next) next.focus();
          else document.getElementById("main").focus({ preventScroll: true });
        } else if (event.key === "Escape") {
          event.target.value = held ?? "";
          document.getElementById("main").focus({ preventScroll: true });
        }
      },
    });
  }

  lensLine() {
    this.lensText = html("p", { class: "hint" });
    return html("section", {}, html("h2", { text: "Lens" }), this.lensText);
  }

  saving() {
    this.saveButton = html("button", { type: "button", class: "first", id: "save-camera", onclick: () => this.save(), disabled: true, text: "Save to the results folder" });
    this.download = html("a", { class: "button", id: "download-camera", hidden: true, download: "camera.json", text: "Download" });
    this.name = html("input", { type: "text", id: "camera-name", value: this.nameTyped ?? "camera", autocomplete: "off", spellcheck: "false", oninput: (e) => { this.nameTyped = e.target.value; this.download.setAttribute("download", `${this.fileName() ?? "camera"}.json`); } });
    this.saved = html("p", { class: "hint", role: "status" });
    return html("section", { class: "save" }, html("h2", { text: "Keep it" }),
      html("label", { class: "line" }, "Name ", this.name, " .json"), html("div", { class: "row" }, this.saveButton, this.download), this.saved);
  }

  fileName() {
    const name = this.name.value.trim().replace(/\.json$/i, "");
    return NAME.test(name) ? name : null;
  }

  tellFound() {
    const { found } = this.state;
    if (!found) return;
    const { lens } = found;
    if (lens) this.lensText.textContent = lens.focal_px ? `Focal length ${lens.focal_px} px (${lens.source}).` : "Focal length unknown: the points determine it, the better the farther apart they are.";
    const is = found.status === "found";
    this.saveButton.disabled = !is;
    this.download.hidden = !is;
    if (is) {
      if (this.address) URL.revokeObjectURL(this.address);
      this.address = URL.createObjectURL(new Blob([JSON.stringify(found.mount, null, 2), "\n"], { type: "application/json" }));
      this.download.href = this.address;
    }
    const heading = html("h2", { text: is ? "The camera" : "Not yet" });
    const lines = is ? found.lines.filter((line) => !line.startsWith("from ")) : [found.text];
    this.answer.replaceChildren(heading,
      ...lines.map((line) => html("p", { class: found.status === "problem" ? "problem" : null, text: line.replace(/ {2,}/g, "  ") })),
      ...(found.notes ?? []).map((text) => html("p", { class: "hint", text })),
      is && html("p", { class: "hint", text: "Check that grid lines follow the paving and that the horizon lies where distant people's eyes would be at the camera's height." }) || "");
  }

  showMisses() {
    this.marks.points.forEach((p, k) => {
      const cell = this.panel.querySelector(`tr[data-mark="point-${k}"] .miss`);
      const miss = this.misses?.get(p);
      if (!cell) return;
      cell.textContent = miss && miss.off_px !== null ? `${miss.off_px.toFixed(1)} px${miss.off_m === null ? "" : `, ${miss.off_m.toFixed(2)} m`}${miss.wrong ? " – check it" : ""}` : "";
      cell.classList.toggle("problem", Boolean(miss?.wrong));
    });
    this.marks.lengths.forEach((l, k) => {
      const cell = this.panel.querySelector(`tr[data-mark="length-${k}"] .miss`);
      const miss = this.comesOut?.get(l);
      if (cell) cell.textContent = miss && miss.comes_out_m !== null ? `${miss.comes_out_m.toFixed(2)} m` : "";
    });
  }

  async save() {
    const name = this.fileName();
    if (!name) return tell("A name may have letters, digits, dots, hyphens and underscores", true);
    try {
      const { file, measure } = await api.saveCamera(this.fields.id, name, this.request);
      this.saved.textContent = `Saved as ${file}. Then: ${measure}`;
      tell(`Saved as ${file}`);
    } catch (error) {
      if (!(error instanceof api.Problem)) throw error;
      tell(error.message, true);
    }
  }

  async focal() {
    const answer = await askFocal({ ...this.fields, others: {} });
    if (answer) this.change(() => (this.marks.lens = answer.value));
  }

  hide() {
    this.state.hidden = !this.state.hidden;
    this.overlay.draw();
    this.buttons();
  }

  // Arrow keys move the chosen mark, or a cross hair from the middle of the picture, where Space clicks.
  nudge(event) {
    const [dx, dy] = ARROWS[event.key];
    const step = this.overlay.unit * (event.shiftKey ? 20 : 1);
    const { chosen } = this.state;
    if (chosen) {
      const [x, y] = this.pixel(chosen);
      this.change(() => this.setPixel(chosen, [x + dx * step, y + dy * step]), { again: true, anew: false });
      return;
    }
    const [x, y] = this.state.cursor ?? [this.fields.width / 2, this.fields.height / 2];
    this.state.cursor = [x + dx * step, y + dy * step];
    this.overlay.draw();
  }

  // Returns whether the key has a meaning here.
  key(event) {
    if (ARROWS[event.key]) return this.nudge(event), true;
    const onControl = /^(BUTTON|A)$/.test(event.target.tagName);
    if (onControl && (event.key === " " || event.key === "Enter")) return false;
    const keys = {
      " ": () => this.clicked([...(this.state.cursor ?? [this.fields.width / 2, this.fields.height / 2])]),
      p: () => this.setMode("point"), l: () => this.setMode("length"), x: () => this.remove(), Delete: () => this.remove(),
      u: () => this.undo(), f: () => this.focal(), h: () => this.hide(), g: () => (location.hash = this.photoAddress),
      Enter: () => this.state.chosen && this.field(this.state.chosen)?.focus(),
      Escape: () => { Object.assign(this.state, { chosen: null, begun: null, cursor: null }); this.overlay.draw(); this.buttons(); this.banner(); this.lightRows(); },
      "+": () => this.overlay.zoom(1 / 1.3), "-": () => this.overlay.zoom(1.3), r: () => this.overlay.reset(),
    };
    if (/^[1-9]$/.test(event.key) && Number(event.key) <= this.marks.points.length) return this.choose(["point", Number(event.key) - 1]), true;
    const run = keys[event.key] ?? keys[event.key.toLowerCase()];
    return Boolean(run) && (run(), true);
  }
}
