// One photo: its people, their points and names, and the rules for what is being placed.

import * as api from "./annotate_api.js";
import { Canvas } from "./annotate_canvas.js";
import { askAndName, canTakeNames, takeNames } from "./annotate_answers.js";
import { KeptChanges } from "./annotate_changes.js";
import { pressed } from "./annotate_keys.js";
import { called, PART_WORDS } from "./annotate_names.js";
import { Side } from "./annotate_side.js";
import { Problem } from "./api.js";
import { html, tell } from "./elements.js";


export class PhotoView extends KeptChanges {
  // `changed` receives the fields after every change: the page's head shows undo and redo.
  constructor(main, fields, about, changed) {
    super();
    Object.assign(this, { about, changed });
    // person: a key; part: a point of theirs; armed: the next click places it; adding: a new person begins with it.
    this.state = { person: null, part: null, armed: false, adding: false, walking: false, cursor: null };
    const on = {
      choose: (key, part) => this.choose(key, part), moved: (key, part, to) => this.act("set_point", { person: key, part, to }),
      clicked: (at) => this.place(at), failed: () => this.notice("The photo file is missing."),
    };
    this.title = html("h1", {});
    this.count = html("span", { class: "place" });
    this.banner = html("div", { class: "banner", role: "status" });
    this.canvasHost = html("div", { class: "canvas" });
    this.tools = html("div", { class: "actions", role: "toolbar", "aria-label": "Annotate" });
    this.previous = html("button", { type: "button", "aria-label": "Photo before", onclick: () => this.go(-1), text: "←" });
    this.next = html("button", { type: "button", "aria-label": "Next photo", onclick: () => this.go(1), text: "→" });
    const zoom = (label, text, run) => html("button", { type: "button", "aria-label": label, onclick: run, text });
    this.sideHost = html("aside", { class: "side", "aria-label": "People and rules" });
    main.replaceChildren(html("div", { class: "annotate" },
      html("section", { class: "stage", "aria-label": "Photo" },
        html("div", { class: "head" }, html("a", { class: "button", href: "#/", text: "Photos" }), this.title, this.count, this.previous, this.next),
        this.banner, this.canvasHost,
        html("div", { class: "zoom" }, zoom("Zoom in", "+", () => this.canvas.zoom(1 / 1.4)), zoom("Zoom out", "−", () => this.canvas.zoom(1.4)), zoom("Whole photo", "⤢", () => this.canvas.reset())),
        this.tools),
      this.sideHost));
    this.canvas = new Canvas(this.canvasHost, on);
    this.side = new Side(this.sideHost, this);
    this.show(fields);
    this.look();
  }

  close() {
    clearTimeout(this.resting);
    this.canvas.close();
    this.closed = true;
  }

  get person() {
    return this.fields.people.find((p) => p.key === this.state.person) ?? null;
  }

  // Run the back end on this photo where it has not been run, and then in the background on the next.
  async look() {
    if (this.about.pose === "none") return;
    const id = this.fields.id;
    if (this.fields.proposed === null) {
      this.notice("Looking for people ...");
      const answer = await this.asked(() => api.propose(id));
      if (this.closed || answer === null) return;
      this.show(answer);
      this.changed(answer);
    }
    if (this.fields.next !== null) api.propose(this.fields.next).catch((error) => { if (!(error instanceof Problem)) throw error; });
  }

  show(fields) {
    this.fields = fields;
    if (this.nudged && this.person) this.person.points[this.nudged.part] = this.nudged.to; // still under way
    if (!this.person && !this.state.adding) Object.assign(this.state, { person: null, part: null, armed: false, walking: false, cursor: null });
    this.title.textContent = fields.name;
    this.count.textContent = `${fields.id + 1} of ${fields.total}`;
    this.previous.disabled = fields.previous === null;
    this.next.disabled = fields.next === null;
    this.draw();
    if (fields.next !== null) new Image().src = api.picture(fields.next, 1600);
  }

  draw() {
    this.canvas.show(this.fields, this.state, this.about);
    this.canvasHost.classList.toggle("armed", this.state.armed);
    this.side.show();
    this.buttons();
    this.guide();
  }

  buttons() {
    const { fields, person, state } = this;
    const focused = this.tools.contains(document.activeElement) ? document.activeElement.id : null;
    const button = (id, text, key, run, options = {}) => html("button", { type: "button", id, "aria-keyshortcuts": key, onclick: run, ...options }, `${text} `, html("kbd", { text: key }));
    this.tools.replaceChildren(
      button("add", "Add person", "A", () => this.add(), { "aria-pressed": String(state.adding) }),
      button("name", "Name", "N", () => askAndName(this), { disabled: !person }),
      button("hide", "Not visible", "V", () => this.hide(), { disabled: !state.part && !state.adding }),
      button("remove", "Remove", "X", () => this.remove(), { disabled: !person }),
      button("near", "Zoom", "Z", () => this.near(), { disabled: !person }),
      button("same", "Names as before", "M", () => takeNames(this), { disabled: !canTakeNames(this) }),
      html("span", { class: "gap" }),
      button("skip", "Leave out", "I", () => this.skip(), { "aria-pressed": String(fields.skipped) }),
      button("done", fields.done ? "Done" : "Done, next", "Enter", () => this.done(), { class: "first" }));
    if (focused) document.getElementById(focused)?.focus();
  }

  // What to do now, in one line above the photo.
  guide() {
    const { fields, person, state } = this;
    const who = person ? (person.tag === null ? "this person" : called(person.tag, this.about.names)) : "the new person";
    const unnamed = fields.people.filter((p) => p.tag === null).length;
    let text = null;
    if (state.armed) text = `Click ${PART_WORDS[state.part]} of ${who}. V: not visible. Esc: stop.`;
    else if (fields.skipped) text = "This photo is left out of the benchmark.";
    else if (person && state.part) text = `${state.part} of ${who}: drag it, or use the arrow keys. V: not visible.`;
    else if (person && person.tag === null) text = "Who is it? Press a digit for P0 to P9, or N.";
    else if (unnamed) text = `${unnamed === 1 ? "One person has" : `${unnamed} people have`} no name yet: choose each and press a digit, or X to remove a person who was not measured.`;
    else if (!fields.people.length && (fields.proposed !== null || this.about.pose === "none")) text = "Nobody yet. Press A and click the points of a person.";
    this.notice(text);
  }

  notice(text) {
    this.banner.textContent = text ?? "";
    this.banner.classList.toggle("quiet", !text);
  }

  // Choosing a person again puts them down; a part of them stays chosen.
  choose(key, part = null) {
    const again = key === this.state.person && part === null;
    this.flush();
    Object.assign(this.state, { person: again ? null : key, part: again ? null : part, armed: false, adding: false, walking: false, cursor: null });
    this.draw();
  }

  // Choose a part of the chosen person; one that is not set, or chosen already, is placed by the next click.
  choosePart(part) {
    this.flush();
    const { state, person } = this;
    if (!person && !state.adding) {
      tell("Choose a person first, or press A for a new one", true);
      return;
    }
    const at = person?.points[part];
    const armed = !at || (state.part === part && !state.armed);
    Object.assign(state, { part, armed, walking: state.adding, ...this.cross(armed, at) });
    this.draw();
    if (armed) this.canvasHost.scrollIntoView({ block: "nearest" }); // on a phone the list lies below the photo
  }

  partOf(key, part) {
    this.flush();
    if (this.state.person !== key) Object.assign(this.state, { person: key, part: null, armed: false, adding: false });
    this.choosePart(part);
  }

  // The cross of a part to be placed, and where it began.
  cross(armed, at = null) {
    const from = armed ? [...(at ?? this.middle())] : null;
    return { from, cursor: from && [...from] };
  }

  middle() {
    const known = Object.values(this.person?.points ?? {});
    return known[0] ?? [this.canvas.box[0] + this.canvas.box[2] / 2, this.canvas.box[1] + this.canvas.box[3] / 2].map(Math.floor);
  }

  add() {
    this.flush();
    Object.assign(this.state, { person: null, part: this.about.parts[0], armed: true, adding: true, walking: true });
    Object.assign(this.state, this.cross(true));
    this.draw();
  }

  // A cross that was not moved does not show where the point is.
  placeCross() {
    const { cursor, from } = this.state;
    if (cursor[0] === from[0] && cursor[1] === from[1]) tell("Click the point, or move the cross there with the arrow keys first", true);
    else this.place(this.canvas.inside(cursor));
  }

  // Clicks are handled in turn: the first of a new person creates it, and the others are its next parts.
  place(at) {
    this.clicks = (this.clicks ?? Promise.resolve()).then(() => this.placed(at));
    return this.clicks;
  }

  async placed(at) {
    const { state } = this;
    if (!state.armed) return;
    const part = state.part;
    if (state.adding) {
      const before = new Set(this.fields.people.map((p) => p.key));
      const fields = await this.act("add_person", { points: { [part]: at } });
      state.adding = false;
      state.person = fields?.people.find((p) => !before.has(p.key))?.key ?? null;
      if (state.person === null) return this.putDown();
    } else await this.act("set_point", { person: state.person, part, to: at });
    this.walk(part);
  }

  // After a placed or skipped part of a new person the next one follows.
  walk(part) {
    const { state } = this;
    const parts = this.about.parts;
    const next = state.walking ? parts.slice(parts.indexOf(part) + 1).find((p) => !this.person?.points[p]) : null;
    Object.assign(state, { part: next ?? (state.walking ? null : part), armed: Boolean(next), walking: Boolean(next), ...this.cross(Boolean(next)) });
    this.draw();
  }

  hide() {
    const { state, person } = this;
    if (state.walking) {
      this.walk(state.part); // of a person who is being added, it stays unset
      return;
    }
    if (!person || !state.part) return;
    const part = state.part;
    Object.assign(state, { armed: false, cursor: null });
    if (!person.points[part]) return this.draw();
    this.act("set_point", { person: person.key, part, to: null }, `${part}: not visible`);
  }

  putDown() {
    Object.assign(this.state, { person: null, part: null, armed: false, adding: false, walking: false, cursor: null });
    this.draw();
  }

  remove() {
    const { person } = this;
    if (person) this.act("remove_person", { person: person.key }, "Removed");
  }

  near() {
    if (this.person && Object.keys(this.person.points).length) this.canvas.zoomTo(this.person);
  }

  skip() {
    return this.act("skip", { skipped: !this.fields.skipped }, this.fields.skipped ? "Included again" : "Left out");
  }

  async done() {
    const unnamed = this.fields.people.filter((p) => p.tag === null).length;
    if (unnamed && !this.warned) {
      this.warned = true;
      tell(`${unnamed === 1 ? "One person is" : `${unnamed} people are`} unnamed and will not be in the files. Enter again to go on.`, true);
      return;
    }
    if (!this.fields.done) await this.act("finish", { done: true });
    if (this.fields.next !== null) this.go(1);
    else tell("That was the last photo. Next: places");
  }

  async go(step) {
    const id = step > 0 ? this.fields.next : this.fields.previous;
    await this.rest();
    if (id !== null) location.hash = `#/photo/${id}`;
  }

  step(by) {
    const { people } = this.fields;
    if (!people.length) return;
    const at = people.findIndex((p) => p.key === this.state.person);
    const next = at < 0 ? (by > 0 ? 0 : people.length - 1) : (at + by + people.length) % people.length;
    if (people[next].key !== this.state.person) this.choose(people[next].key);
  }

  escape() {
    const { state } = this;
    this.flush();
    if (!state.armed && !state.part) return this.putDown();
    Object.assign(state, { part: null, armed: false, adding: false, walking: false, cursor: null });
    this.draw();
  }

  key = (event) => pressed(this, event);
}
