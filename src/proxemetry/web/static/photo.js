// One photo: the picture, the view from above and the tables, linked; and everything that can be corrected.

import * as api from "./api.js";
import { askFocal, askSize, askText } from "./dialogs.js";
import { html, plural, tell } from "./elements.js";
import { Overlay } from "./overlay.js";
import { Panel, SIZES } from "./panel.js";
import { Plan } from "./plan.js";

// Digits typed within this time are one number: 1 and 2 choose person 12.
const DIGITS_MS = 700;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

export class PhotoView {
  constructor(main, fields, query) {
    this.query = query;
    this.state = { allPairs: false, hidden: false, adding: null, cursor: null };
    this.chosen = null;
    this.lit = {};
    this.joint = null;
    const on = {
      choose: (person) => this.choose(person),
      light: (what) => { this.lit = what; this.mark(); },
      moved: (person, joint, to) => this.act("move_joint", { box: this.boxOf(person), joint, to }),
      clicked: (point) => this.addJoint(point),
      failed: () => this.noPicture(),
      drawn: () => this.mark(),
      focal: () => this.focal(),
      calibrate: () => this.calibrate(),
    };
    this.title = html("h1", {});
    this.placeText = html("span", { class: "place" });
    this.notice = html("div", { class: "notice" });
    this.canvas = html("div", { class: "canvas" });
    this.actions = html("div", { class: "actions", role: "toolbar", "aria-label": "Corrections" });
    this.planHost = html("div", { class: "plan" });
    this.panelHost = html("div", { class: "panel" });
    this.previous = html("button", { type: "button", "aria-label": "Previous photo", onclick: () => this.go(-1), text: "←" });
    this.next = html("button", { type: "button", "aria-label": "Next photo", onclick: () => this.go(1), text: "→" });
    this.root = html("div", { class: "photo" },
      html("section", { class: "stage", "aria-label": "Photo" },
        html("div", { class: "head" }, html("a", { class: "button", href: `#/?${api.searchOf(query)}`, text: "Gallery" }), this.title, this.placeText, this.previous, this.next),
        this.notice, this.canvas, this.actions),
      html("aside", { class: "side", "aria-label": "View from above and tables" }, this.planHost, this.panelHost));
    main.replaceChildren(this.root);
    this.overlay = new Overlay(this.canvas, on);
    this.plan = new Plan(this.planHost, on);
    this.panel = new Panel(this.panelHost, on);
    this.show(fields);
  }

  close() {
    this.overlay.close();
    this.plan.close();
  }

  show(fields) {
    this.fields = fields;
    if (this.chosen !== null && this.chosen >= fields.people.length) this.chosen = null;
    this.title.textContent = fields.photo;
    this.placeText.textContent = fields.place === null ? "" : `${fields.place + 1} of ${fields.total}`;
    this.previous.disabled = fields.previous === null;
    this.next.disabled = fields.next === null;
    this.overlay.show(fields, this.state);
    this.plan.show(fields, this.state);
    this.panel.show(fields);
    this.buttons();
    this.banner();
    this.mark();
    if (fields.next !== null) new Image().src = api.picture(fields.next, 1600);
  }

  buttons() {
    const { fields, chosen } = this;
    const person = chosen === null ? null : fields.people[chosen];
    const button = (id, text, key, run, options = {}) => html("button", { type: "button", id, "aria-keyshortcuts": key, onclick: run, ...options }, `${text} `, html("kbd", { text: key }));
    // Labels keep their width whoever is chosen, so that no button moves under the pointer.
    this.actions.replaceChildren(
      html("span", { class: "who", "aria-live": "polite", text: person ? `Person ${chosen}` : "Nobody chosen" }),
      button("remove", "Remove", "X", () => this.remove(), { disabled: !person }),
      button("add", "Add person", "A", () => this.beginAdding(), { disabled: fields.status === "excluded" || fields.status === "failed" }),
      button("size", "Body size", "B", () => this.size(), { disabled: !person }),
      button("floor", "Off the floor", "O", () => this.floor(), { disabled: !person, "aria-pressed": String(Boolean(person?.off_floor)) }),
      button("focal", "Focal length", "F", () => this.focal()),
      button("exclude", "Exclude", "E", () => this.exclude(), { "aria-pressed": String(fields.status === "excluded") }),
      button("note", "Note", "N", () => this.note()),
      button("all", "All pairs", "P", () => this.toggle("allPairs"), { "aria-pressed": String(this.state.allPairs) }),
      html("span", { class: "gap" }),
      button("undo", "Undo", "U", () => this.undo(), { disabled: !fields.history.some((a) => a.who === fields.who) }),
      button("checked", "Accept", "Enter", () => this.checked(), { class: "first" }));
  }

  banner() {
    const { fields, state } = this;
    const button = (text, run, first) => html("button", { type: "button", class: first ? "first" : null, onclick: run, text });
    let content = null;
    if (state.adding) {
      const joint = fields.click[state.adding.at];
      content = joint
        ? [`Click the person's own ${joint.replaceAll("_", " ")}.`, button("Skip", () => this.skip()), button("Done", () => this.doneAdding(), true), button("Cancel", () => this.stopAdding())]
        : ["All joints are clicked.", button("Done", () => this.doneAdding(), true), button("Cancel", () => this.stopAdding())];
    } else if (this.joint) {
      content = [`Person ${this.joint.person}, ${this.joint.name.replaceAll("_", " ")}: move it with the arrow keys, then press Enter.`];
    } else if (state.spread?.length) {
      content = [`The focal length was set on ${plural(state.spread.length, "photo", "photos")}.`, button("Undo all", () => this.takeBack()), button("Dismiss", () => { state.spread = null; this.banner(); })];
    } else if (fields.status !== "ok") {
      content = [fields.status === "no_camera" ? "The focal length is unknown, so there are no distances." : fields.reason ?? ""];
      if (fields.status === "no_camera") content.push(button("Set the focal length", () => this.focal(), true));
    }
    this.notice.replaceChildren(...(content ? [html("div", { class: "banner", role: "status" }, content)] : []));
    this.root.classList.toggle("adding", state.adding !== null);
  }

  noPicture() {
    if (!this.notice.firstChild) {
      this.notice.append(html("div", { class: "banner", role: "status", text: "The photo file is missing. What was found in it is shown without it." }));
    }
  }

  mark() {
    const pair = this.lit.pair;
    const ends = pair ? pair.split("-") : [];
    for (const element of this.root.querySelectorAll("[data-person]")) {
      const { person } = element.dataset;
      element.classList.toggle("lit", String(this.lit.person) === person);
      element.classList.toggle("chosen", String(this.chosen) === person);
      element.classList.toggle("faded", Boolean(pair) && element.classList.contains("person") && !ends.includes(person));
    }
    for (const element of this.root.querySelectorAll("[data-pair]")) {
      const lit = element.dataset.pair === pair;
      element.classList.toggle("lit", lit);
      if (element.classList.contains("spare")) element.setAttribute("visibility", lit ? "visible" : "hidden");
    }
  }

  choose(person) {
    this.chosen = this.chosen === person ? null : person;
    this.buttons();
    this.mark();
  }

  boxOf = (person) => this.fields.people[person].box;

  async change(run, text) {
    if (this.busy) return;
    this.busy = true;
    try {
      const fields = await run();
      if (fields.id === this.fields.id) this.show(fields);
      if (text) tell(text);
    } catch (error) {
      if (!(error instanceof api.Problem)) throw error;
      tell(error.message, true);
      this.show(this.fields);
    } finally {
      this.busy = false;
    }
  }

  act(action, value, text) {
    return this.change(() => api.act(this.fields.id, this.query, action, value), text);
  }

  undo() {
    return this.change(() => api.undo(this.fields.id, this.query), "Undone");
  }

  remove() {
    if (this.chosen === null) return;
    const box = this.boxOf(this.chosen);
    const number = this.chosen;
    this.chosen = null;
    this.act("remove_person", { box }, `Person ${number} removed; the others are numbered anew`);
  }

  async size() {
    if (this.chosen === null) return;
    const person = this.chosen;
    const now = this.fields.people[person].size;
    const answer = await askSize(person, now);
    if (answer === null || answer.size === now) return;
    const name = SIZES[answer.size] ?? "as in the run";
    await this.act("body_size", { box: this.boxOf(person), body_size: answer.size }, `Person ${person}: ${name} (U undoes it)`);
  }

  floor() {
    if (this.chosen === null) return;
    const off = !this.fields.people[this.chosen].off_floor;
    this.act("off_floor", { box: this.boxOf(this.chosen), off_floor: off }, `Person ${this.chosen}: ${off ? "off" : "back on"} the shared floor`);
  }

  async focal() {
    const answer = await askFocal(this.fields);
    if (!answer) return;
    const { value, scope } = answer;
    if (scope === "photo") await this.act("set_camera", value, "Focal length set");
    else await this.change(() => this.spread(value, scope));
  }

  // One photo after the other, each with an entry of its own in the log: what was done stays if this is left half way.
  async spread(value, scope) {
    const { id } = this.fields;
    const ids = [id, ...(await api.alike(id, scope)).photos];
    const done = [];
    let fields = this.fields;
    try {
      for (const one of ids) {
        const answer = await api.act(one, this.query, "set_camera", value);
        if (one === id) fields = answer;
        done.push(one);
        tell(`Focal length set on ${done.length} of ${plural(ids.length, "photo", "photos")}`);
      }
    } finally {
      this.state.spread = done;
    }
    return fields;
  }

  async takeBack() {
    const ids = this.state.spread;
    this.state.spread = null;
    await this.change(async () => {
      let { fields } = this;
      for (const [k, one] of ids.entries()) {
        const answer = await api.undo(one, this.query);
        if (one === this.fields.id) fields = answer;
        tell(`Undone on ${k + 1} of ${plural(ids.length, "photo", "photos")}`);
      }
      return fields;
    });
  }

  calibrate() {
    location.hash = `#/calibrate/${this.fields.id}?${api.searchOf(this.query)}`;
  }

  async note() {
    const text = await askText("Note on this photo", "Note", this.fields.note ?? "", "Save");
    if (text !== null) await this.act("note", { text }, text ? "Note saved" : "Note removed");
  }

  async exclude() {
    if (this.fields.status === "excluded") {
      await this.act("exclude", { excluded: false }, "The photo counts again");
      return;
    }
    const reason = await askText("Exclude this photo", "Reason", "", "Exclude");
    if (reason !== null) await this.act("exclude", { excluded: true, reason }, "Excluded");
  }

  async checked() {
    if (!this.fields.history.some((a) => a.action === "checked" && a.who === this.fields.who)) await this.act("checked", {});
    if (this.fields.next !== null) this.go(1);
    else tell("That was the last photo");
  }

  toggle(name) {
    this.state[name] = !this.state[name];
    this.show(this.fields);
  }

  go(step) {
    const id = step > 0 ? this.fields.next : this.fields.previous;
    if (id !== null) location.hash = `#/photo/${id}?${api.searchOf(this.query)}`;
  }

  beginAdding() {
    const { width, height } = this.fields;
    this.state.adding = { at: 0, joints: {} };
    this.state.cursor = [width / 2, height / 2];
    this.overlay.draw();
    this.banner();
  }

  addJoint(point) {
    const { adding } = this.state;
    const joint = this.fields.click[adding.at];
    if (!joint) return;
    adding.joints[joint] = point;
    this.skip();
  }

  skip() {
    this.state.adding.at += 1;
    this.overlay.draw();
    this.banner();
  }

  stopAdding() {
    this.state.adding = null;
    this.state.cursor = null;
    this.overlay.draw();
    this.banner();
  }

  doneAdding() {
    const { joints } = this.state.adding;
    if (Object.keys(joints).length < 2) {
      tell("Click at least two joints; shoulders and hips place a person best", true);
      return;
    }
    this.state.adding = null;
    this.state.cursor = null;
    this.act("add_person", { joints }, "Person added");
  }

  nextJoint() {
    const person = this.chosen;
    if (person === null) return;
    const seen = this.fields.joints.filter((_, k) => this.fields.people[person].keypoints[k]);
    const at = this.joint?.person === person ? seen.indexOf(this.joint.name) + 1 : 0;
    const name = seen[at % seen.length];
    const point = this.fields.people[person].keypoints[this.fields.joints.indexOf(name)];
    this.joint = name ? { person, name, to: [...point] } : null;
    this.state.cursor = this.joint?.to ?? null;
    this.overlay.draw();
    this.banner();
  }

  leaveJoint(keep) {
    const { person, name, to } = this.joint;
    this.joint = null;
    this.state.cursor = null;
    if (keep) this.act("move_joint", { box: this.boxOf(person), joint: name, to });
    else this.show(this.fields);
  }

  nudge(event) {
    const [dx, dy] = ARROWS[event.key];
    const step = this.overlay.unit * (event.shiftKey ? 20 : 2);
    this.state.cursor[0] += dx * step;
    this.state.cursor[1] += dy * step;
    this.overlay.draw();
  }

  digit(key, people) {
    const now = performance.now();
    const both = this.typed && now - this.typed.at < DIGITS_MS ? Number(this.typed.text + key) : NaN;
    const number = both < people ? both : Number(key);
    this.typed = { text: String(number), at: now };
    if (number < people) this.choose(number);
  }

  // Returns whether the key has a meaning here.
  key(event) {
    const onControl = /^(BUTTON|A)$/.test(event.target.tagName) || event.target.getAttribute?.("role") === "button";
    if (this.state.cursor && ARROWS[event.key]) return this.nudge(event), true;
    if (this.state.adding) {
      const keys = { " ": () => this.addJoint([...this.state.cursor]), s: () => this.skip(), Enter: () => this.doneAdding(), Escape: () => this.stopAdding() };
      if (onControl && (event.key === " " || event.key === "Enter")) return false;
      return Boolean(keys[event.key]) && (keys[event.key](), true);
    }
    if (this.joint && (event.key === "Enter" || event.key === "Escape")) return this.leaveJoint(event.key === "Enter"), true;
    if (onControl && event.key === "Enter") return false;
    const people = this.fields.people.length;
    const step = (by) => people && this.choose(((this.chosen ?? (by > 0 ? -1 : 0)) + by + people) % people);
    const keys = {
      ArrowRight: () => this.go(1), j: () => this.go(1), ArrowLeft: () => this.go(-1), k: () => this.go(-1),
      Enter: () => this.checked(), g: () => (location.hash = `#/?${api.searchOf(this.query)}`),
      x: () => this.remove(), Delete: () => this.remove(), a: () => this.beginAdding(), b: () => this.size(), o: () => this.floor(),
      f: () => this.focal(), c: () => this.fields.status !== "failed" && this.calibrate(), e: () => this.exclude(), n: () => this.note(), u: () => this.undo(), p: () => this.toggle("allPairs"),
      h: () => this.toggle("hidden"), "+": () => this.overlay.zoom(1 / 1.3), "-": () => this.overlay.zoom(1.3), r: () => this.overlay.reset(),
      "]": () => step(1), "[": () => step(-1), ".": () => this.nextJoint(), Escape: () => this.chosen !== null && this.choose(this.chosen),
    };
    if (/^[0-9]$/.test(event.key)) return this.digit(event.key, people), true;
    const run = keys[event.key] ?? keys[event.key.toLowerCase()];
    return Boolean(run) && (run(), true);
  }
}
