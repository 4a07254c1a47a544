// A photo in an SVG, in pixels of the full-size photo, that can be zoomed and moved; what lies on it is `things`.

import { svg } from "./elements.js";

export class ZoomedPhoto {
  // Events passed to `on`: failed(). Subclasses have draw(), and `grabs(event)`, which says what does not start a move.
  constructor(canvas, label, on) {
    this.on = on;
    this.things = svg("g");
    this.image = svg("image", { x: 0, y: 0 });
    this.image.addEventListener("error", () => on.failed());
    this.root = svg("svg", { role: "group", "aria-label": label }, this.image, this.things);
    canvas.append(this.root);
    this.observer = new ResizeObserver(() => this.fields && this.draw());
    this.observer.observe(canvas);
    this.root.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    this.root.addEventListener("pointerdown", (event) => this.pressed(event));
    this.root.addEventListener("dblclick", () => this.reset());
  }

  close() {
    this.observer.disconnect();
  }

  // Another photo of `fields.width` x `fields.height`; `address(size)` is that of its picture, null for none.
  open(fields, address) {
    const wide = this.root.clientWidth * (window.devicePixelRatio || 1) > 1700;
    this.image.setAttribute("width", fields.width);
    this.image.setAttribute("height", fields.height);
    if (address === null) this.on.failed();
    else this.image.setAttribute("href", address(wide ? 3200 : 1600));
    this.reset();
  }

  reset() {
    this.box = [0, 0, this.fields.width || 1, this.fields.height || 1];
    this.draw();
  }

  // Full-size pixels in one pixel of the screen.
  get unit() {
    return Math.max(this.box[2] / (this.root.clientWidth || 1), this.box[3] / (this.root.clientHeight || 1));
  }

  at(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.root.getScreenCTM().inverse());
    return [point.x, point.y];
  }

  zoom(factor, [x, y] = [this.box[0] + this.box[2] / 2, this.box[1] + this.box[3] / 2]) {
    const { width, height } = this.fields;
    const w = Math.min(width, Math.max(width / 40, this.box[2] * factor));
    const scale = w / this.box[2];
    const h = this.box[3] * scale;
    this.box = [
      Math.min(Math.max(x - (x - this.box[0]) * scale, 0), width - w),
      Math.min(Math.max(y - (y - this.box[1]) * scale, 0), height - h), w, h,
    ];
    this.draw();
  }

  wheel(event) {
    event.preventDefault();
    this.zoom(event.deltaY > 0 ? 1.2 : 1 / 1.2, this.at(event));
  }

  pan(event) {
    const [x, y] = this.at(event);
    this.follow(event, (e) => {
      const now = this.at(e);
      const { width, height } = this.fields;
      this.box[0] = Math.min(Math.max(this.box[0] + x - now[0], 0), width - this.box[2]);
      this.box[1] = Math.min(Math.max(this.box[1] + y - now[1], 0), height - this.box[3]);
      this.root.setAttribute("viewBox", this.box.join(" "));
    }, () => this.draw());
  }

  follow(event, move, done) {
    const from = [event.clientX, event.clientY];
    let moving = false;
    const moved = (e) => {
      moving ||= Math.hypot(e.clientX - from[0], e.clientY - from[1]) > 3;
      if (moving) move(e);
    };
    const ended = (e) => {
      window.removeEventListener("pointermove", moved);
      window.removeEventListener("pointerup", ended);
      if (moving || this.grabs(event)) done(e);
    };
    window.addEventListener("pointermove", moved);
    window.addEventListener("pointerup", ended);
  }
}
