// A shoot's floor from above: people, cameras, and every tape with how far it is off.

import { called, colourOf } from "./annotate_names.js";
import { svg } from "./elements.js";

const STEPS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];

export class FloorPlan {
  constructor(host) {
    this.host = host;
    this.observer = new ResizeObserver(() => this.fields && this.draw());
    this.observer.observe(host);
  }

  close() {
    this.observer.disconnect();
  }

  show(fields, about) {
    Object.assign(this, { fields, about });
    this.draw();
  }

  draw() {
    const [width, height] = [this.host.clientWidth || 300, this.host.clientHeight || 260];
    const placed = this.fields.tags.filter((t) => t.place);
    if (!placed.length) {
      this.host.replaceChildren(Object.assign(document.createElement("p"), { className: "hint", textContent: "Nothing has a place yet." }));
      return;
    }
    const [xs, ys] = [0, 1].map((k) => placed.map((t) => t.place[k]));
    const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    const margin = 0.12 * Math.max(right - left, high - low, 1) + 0.3;
    const scale = Math.min(width / (right - left + 2 * margin), height / (high - low + 2 * margin));
    const [x0, y0] = [(left + right) / 2 - width / scale / 2, (low + high) / 2 - height / scale / 2];
    const at = ([x, y]) => [(x - x0) * scale, height - (y - y0) * scale];
    const by = new Map(placed.map((t) => [t.tag, t]));
    const words = placed.map((t) => `${t.tag} at ${t.place.map((v) => v.toFixed(1)).join(", ")}`).join("; ");
    const step = STEPS.find((s) => s * scale >= 44) ?? 1000;
    this.host.replaceChildren(svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": `From above, metres: ${words}` },
      this.grid(x0, y0, scale, step, width, height),
      ...this.fields.tapes.filter((t) => by.has(t.a) && by.has(t.b)).map((t) => this.tape(t, at(by.get(t.a).place), at(by.get(t.b).place))),
      ...placed.map((t) => this.mark(t, at(t.place)))));
  }

  grid(x0, y0, scale, step, width, height) {
    const group = svg("g", { "aria-hidden": "true" });
    for (let x = Math.ceil(x0 / step) * step; (x - x0) * scale < width; x += step) {
      const u = (x - x0) * scale;
      group.append(svg("line", { class: "grid", x1: u, y1: 0, x2: u, y2: height }), svg("text", { class: "gridtext", x: u + 3, y: height - 4, text: `${Number(x.toFixed(1))}` }));
    }
    for (let y = Math.ceil(y0 / step) * step; (y - y0) * scale < height; y += step) {
      const v = height - (y - y0) * scale;
      if (v < height - 14) group.append(svg("line", { class: "grid", x1: 0, y1: v, x2: width, y2: v }), svg("text", { class: "gridtext", x: 3, y: v - 3, text: `${Number(y.toFixed(1))} m` }));
    }
    return group;
  }

  tape(t, [x1, y1], [x2, y2]) {
    const bent = this.fields.tapes.some((other) => other.suspect);
    const kind = t.suspect ? "wrong" : !bent && t.checked && Math.abs(t.z ?? 0) > 2 ? "off" : "";
    return svg("line", { class: `tape ${kind}`, x1, y1, x2, y2 }, svg("title", { text: `${t.a} – ${t.b}: ${t.metres} m` }));
  }

  mark(t, [x, y]) {
    const camera = t.tag.startsWith("C");
    const { fill, ink } = camera ? { fill: "#1c2126", ink: "#ffffff" } : colourOf(t.tag, this.about.colours);
    const group = svg("g", { class: "mark" }, camera ? svg("rect", { x: x - 12, y: y - 9, width: 24, height: 18, rx: 4, fill }) : svg("circle", { cx: x, cy: y, r: 12, fill }),
      svg("text", { x, y, fill: ink, "font-size": 11, text: t.tag }));
    group.append(svg("title", { text: called(t.tag, { [t.tag]: t.name }) }));
    return group;
  }
}
