// The picture with the floor drawn on it: metre grid, horizon, clicked points and lines, and where points should be.

import * as api from "./api.js";
import { svg } from "./elements.js";
import { ZoomedPhoto } from "./zoom.js";

const letter = (k) => String.fromCharCode(65 + (k % 26));

export class CalibrateCanvas extends ZoomedPhoto {
  // Events passed to `on`: clicked([x, y]), choose(what), moved(what, [x, y]), failed(). `what` is ["point", k] or ["length", k, end].
  constructor(canvas, on) {
    super(canvas, "Picture with the floor's grid", on);
    this.misses = new Map();
  }

  show(fields, marks, state) {
    const other = this.fields?.id !== fields.id;
    Object.assign(this, { fields, marks, state });
    if (other) this.open(fields, (size) => api.picture(fields.id, size));
    else this.draw();
  }

  grabs = (event) => event.target.closest?.(".mark");

  pressed(event) {
    if (event.button !== 0) return;
    const mark = this.grabs(event);
    // In the mode of lines a click on a mark is an end there.
    if (mark) return this.drag(event, mark);
    const from = [event.clientX, event.clientY];
    // A click marks, a drag moves the zoomed picture.
    window.addEventListener("pointerup", (e) => {
      if (Math.hypot(e.clientX - from[0], e.clientY - from[1]) <= 3) this.on.clicked(this.inside(this.at(e)));
    }, { once: true });
    this.pan(event);
  }

  inside([x, y]) {
    const { width, height } = this.fields;
    return [Math.min(Math.max(x, 0), width), Math.min(Math.max(y, 0), height)].map((v) => Math.round(v * 10) / 10);
  }

  drag(event, mark) {
    const what = JSON.parse(mark.dataset.what);
    let to = null;
    this.follow(event, (e) => {
      to = this.inside(this.at(e));
      mark.setAttribute("transform", `translate(${to[0] - Number(mark.dataset.x)} ${to[1] - Number(mark.dataset.y)})`);
    }, () => {
      if (to) this.on.moved(what, to);
      else if (this.state.mode === "length") this.on.clicked([Number(mark.dataset.x), Number(mark.dataset.y)]);
      else this.on.choose(what);
    });
  }

  draw() {
    this.root.setAttribute("viewBox", this.box.join(" "));
    const { unit } = this;
    this.things.replaceChildren(
      ...(this.state.hidden ? [] : this.floor(unit)),
      ...this.marks.lengths.flatMap((line, k) => this.line(line, k, unit)),
      ...this.marks.points.flatMap((point, k) => this.point(point, k, unit)),
      ...this.crosshair(unit));
  }

  floor(unit) {
    const { found } = this.state;
    if (found?.status !== "found") return [];
    const path = ({ line }) => line.map(([u, v], k) => `${k ? "L" : "M"}${u} ${v}`).join("");
    const of = (tenth) => found.grid.filter((g) => g.tenth === tenth).map(path).join("");
    const drawn = [["fine", of(false), 1], ["tenth", of(true), 2]].flatMap(([kind, d, wide]) => [
      svg("path", { class: "floor under", d, "stroke-width": (wide + 1.2) * unit }),
      svg("path", { class: `floor ${kind}`, d, "stroke-width": wide * unit })]);
    if (found.horizon) {
      const [[x1, y1], [x2, y2]] = found.horizon;
      drawn.push(
        svg("line", { class: "floor under", x1, y1, x2, y2, "stroke-width": 3.4 * unit }),
        svg("line", { class: "floor horizon", x1, y1, x2, y2, "stroke-width": 2 * unit, "stroke-dasharray": `${10 * unit} ${5 * unit}` }),
        svg("text", { class: "horizontext", x: 8 * unit, y: Math.max(y1 - 6 * unit, 14 * unit), "font-size": 13 * unit, "stroke-width": 3 * unit, text: y1 < 0 ? "horizon: above the picture" : "horizon" }));
    }
    return drawn;
  }

  mark(what, [x, y], label, unit, kind) {
    const chosen = this.state.chosen?.join() === what.join() || (what[0] === "length" && this.state.chosen?.slice(0, 2).join() === what.slice(0, 2).join());
    const group = svg("g", { class: `mark ${kind}${chosen ? " chosen" : ""}`, role: "button", tabindex: 0, "aria-label": label, "data-x": x, "data-y": y },
      svg("circle", { class: "hit", cx: x, cy: y, r: 13 * unit }),
      svg("circle", { class: "ring under", cx: x, cy: y, r: 7 * unit, "stroke-width": 4 * unit }),
      svg("circle", { class: "ring", cx: x, cy: y, r: 7 * unit, "stroke-width": 2 * unit }),
      svg("circle", { class: "middle", cx: x, cy: y, r: 1.4 * unit }));
    group.dataset.what = JSON.stringify(what);
    group.addEventListener("keydown", (e) => {
      if (e.key !== " " && e.key !== "Enter") return;
      e.preventDefault();
      e.stopPropagation();
      this.on.choose(what);
    });
    return group;
  }

  number(text, [x, y], unit) {
    return svg("text", { class: "marktext", x: x + 10 * unit, y: y - 9 * unit, "font-size": 14 * unit, "stroke-width": 3.4 * unit, text });
  }

  point(point, k, unit) {
    const miss = this.misses.get(point);
    const nodes = [];
    if (miss?.seen?.every((v) => v !== null) && !this.state.hidden) {
      const [x, y] = miss.seen;
      nodes.push(
        svg("line", { class: `miss${miss.wrong ? " wrong" : ""}`, x1: point.at[0], y1: point.at[1], x2: x, y2: y, "stroke-width": 2 * unit }),
        svg("path", { class: `miss${miss.wrong ? " wrong" : ""}`, d: `M${x - 5 * unit} ${y}h${10 * unit}M${x} ${y - 5 * unit}v${10 * unit}`, "stroke-width": 2 * unit }));
    }
    return [...nodes, this.mark(["point", k], point.at, `Point ${k + 1}`, unit, miss?.wrong ? "wrong" : "good"), this.number(String(k + 1), point.at, unit)];
  }

  line({ from, to, metres }, k, unit) {
    const ends = { x1: from[0], y1: from[1], x2: to[0], y2: to[1] };
    const middle = [(from[0] + to[0]) / 2, (from[1] + to[1]) / 2];
    return [
      svg("line", { class: "taped under", ...ends, "stroke-width": 5 * unit }), svg("line", { class: "taped", ...ends, "stroke-width": 2.4 * unit }),
      this.mark(["length", k, "from"], from, `Line ${letter(k)}, one end`, unit, "good"), this.mark(["length", k, "to"], to, `Line ${letter(k)}, other end`, unit, "good"),
      this.number(metres === null ? letter(k) : `${letter(k)}: ${metres} m`, middle, unit)];
  }

  crosshair(unit) {
    const { cursor, begun } = this.state;
    const nodes = begun ? [svg("circle", { class: "ring", cx: begun[0], cy: begun[1], r: 7 * unit, "stroke-width": 2 * unit })] : [];
    if (!cursor) return nodes;
    const [x, y] = cursor;
    for (const kind of ["under", "over"]) nodes.push(svg("path", { class: `cross ${kind}`, d: `M${x - 16 * unit} ${y}h${32 * unit}M${x} ${y - 16 * unit}v${32 * unit}`, "stroke-width": (kind === "under" ? 4 : 2) * unit }));
    return nodes;
  }
}
