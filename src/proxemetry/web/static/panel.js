// The tables beside the photo: pairs, people, camera, and what was done by hand.

import { html, metres } from "./elements.js";

const TABS = { pairs: "Pairs", people: "People", camera: "Camera", history: "History" };
const ACTIONS = {
  remove_person: "removed a person", add_person: "added a person", move_joint: "moved a joint", set_camera: "set the focal length",
  off_floor: "floor of a person", body_size: "body size of a person", exclude: "photo counts or not", note: "note", checked: "accepted",
};
export const SIZES = { adults: "adult", children: "child" };

const ZONES = ["intimate", "personal", "social", "public"];
const likely = (shares) => shares === null ? null : ZONES.map((zone, k) => `${zone} ${Math.round(100 * shares[k])} %`).join(", ");

function swatch(colour) {
  const element = html("span", { class: "swatch" });
  element.style.background = colour;
  return element;
}

export class Panel {
  constructor(host, on) {
    this.host = host;
    this.on = on;
    this.tab = "pairs";
    this.only = ""; // pairs of people with one recorded attribute, as name=value; "" for all
  }

  show(fields) {
    this.fields = fields;
    const tabs = Object.entries(TABS).map(([name, text]) => {
      const count = name === "history" && fields.history.length ? ` (${fields.history.length})` : "";
      return html("button", { type: "button", role: "tab", id: `tab-${name}`, "aria-selected": String(name === this.tab), "aria-controls": "tab-panel",
        tabindex: name === this.tab ? 0 : -1, onclick: () => this.open(name), onkeydown: (e) => this.arrow(e, name), text: text + count });
    });
    this.host.replaceChildren(
      html("div", { class: "tabs", role: "tablist", "aria-label": "Details" }, tabs),
      html("div", { role: "tabpanel", id: "tab-panel", "aria-labelledby": `tab-${this.tab}` }, this[this.tab]()));
  }

  open(name) {
    this.tab = name;
    this.show(this.fields);
    this.on.drawn();
  }

  arrow(event, name) {
    const names = Object.keys(TABS);
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.stopPropagation();
    event.preventDefault();
    this.open(names[(names.indexOf(name) + step + names.length) % names.length]);
    document.getElementById(`tab-${this.tab}`).focus();
  }

  row(attributes, what, ...cells) {
    const row = html("tr", attributes, cells);
    row.addEventListener("pointerenter", () => this.on.light(what));
    row.addEventListener("pointerleave", () => this.on.light({}));
    return row;
  }

  dot(number) {
    const person = this.fields.people[number];
    const dot = html("span", { class: "dot", text: number });
    dot.style.background = person.colour;
    dot.style.color = person.ink;
    return dot;
  }

  pairs() {
    const { pairs, on_ground: ground } = this.fields;
    if (!pairs.length) return html("p", { class: "hint", text: this.fields.reason ?? "There is no pair of people." });
    if (pairs.every((p) => p.distance_m === null)) return html("p", { class: "hint", text: `No distances: ${this.fields.reason?.split("; ")[0] ?? "no person could be placed"}.` });
    const doubts = pairs.some((p) => p.vague) ? ". ?: too uncertain for one number, read the interval" : "";
    const meaning = `Between body centres, ${ground ? "along the ground" : "in space (gravity unknown)"}; 90 % intervals${doubts}`;
    const recorded = this.recorded();
    const only = recorded.includes(this.only) ? this.only : "";
    const counted = pairs.filter((p) => [p.a, p.b].every((k) => !only || this.isRecorded(k, only)));
    const rows = counted.map((p) => this.row({ "data-pair": `${p.a}-${p.b}` }, { pair: `${p.a}-${p.b}` },
      html("th", { scope: "row" }, this.dot(p.a), " – ", this.dot(p.b)),
      html("td", { class: "num", text: p.distance_m === null ? "unknown" : metres(p.distance_m, p.low_m, p.high_m).replace(/ \[.*/, p.vague ? " ?" : "") }),
      html("td", { class: "num", text: p.low_m === null ? "" : metres(p.distance_m, p.low_m, p.high_m).replace(/^.*\[(.*)\]$/, "$1") }),
      html("td", { title: likely(p.zones) }, p.zone && swatch(p.colour), p.zone ?? ""),
      html("td", { class: "num", text: p.group === null ? "" : p.group.toFixed(2) })));
    const filter = recorded.length > 0 && html("label", { class: "only" }, "Pairs of people recorded as ",
      html("select", { id: "only", onchange: (e) => { this.only = e.target.value; this.open("pairs"); document.getElementById("only").focus(); } },
        ["", ...recorded].map((text) => html("option", { value: text, selected: text === only ? "" : null, text: text || "anything" }))),
      only && ` ${counted.length} of ${pairs.length}`);
    return html("div", {}, filter, html("table", {}, html("caption", { class: "hint", text: meaning }),
      html("thead", {}, html("tr", {}, ["Pair", "Distance", "Interval, m", "Zone", "Group"].map((text, k) =>
        html("th", { scope: "col", class: [1, 2, 4].includes(k) ? "num" : null, text })))),
      html("tbody", {}, rows)));
  }

  isRecorded(number, text) {
    return Object.entries(this.fields.people[number].attributes).some(([name, value]) => `${name}=${value}` === text);
  }

  recorded() {
    const found = this.fields.people.flatMap((p) => Object.entries(p.attributes).map(([name, value]) => `${name}=${value}`));
    return [...new Set(found)].sort();
  }

  people() {
    if (!this.fields.people.length) return html("p", { class: "hint", text: this.fields.status === "excluded" ? "The photo is excluded." : "Nobody was found. Press A to add a person." });
    const doubtful = this.fields.people.some((p) => p.doubt);
    const rows = this.fields.people.map((p) => this.row({ "data-person": p.number }, { person: p.number },
      html("th", { scope: "row" }, html("button", { type: "button", class: "plain", "aria-label": `Choose person ${p.number}`, onclick: () => this.on.choose(p.number) }, this.dot(p.number))),
      html("td", { class: "num", text: p.ground ? metres(p.ground[1]) : "" }),
      html("td", { text: p.placed ? p.basis.replaceAll("+", ", ") : p.reason ?? "no place" }),
      html("td", { text: [SIZES[p.size] ?? p.size, p.off_floor && "off the floor",
        ...Object.entries(p.attributes).map(([name, value]) => `${name} ${value}`)].filter(Boolean).join(", ") }),
      html("td", { class: "num", text: p.score === null ? "" : p.score.toFixed(2) }),
      doubtful && html("td", { text: p.doubt })));
    return html("table", {},
      html("thead", {}, html("tr", {}, ["Person", "Ahead", "Placed by", "Stated", "Score", ...(doubtful ? ["Doubtful"] : [])].map((text, k) =>
        html("th", { scope: "col", class: [1, 4].includes(k) ? "num" : null, text })))),
      html("tbody", {}, rows));
  }

  camera() {
    const { camera, method, pose, about } = this.fields;
    const degrees = camera.pitch_deg === null ? null : `${camera.height_m} m above the floor, looking ${Math.abs(camera.pitch_deg)}° ${camera.pitch_deg < 0 ? "up" : "down"}`;
    const facts = [
      ["Focal length", camera.known ? camera.text.replace(/^focal length /, "") : `unknown: ${camera.reason ?? ""}`],
      ["Camera", degrees], ["Method", method], ["People found by", pose],
      ...["date", "city", "country", "source"].map((k) => [k[0].toUpperCase() + k.slice(1), about[k]]),
    ];
    return html("div", {},
      html("dl", {}, facts.filter(([, v]) => v).flatMap(([k, v]) => [html("dt", { text: k }), html("dd", { text: v })])),
      camera.flags.length > 0 && html("div", {}, html("strong", { text: "Doubtful" }), html("ul", {}, camera.flags.map((text) => html("li", { text })))),
      camera.candidates.length > 0 && html("table", {}, html("caption", { class: "hint", text: "Evidence on the focal length, with 90 % intervals" }),
        html("tbody", {}, camera.candidates.map((c) => html("tr", {}, html("td", { text: c.text }), html("td", { text: c.source }))))),
      html("p", {}, html("button", { type: "button", onclick: () => this.on.focal() }, "Set the focal length ", html("kbd", { text: "F" })), " ",
        html("button", { type: "button", id: "calibrate", onclick: () => this.on.calibrate() }, "Find the camera's place ", html("kbd", { text: "C" }))));
  }

  history() {
    const { history } = this.fields;
    if (!history.length) return html("p", { class: "hint", text: "Nothing was changed by hand. Every change goes into an append-only log; the photo is never written to." });
    return html("ul", {}, [...history].reverse().map((a) => html("li", {},
      html("strong", { text: ACTIONS[a.action] ?? a.action }),
      html("span", { text: detail(a) }),
      html("div", { class: "hint", text: `${a.who}, ${a.time.replace("T", " ").replace("+00:00", " UTC")}` }))));
  }
}

function detail(a) {
  const stated = { ...a };
  for (const name of ["number", "time", "who", "action"]) delete stated[name];
  if (a.action === "note") return `: ${a.text}`;
  if (a.action === "move_joint") return `: ${a.joint.replaceAll("_", " ")}${a.to ? "" : " taken away"}`;
  if (a.action === "body_size") return `: ${SIZES[a.body_size] ?? a.body_size ?? "as in the run"}`;
  if (a.action === "off_floor") return a.off_floor ? ": not on the shared floor" : ": on the shared floor";
  if (a.action === "exclude") return a.excluded ? `: excluded${a.reason ? `, ${a.reason}` : ""}` : ": counts again";
  const rest = Object.entries(stated).map(([k, v]) => `${k.replaceAll("_", " ")} ${v}`).join(", ");
  return rest ? `: ${rest}` : "";
}
