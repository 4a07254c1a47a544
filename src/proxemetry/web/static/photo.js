// One photo: the picture, the view from above and the tables, linked; and everything one may put right.

import * as api from "./api.js";
import { askFocal, askText } from "./dialogs.js";
import { html, tell } from "./elements.js";
import { Overlay } from "./overlay.js";
import { Panel, SIZES } from "./panel.js";
import { Plan } from "./plan.js";

const SIZE_CYCLE = [null, "adults", "children"];
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
    };
    this.title = html("h1", {});
    this.placeText = html("span", { class: "place" });
    this.canvas = html("div", { class: "canvas" });
    this.actions = html("div", { class: "actions", role: "toolbar", "aria-label": "Put right" });
    this.planHost = html("div", { class: "plan" });
    this.panelHost = html("div", { class: "panel" });
    this.previous = html("button", { type: "button", "aria-label": "Previous photo", onclick: () => this.go(-1), text: "←" });
    this.next = html("button", { type: "button", "aria-label": "Next photo", onclick: () => this.go(1), text: "→" });
    this.root = html("div", { class: "photo" },
      html("section", { class: "stage", "aria-label": "Photo" },
        html("div", { class: "head" }, html("a", { class: "button", href: `#/?${api.searchOf(query)}`, text: "Gallery" }), this.title, this.placeText, this.previous, this.next),
        this.canvas, this.actions),
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
    const size = person ? SIZES[person.size] ?? "as in the run" : "";
    this.actions.replaceChildren(
      button("remove", person ? `Remove person ${chosen}` : "Remove", "X", () => this.remove(), { disabled: !person }),
      button("add", "Add person", "A", () => this.beginAdding(), { disabled: fields.status === "excluded" || fields.status === "failed" }),
      button("size", person ? `Body: ${size}` : "Body size", "B", () => this.size(), { disabled: !person }),
      button("floor", person?.off_floor ? "Back on the floor" : "Off the floor", "O", () => this.floor(), { disabled: !person }),
      button("focal", "Focal length", "F", () => this.focal()),
      button("exclude", fields.status === "excluded" ? "Count it again" : "Exclude", "E", () => this.exclude()),
      button("note", "Note", "N", () => this.note()),
      button("all", "All pairs", "P", () => this.toggle("allPairs"), { "aria-pressed": String(this.state.allPairs) }),
      html("span", { class: "gap" }),
      button("undo", "Undo", "U", () => this.undo(), { disabled: !fields.history.some((a) => a.who === fields.who) }),
      button("checked", "All right", "Enter", () => this.checked(), { class: "first" }));
  }

  banner() {
    this.canvas.querySelector(".banner")?.remove();
    const { fields, state } = this;
    const button = (text, run, first) => html("button", { type: "button", class: first ? "first" : null, onclick: run, text });
    let content = null;
    if (state.adding) {
      const joint = fields.click[state.adding.at];
      content = joint
        ? [`Click the person's own ${joint.replaceAll("_", " ")}.`, button("Skip", () => this.skip()), button("Done", () => this.doneAdding(), true), button("Cancel", () => this.stopAdding())]
        : ["All joints are clicked.", button("Done", () => this.doneAdding(), true), button("Cancel", () => this.stopAdding())];
    } else if (this.joint) {
      content = [`Person ${this.joint.person}, ${this.joint.name.replaceAll("_", " ")}: move it by the arrow keys, Enter keeps it.`];
    } else if (fields.status !== "ok") {
      content = [fields.status === "no_camera" ? "The focal length is unknown, so there are no distances." : fields.reason ?? ""];
      if (fields.status === "no_camera") content.push(button("Set the focal length", () => this.focal(), true));
    }
    if (content) this.canvas.append(html("div", { class: "banner", role: "status" }, content));
    this.root.classList.toggle("adding", state.adding !== null);
  }

  noPicture() {
    if (!this.canvas.querySelector(".banner")) {
      this.canvas.append(html("div", { class: "banner", role: "status", text: "The photo itself is not here; what was found in it is." }));
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
    return this.change(() => api.undo(this.fields.id, this.query), "Taken back");
  }

  remove() {
    if (this.chosen === null) return;
    const box = this.boxOf(this.chosen);
    const number = this.chosen;
    this.chosen = null;
    this.act("remove_person", { box }, `Person ${number} removed; the others are numbered anew`);
  }

  size() {
    if (this.chosen === null) return;
    const now = this.fields.people[this.chosen].size;
    const size = SIZE_CYCLE[(SIZE_CYCLE.indexOf(now) + 1) % SIZE_CYCLE.length];
    this.act("body_size", { box: this.boxOf(this.chosen), body_size: size });
  }

  floor() {
    if (this.chosen === null) return;
    this.act("off_floor", { box: this.boxOf(this.chosen), off_floor: !this.fields.people[this.chosen].off_floor });
  }

  async focal() {
    const value = await askFocal(this.fields.camera);
    if (value) await this.act("set_camera", value, "Focal length set");
  }

  async note() {
    const text = await askText("Note on this photo", "Note", this.fields.about.note ?? "", "Keep");
    if (text !== null) await this.act("note", { text }, "Note kept");
  }

  async exclude() {
    if (this.fields.status === "excluded") {
      await this.act("exclude", { excluded: false }, "The photo counts again");
      return;
    }
    const reason = await askText("Exclude this photo", "Reason", "", "Exclude");
    if (reason !== null) await this.act("exclude", { excluded: true, reason: reason.trim() }, "Excluded");
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

  // Answers whether the key meant something here.
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
      f: () => this.focal(), e: () => this.exclude(), n: () => this.note(), u: () => this.undo(), p: () => this.toggle("allPairs"),
      h: () => this.toggle("hidden"), "+": () => this.overlay.zoom(1 / 1.3), "-": () => this.overlay.zoom(1.3), r: () => this.overlay.reset(),
      "]": () => step(1), "[": () => step(-1), ".": () => this.nextJoint(), Escape: () => this.chosen !== null && this.choose(this.chosen),
    };
    if (/^[0-9]$/.test(event.key) && Number(event.key) < people) return this.choose(Number(event.key)), true;
    const run = keys[event.key] ?? keys[event.key.toLowerCase()];
    return Boolean(run) && (run(), true);
  }
}
