// The photo with the points of its people, in pixels of the full-size photo.

import * as api from "./annotate_api.js";
import { called, colourOf, PART_KEYS } from "./annotate_names.js";
import { svg } from "./elements.js";
import { ZoomedPhoto } from "./zoom.js";

const BONES = [["Eyes", "Head"], ["Head", "Shoulder"], ["Eyes", "Shoulder"], ["Shoulder", "Torso"], ["Head", "Torso"]];

export class Canvas extends ZoomedPhoto {
  // Events passed to `on`: choose(key, part), moved(key, part, [x, y]), clicked([x, y]), failed().
  constructor(canvas, on) {
    super(canvas, "Photo with people and their points", on);
  }

  show(fields, state, about) {
    const other = this.fields?.id !== fields.id;
    Object.assign(this, { fields, state, about });
    if (other) this.open(fields, (size) => api.picture(fields.id, size));
    else this.draw();
  }

  grabs = (event) => event.target.closest?.(".point");

  pressed(event) {
    if (event.button !== 0) return;
    const point = this.grabs(event);
    if (point && !this.state.armed) this.drag(event, point);
    else this.pan(event, this.state.armed);
  }

  // While a part is to be placed, a click places it; a drag still moves the photo.
  pan(event, placing = false) {
    if (!placing) return super.pan(event);
    const from = [event.clientX, event.clientY];
    window.addEventListener("pointerup", (e) => {
      if (Math.hypot(e.clientX - from[0], e.clientY - from[1]) <= 3) this.on.clicked(this.inside(this.at(e)));
    }, { once: true });
    super.pan(event);
  }

  inside([x, y]) {
    const { width, height } = this.fields;
    return [Math.min(Math.max(Math.floor(x), 0), width - 1), Math.min(Math.max(Math.floor(y), 0), height - 1)];
  }

  drag(event, group) {
    const { key, part } = group.dataset;
    let to = null;
    this.follow(event, (e) => {
      to = this.inside(this.at(e));
      group.setAttribute("transform", `translate(${to[0] - Number(group.dataset.x)} ${to[1] - Number(group.dataset.y)})`);
      group.classList.add("taken");
    }, () => (to ? this.on.moved(Number(key), part, to) : this.on.choose(Number(key), part)));
  }

  // Zoom in on a person; back to the whole photo where it is zoomed in already.
  zoomTo(person) {
    const points = Object.values(person.points);
    const [xs, ys] = [points.map((p) => p[0]), points.map((p) => p[1])];
    const { width, height } = this.fields;
    const extent = Math.max(Math.max(...ys) - Math.min(...ys), Math.max(...xs) - Math.min(...xs), width / 30) * 3.5;
    const share = Math.min(1, Math.max(extent / width, extent / height));
    const [w, h] = [width * share, height * share];
    const middle = (values) => (Math.min(...values) + Math.max(...values)) / 2;
    const box = [Math.min(Math.max(middle(xs) - w / 2, 0), width - w), Math.min(Math.max(middle(ys) - h / 2, 0), height - h), w, h];
    const same = box.every((v, k) => Math.abs(v - this.box[k]) < 1);
    if (same) this.reset();
    else {
      this.box = box;
      this.draw();
    }
  }

  draw() {
    this.root.setAttribute("viewBox", this.box.join(" "));
    const { fields, state, unit } = this;
    const order = [...fields.people].sort((a, b) => (a.key === state.person) - (b.key === state.person));
    this.things.replaceChildren(...order.map((p) => this.person(p, unit)), ...order.map((p) => this.badge(p, unit)).filter(Boolean), ...this.cursor(unit));
  }

  person(p, unit) {
    const chosen = p.key === this.state.person;
    const { fill, ink } = colourOf(p.tag, this.about.colours);
    const group = svg("g", { class: `body${chosen ? " chosen" : ""}`, "data-key": p.key });
    const bones = BONES.filter(([a, b]) => p.points[a] && p.points[b] && !(a === "Eyes" && b === "Shoulder" && p.points.Head) && !(a === "Head" && b === "Torso" && p.points.Shoulder));
    for (const kind of ["casing", "bone"]) {
      group.append(...bones.map(([a, b]) => svg("line", { class: kind, x1: p.points[a][0], y1: p.points[a][1], x2: p.points[b][0], y2: p.points[b][1],
        stroke: kind === "bone" ? fill : null, "stroke-width": (chosen ? 2 : 1.5) * unit + (kind === "casing" ? 2 * unit : 0) })));
    }
    for (const [part, [x, y]] of Object.entries(p.points)) group.append(this.point(p, part, x, y, { chosen, fill, ink, unit }));
    return group;
  }

  // Pixel x, y is a square: the point lies in its middle.
  point(p, part, x, y, { chosen, fill, ink, unit }) {
    const active = chosen && this.state.part === part;
    const radius = (chosen ? 9 : 5) * unit;
    const group = svg("g", { class: `point${active ? " active" : ""}`, "data-key": p.key, "data-part": part, "data-x": x, "data-y": y });
    const [u, v] = [x + 0.5, y + 0.5];
    group.append(svg("circle", { class: "reach", cx: u, cy: v, r: Math.max(radius, 13 * unit) }));
    if (chosen) {
      // What lies under the point must be seen: a ring and a dot, with its letter beside.
      group.append(svg("circle", { class: "ring under", cx: u, cy: v, r: radius }), svg("circle", { class: "ring", cx: u, cy: v, r: radius, stroke: fill }),
        svg("circle", { class: "dot", cx: u, cy: v, r: 1.8 * unit, fill }));
      // Eyes and head lie close together: their letters stand on either side.
      const [lx, ly] = [u + (part === "Eyes" ? -1 : 1) * (radius + 8 * unit), v];
      group.append(svg("rect", { class: "plate", x: lx - 7 * unit, y: ly - 8 * unit, width: 14 * unit, height: 16 * unit, rx: 3 * unit, fill }),
        svg("text", { class: "letter", x: lx, y: ly, "font-size": 12 * unit, fill: ink, text: PART_KEYS[part] }));
    } else group.append(svg("circle", { class: "mark", cx: u, cy: v, r: radius, fill }));
    group.append(svg("title", { text: `${p.tag ?? "unnamed"}: ${part}` }));
    return group;
  }

  badge(p, unit) {
    const points = Object.values(p.points);
    if (!points.length) return null;
    const top = points.reduce((a, b) => (b[1] < a[1] ? b : a));
    const { fill, ink } = colourOf(p.tag, this.about.colours);
    const text = p.tag === null ? "?" : called(p.tag, this.about.names);
    const [h, size] = [20 * unit, 13 * unit];
    const w = Math.max(text.length * size * 0.6 + 10 * unit, h);
    const [left, right] = [this.box[0], this.box[0] + this.box[2]];
    if (top[0] < left || top[0] > right) return null;
    const x = Math.min(Math.max(top[0], left + w / 2), right - w / 2);
    const y = Math.max(top[1] - 26 * unit, this.box[1] + h / 2 + 2 * unit);
    const choose = () => this.on.choose(p.key, null);
    const group = svg("g", { class: `badge${p.key === this.state.person ? " chosen" : ""}`, role: "button", tabindex: 0, "data-key": p.key, "aria-label": p.tag === null ? "Unnamed person" : `Person ${text}`,
      "aria-pressed": String(p.key === this.state.person), onclick: choose, onkeydown: (e) => (e.key === " " || e.key === "Enter") && (e.preventDefault(), e.stopPropagation(), choose()) },
    svg("rect", { x: x - w / 2, y: y - h / 2, width: w, height: h, rx: h / 2, fill }),
    svg("text", { x, y, "font-size": size, fill: ink, text }));
    return group;
  }

  cursor(unit) {
    const { cursor } = this.state;
    if (!cursor) return [];
    const [x, y] = [cursor[0] + 0.5, cursor[1] + 0.5];
    return [[18, 0], [0, 18]].flatMap(([dx, dy]) => ["under", "over"].map((kind) =>
      svg("line", { class: `cross ${kind}`, x1: x - dx * unit, y1: y - dy * unit, x2: x + dx * unit, y2: y + dy * unit })));
  }
}
