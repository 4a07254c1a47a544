// The photo with what was found: skeletons, numbers and distances, in pixels of the full-size photo.

import * as api from "./api.js";
import { pairText, svg } from "./elements.js";
import { place, placeBadges } from "./placement.js";
import { ZoomedPhoto } from "./zoom.js";

const MOST_SPARE_PAIRS = 1200;
// How many of its own heights a label goes to leave a head and a body; how thick limbs are in heads' radii (as in the figures).
const HEAD_COST = 14;
const BODY_COST = 8;
const LIMB = 0.35;
const TRUNK = ["left_shoulder", "right_shoulder", "left_hip", "right_hip"];

export class Overlay extends ZoomedPhoto {
  // Events passed to `on`: choose(person), light({person, pair}), moved(person, joint, [x, y]), clicked([x, y]), failed(), drawn().
  constructor(canvas, on) {
    super(canvas, "Photo with people and distances", on);
  }

  show(fields, state) {
    const other = this.fields?.id !== fields.id;
    this.fields = fields;
    this.state = state;
    if (other) this.open(fields, fields.status === "failed" ? null : (size) => api.picture(fields.id, size));
    else this.draw();
  }

  grabs = (event) => event.target.closest?.(".joint");

  pressed(event) {
    if (event.button !== 0) return;
    const joint = this.grabs(event);
    if (this.state.adding) this.on.clicked(this.at(event));
    else if (joint) this.drag(event, joint);
    else this.pan(event);
  }

  drag(event, circle) {
    const { person, joint } = circle.dataset;
    let point = null;
    const move = (e) => {
      point = this.at(e);
      circle.setAttribute("cx", point[0]);
      circle.setAttribute("cy", point[1]);
    };
    circle.classList.add("taken");
    this.follow(event, move, () => {
      circle.classList.remove("taken");
      if (point) this.on.moved(Number(person), joint, point);
      else this.on.choose(Number(person));
    });
  }

  draw() {
    this.root.setAttribute("viewBox", this.box.join(" "));
    const { fields, state, unit } = this;
    if (state.hidden) {
      this.things.replaceChildren(...this.clicks(unit));
      return;
    }
    const many = fields.people.length > 14;
    const radius = (many ? 9 : 11) * unit;
    const bounds = [this.box[0], this.box[1], this.box[0] + this.box[2], this.box[1] + this.box[3]];
    const heads = fields.people.map((p) => p.head ?? [...(p.anchor ?? [0, 0]), 0]);
    const badges = placeBadges(heads, radius, bounds);
    this.things.replaceChildren(
      ...fields.people.map((p) => this.person(p, unit, many)),
      ...this.pairs(unit, many, badges.filter(Boolean).map((b) => b.box), heads, bounds),
      ...badges.map((b, i) => b && this.badge(fields.people[i], b.centre, radius)).filter(Boolean),
      ...this.clicks(unit),
    );
    this.on.drawn();
  }

  person(p, unit, many) {
    const width = (many ? 2 : 3) * unit;
    const lines = (kind, extra) => p.bones.map(([x1, y1, x2, y2]) =>
      svg("line", { class: kind, x1, y1, x2, y2, "stroke-width": width + extra, stroke: kind === "bone" ? p.colour : null }));
    const group = svg("g", { class: `person${p.placed ? "" : " unplaced"}${p.doubt ? " doubtful" : ""}`, "data-person": p.number });
    if (p.box) {
      const [x, y, x1, y1] = p.box;
      const frame = { x, y, width: x1 - x, height: y1 - y };
      group.append(svg("rect", { class: "reach", ...frame, onclick: () => this.on.choose(p.number) }), svg("rect", { class: "frame under", ...frame }), svg("rect", { class: "frame", ...frame }));
    }
    group.append(...lines("casing", 2 * unit), ...lines("bone", 0));
    p.keypoints.forEach((point, k) => {
      if (!point) return;
      const circle = svg("circle", { class: "joint", cx: point[0], cy: point[1], r: (many ? 3 : 4.5) * unit, fill: p.colour });
      circle.dataset.person = p.number;
      circle.dataset.joint = this.fields.joints[k];
      circle.append(svg("title", { text: this.fields.joints[k].replaceAll("_", " ") }));
      group.append(circle);
    });
    this.linked(group, { person: p.number });
    return group;
  }

  badge(p, [x, y], radius) {
    const place = p.placed ? `Person ${p.number}` : `Person ${p.number}, without a place: ${p.reason}`;
    const label = p.doubt ? `${place}; doubtful: ${p.doubt}` : place;
    const group = svg("g", { class: "badge", "data-person": p.number, role: "button", tabindex: 0, "aria-label": label,
      onclick: () => this.on.choose(p.number), onkeydown: (e) => e.key === " " && (e.preventDefault(), this.on.choose(p.number)) },
    svg("circle", { cx: x, cy: y, r: radius, fill: p.colour, "stroke-width": radius / 9 }),
    svg("text", { x, y, fill: p.ink, "font-size": radius * 1.15, text: p.doubt ? `${p.number}?` : p.number }));
    group.append(svg("title", { text: label }));
    this.linked(group, { person: p.number });
    return group;
  }

  pairs(unit, many, taken, heads, bounds) {
    const people = this.fields.people;
    const known = this.fields.pairs.filter((p) => p.distance_m !== null);
    const drawn = known.filter((p) => this.state.allPairs || p.nearest);
    const spare = known.length <= MOST_SPARE_PAIRS ? known.filter((p) => !drawn.includes(p)) : [];
    const size = (many ? 11 : 13) * unit;
    const items = drawn.map((p) => {
      const text = pairText(p);
      return { pair: p, text, from: people[p.a].anchor, to: people[p.b].anchor, w: text.length * size * 0.56 + size * 0.7, h: size * 1.5 };
    });
    const avoid = heads.map(([x, y, r]) => ({ box: [x - r * 0.8, y - r * 0.8, x + r * 0.8, y + r * 0.8], cost: HEAD_COST }));
    if (!many) avoid.push(...people.flatMap((p) => this.limbs(p)).map((box) => ({ box, cost: BODY_COST })));
    const centres = place(items, taken, avoid, bounds);
    const nodes = [...spare.map((p) => this.line(p, unit, "spare")), ...drawn.map((p) => this.line(p, unit, ""))];
    items.forEach((item, i) => centres[i] && nodes.push(this.tag(item, centres[i], size, unit)));
    return nodes;
  }

  // The boxes of a person's limbs and trunk, which labels should leave visible.
  limbs(p) {
    const margin = LIMB * (p.head?.[2] ?? 0);
    const around = (xs, ys) => [Math.min(...xs) - margin, Math.min(...ys) - margin, Math.max(...xs) + margin, Math.max(...ys) + margin];
    const trunk = TRUNK.map((name) => p.keypoints[this.fields.joints.indexOf(name)]).filter(Boolean);
    const boxes = p.bones.map(([x1, y1, x2, y2]) => around([x1, x2], [y1, y2]));
    return trunk.length > 2 ? [...boxes, around(trunk.map((k) => k[0]), trunk.map((k) => k[1]))] : boxes;
  }

  line(p, unit, kind) {
    const [x1, y1] = this.fields.people[p.a].anchor;
    const [x2, y2] = this.fields.people[p.b].anchor;
    const group = svg("g", { class: `pairline ${kind}`, "data-pair": `${p.a}-${p.b}`, visibility: kind ? "hidden" : null },
      svg("line", { class: "under", x1, y1, x2, y2, "stroke-width": 5 * unit }),
      svg("line", { class: "edge", x1, y1, x2, y2, "stroke-width": 3.6 * unit }),
      svg("line", { class: "over", x1, y1, x2, y2, stroke: p.colour, "stroke-width": 2.2 * unit, "stroke-dasharray": p.vague ? `${6 * unit} ${4 * unit}` : null }),
      !kind && svg("line", { class: "hit", x1, y1, x2, y2, "stroke-width": 10 * unit }));
    this.linked(group, { pair: `${p.a}-${p.b}` });
    return group;
  }

  tag({ pair, text, from, to, w, h }, [x, y], size, unit) {
    const way = [to[0] - from[0], to[1] - from[1]];
    const share = ((x - from[0]) * way[0] + (y - from[1]) * way[1]) / Math.max(way[0] ** 2 + way[1] ** 2, 1e-9);
    const t = Math.min(Math.max(share, 0.15), 0.85);
    const foot = [from[0] + t * way[0], from[1] + t * way[1]];
    const away = Math.hypot(foot[0] - x, foot[1] - y) > h * 0.75;
    const group = svg("g", { class: "tag", "data-pair": `${pair.a}-${pair.b}` },
      away && svg("line", { x1: x, y1: y, x2: foot[0], y2: foot[1], stroke: "#fff", "stroke-width": 1.4 * unit, "stroke-dasharray": `${3 * unit} ${2 * unit}` }),
      svg("rect", { x: x - w / 2, y: y - h / 2, width: w, height: h, rx: h / 4 }),
      svg("text", { x, y, "font-size": size, text }));
    this.linked(group, { pair: `${pair.a}-${pair.b}` });
    return group;
  }

  linked(group, what) {
    group.addEventListener("pointerenter", () => this.on.light(what));
    group.addEventListener("pointerleave", () => this.on.light({}));
  }

  clicks(unit) {
    const { adding, cursor } = this.state;
    const marks = Object.values(adding?.joints ?? {}).map(([cx, cy]) =>
      svg("circle", { class: "clicked", cx, cy, r: 5 * unit, "stroke-width": 2 * unit }));
    if (cursor) {
      const [x, y] = cursor;
      for (const [dx, dy] of [[16, 0], [0, 16]]) {
        marks.push(svg("line", { x1: x - dx * unit, y1: y - dy * unit, x2: x + dx * unit, y2: y + dy * unit, stroke: "#fff", "stroke-width": 2 * unit }));
      }
    }
    return marks;
  }
}
