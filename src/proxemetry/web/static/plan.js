// The view from above, in metres: the camera looks up the page.

import { metres, shortPairText, svg } from "./elements.js";
import { place } from "./placement.js";

const STEPS = [1, 2, 5, 10, 20, 50, 100, 200, 500];
const CAPTION_PX = 26; // the caption lies here: no number under it

export class Plan {
  constructor(host, on) {
    this.host = host;
    this.on = on;
    this.observer = new ResizeObserver(() => this.fields && this.draw());
    this.observer.observe(host);
  }

  close() {
    this.observer.disconnect();
  }

  show(fields, state) {
    this.fields = fields;
    this.state = state;
    this.draw();
  }

  draw() {
    const [width, height] = [this.host.clientWidth || 300, this.host.clientHeight || 240];
    const placed = this.fields.people.filter((p) => p.placed && p.ground);
    this.host.replaceChildren();
    const caption = document.createElement("p");
    caption.className = "scale";
    this.host.append(caption);
    if (!placed.length) {
      caption.textContent = this.fields.status === "excluded" ? "The photo is excluded." : this.fields.people.length ? "Nobody could be placed." : "Nobody was found.";
      return;
    }
    const limits = this.limits(placed, width, height);
    const [x0, y0, scale] = limits;
    const at = ([x, y]) => [(x - x0) * scale, height - (y - y0) * scale];
    const step = STEPS.find((s) => Math.max(width, height) / scale / s <= 24) ?? 500;
    caption.textContent = `View from above, grid ${step} m; shapes: where each person stands (90 %)`;
    const root = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": this.words(placed) },
      this.grid(limits, width, height, step), this.camera(at, scale, width, height));
    const regions = placed.map((p) => this.region(p, at));
    const known = this.fields.pairs.filter((p) => p.distance_m !== null);
    const lines = known.map((p) => this.line(p, at)).filter(Boolean);
    const badges = placed.map((p) => this.badge(p, at(p.ground), placed.length > 14 ? 8 : 10));
    root.append(...regions, ...lines, ...badges, ...this.labels(known, placed, at, width, height));
    this.host.append(root);
  }

  words(placed) {
    const where = placed.map((p) => `person ${p.number} ${metres(p.ground[1])} ahead`);
    return `View from above: ${where.join(", ")}`;
  }

  limits(placed, width, height) {
    let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
    const spread = Math.max(2, ...["0", "1"].map((k) => Math.max(...placed.map((p) => p.ground[k])) - Math.min(...placed.map((p) => p.ground[k]))));
    for (const { ground: [x, y], region } of placed) {
      const corners = region ?? [[x, y]];
      const within = (k, middle) => corners.map((corner) => Math.min(Math.max(corner[k], middle - spread), middle + spread));
      const [across, ahead] = [within(0, x), within(1, y)];
      [left, right] = [Math.min(left, ...across.map((v) => v - 0.6)), Math.max(right, ...across.map((v) => v + 0.6))];
      [low, high] = [Math.min(low, ...ahead.map((v) => v - 0.6)), Math.max(high, ...ahead.map((v) => v + 0.6))];
    }
    if (low < 1.5 * (high - low) + 2) {
      [left, right, low] = [Math.min(left, -0.6), Math.max(right, 0.6), Math.min(low, -0.6)];
    }
    const scale = 0.94 * Math.min(width / (right - left), height / (high - low));
    return [(left + right) / 2 - width / scale / 2, (low + high) / 2 - height / scale / 2, scale];
  }

  grid([x0, y0, scale], width, height, step) {
    const group = svg("g", { "aria-hidden": "true" });
    for (let x = Math.ceil(x0 / step) * step; (x - x0) * scale < width; x += step) {
      const u = (x - x0) * scale;
      group.append(svg("line", { class: "grid", x1: u, y1: 0, x2: u, y2: height }), u < 18 ? "" : svg("text", { class: "gridtext", x: u + 2, y: height - 3, text: x }));
    }
    for (let y = Math.ceil(y0 / step) * step; (y - y0) * scale < height; y += step) {
      const v = height - (y - y0) * scale;
      group.append(svg("line", { class: "grid", x1: 0, y1: v, x2: width, y2: v }), v < CAPTION_PX ? "" : svg("text", { class: "gridtext", x: 2, y: v - 2, text: y }));
    }
    return group;
  }

  camera(at, scale, width, height) {
    const view = this.fields.camera.view;
    if (!view) return null;
    const [u, v] = at([0, 0]);
    const far = (width + height + Math.abs(u) + Math.abs(v)) / scale;
    const edge = ([x, y]) => at([x * far, y * far]).join(",");
    return svg("g", {}, svg("polygon", { class: "wedge", points: `${u},${v} ${edge(view[0])} ${edge(view[1])}` }),
      svg("path", { class: "camera", d: `M${u - 6} ${v + 5}L${u} ${v - 7}L${u + 6} ${v + 5}Z` }));
  }

  region(p, at) {
    const [u, v] = at(p.ground);
    const group = svg("g", { "data-person": p.number });
    if (p.region) {
      group.append(svg("polygon", { class: "region", points: p.region.map((corner) => at(corner).join(",")).join(" "), fill: p.colour,
        onclick: () => this.on.choose(p.number) }));
    }
    if (p.heading !== null) {
      const [x, y] = at([p.ground[0] + 0.8 * Math.sin(p.heading), p.ground[1] - 0.8 * Math.cos(p.heading)]);
      const turn = Math.atan2(y - v, x - u);
      const wing = (d) => `${x - 6 * Math.cos(turn + d)} ${y - 6 * Math.sin(turn + d)}`;
      group.append(svg("path", { class: "heading", d: `M${u} ${v}L${x} ${y}M${wing(0.5)}L${x} ${y}L${wing(-0.5)}` }));
    }
    this.linked(group, { person: p.number });
    return group;
  }

  badge(p, [u, v], radius) {
    const group = svg("g", { class: "badge", "data-person": p.number, onclick: () => this.on.choose(p.number) },
      svg("circle", { cx: u, cy: v, r: radius, fill: p.colour }), svg("text", { x: u, y: v, fill: p.ink, "font-size": radius * 1.15, text: p.number }));
    this.linked(group, { person: p.number });
    return group;
  }

  line(p, at) {
    const [a, b] = [this.fields.people[p.a].ground, this.fields.people[p.b].ground];
    if (!a || !b) return null;
    const [[x1, y1], [x2, y2]] = [at(a), at(b)];
    const shown = this.state.allPairs || p.nearest;
    return svg("line", { class: `pair${shown ? "" : " spare"}${p.vague ? " vague" : ""}`, x1, y1, x2, y2, stroke: p.colour, "data-pair": `${p.a}-${p.b}`, visibility: shown ? null : "hidden" });
  }

  labels(known, placed, at, width, height) {
    const shown = known.filter((p) => p.nearest && this.fields.people[p.a].ground && this.fields.people[p.b].ground);
    const items = shown.map((p) => {
      const text = shortPairText(p);
      return { pair: p, text, from: at(this.fields.people[p.a].ground), to: at(this.fields.people[p.b].ground), w: text.length * 6.2 + 8, h: 16 };
    });
    const taken = placed.map((p) => { const [u, v] = at(p.ground); return [u - 11, v - 11, u + 11, v + 11]; });
    const centres = place(items, taken, [], [0, 0, width, height]);
    return items.map(({ pair, text, w, h }, i) => {
      if (!centres[i]) return null;
      const [x, y] = centres[i];
      const group = svg("g", { class: "tag", "data-pair": `${pair.a}-${pair.b}` },
        svg("rect", { x: x - w / 2, y: y - h / 2, width: w, height: h, rx: 4 }), svg("text", { x, y, "font-size": 11, text }));
      this.linked(group, { pair: `${pair.a}-${pair.b}` });
      return group;
    }).filter(Boolean);
  }

  linked(group, what) {
    group.addEventListener("pointerenter", () => this.on.light(what));
    group.addEventListener("pointerleave", () => this.on.light({}));
  }
}
