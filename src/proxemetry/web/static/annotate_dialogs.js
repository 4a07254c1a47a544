// Questions in a dialog: who it is, shoot and camera, lens, and the list of keys.

import { ask } from "./dialogs.js";
import { html } from "./elements.js";
import { equivalentOf, NotANumber, typedNumber, USUAL_35MM } from "./numbers.js";

const KEYS = [
  ["E, S, T, H", "eyes, shoulders, torso, head of the chosen person: then click, or arrow keys and Space"],
  ["V or Delete", "the chosen point is not visible, or outside the picture"],
  ["arrow keys", "move the chosen point; with Shift ten times as far"],
  ["0, 1, 2 ...", "name the chosen person P0, P1 ...; 1 and 2 in quick succession: P12"],
  ["N", "name the chosen person in a dialog"], ["M", "names as on the photo before, from left to right"],
  ["A", "add a person"], ["X", "remove the chosen person"],
  ["] and [", "choose the next, previous person"], ["Z", "zoom to the chosen person, and back"],
  ["+ and -", "zoom; R shows the whole photo"], ["O", "shoot and camera of this photo"], ["C", "lens of this photo"],
  ["I", "leave this photo out, or take it in again"], ["Enter", "done, next photo"],
  ["→ or J", "next photo"], ["← or K", "photo before"],
  ["U, Ctrl+Z", "undo"], ["Y, Ctrl+Shift+Z", "redo"], ["G", "all photos"], ["L", "places"], ["Esc", "put down point, then person"],
];

export function showHelp() {
  const dialog = document.getElementById("dialog");
  dialog.replaceChildren(
    html("h2", { id: "dialog-title", text: "Keys" }),
    html("dl", { class: "keys" }, KEYS.flatMap(([key, text]) => [html("dt", {}, html("kbd", { text: key })), html("dd", { text })])),
    html("p", { class: "hint", text: "Drag a point to move it. Drag beside people to move a zoomed photo, double-click to see all of it. Everything is kept at once." }),
    html("div", { class: "row" }, html("button", { type: "button", class: "first", onclick: () => dialog.close(), text: "Close" })));
  dialog.showModal();
}

const field = (name, label, value, options = {}) => html("label", {}, label,
  html("input", { type: "text", name, id: `dialog-${name}`, value: value ?? "", autocomplete: "off", maxlength: 100, ...options }));

function refusing(problem, read) {
  return (form) => {
    try {
      return read(form);
    } catch (error) {
      if (!(error instanceof NotANumber)) throw error;
      problem.textContent = error.message;
      problem.classList.add("problem");
      return null;
    }
  };
}

function tagNumber(text, letter) {
  const found = new RegExp(`^${letter}?(\\d{1,3})$`, "i").exec(text.trim());
  if (!found) throw new NotANumber(`Write ${letter} and a number up to 999, as ${letter}2.`);
  return `${letter}${Number(found[1])}`;
}

// Resolves to {tag, name}: tag null for nobody in particular.
export function askName(person, names, seen) {
  const problem = html("p", { class: "hint", role: "alert", text: "The same person has the same number in every photo of a shoot. The name is for you alone; it is not in the label files. Empty: unnamed." });
  const list = html("datalist", { id: "dialog-tags" }, seen.map((tag) => html("option", { value: tag, label: names[tag] ?? "" })));
  const tag = field("tag", "Number", person.tag, { list: "dialog-tags" });
  const name = field("name", "Name", person.tag ? names[person.tag] : "");
  tag.querySelector("input").addEventListener("input", (event) => {
    const known = names[event.target.value.trim().toUpperCase()];
    if (known) name.querySelector("input").value = known;
  });
  return ask("Who is it?", [tag, name, list, problem], refusing(problem, (form) => {
    const text = form.elements.tag.value.trim();
    return text === "" ? { tag: null, name: "" } : { tag: tagNumber(text, "P"), name: form.elements.name.value.trim() };
  }));
}

const SCOPES = { photo: () => "this photo only", camera: (n) => `all ${n} of this camera and lens`, folder: (n) => `all ${n} in its folder`, following: (n) => `this photo and all after it (${n})`, all: (n) => `all ${n} photos` };

// Of scopes with the same photos, the widest is shown.
function scopeChoice(counts) {
  const shown = Object.keys(SCOPES).filter((name, k, all) => k === 0 || (counts[name] > 1 && !all.slice(k + 1).some((other) => counts[other] === counts[name])));
  return html("fieldset", {}, html("legend", { text: "Applies to" }), shown.map((name, k) => html("label", { class: "choice" },
    html("input", { type: "radio", name: "scope", value: name, checked: k === 0 }), SCOPES[name](counts[name]))));
}

// Resolves to {shoot, camera, scope, shootName, cameraName}.
export function askPlace(fields, about) {
  const known = new Map(about.shoots.map((s) => [String(s.number), s]));
  const problem = html("p", { class: "hint", role: "alert", text: "A shoot is a set of photos during which nobody changed places. A camera number is a place where the camera stood." });
  const now = known.get(String(fields.shoot));
  const shoot = field("shoot", "Shoot number", fields.shoot, { inputmode: "numeric" });
  const name = field("shootName", "Name of the shoot", now?.name, { placeholder: "such as terrace, standing" });
  const camera = field("camera", "Camera place", fields.camera);
  const cameraName = field("cameraName", "Name of that place", now?.camera_names[fields.camera], { placeholder: "such as by the door" });
  shoot.querySelector("input").addEventListener("input", (event) => {
    const other = known.get(event.target.value.trim());
    if (other) name.querySelector("input").value = other.name;
  });
  return ask("Shoot and camera", [shoot, name, camera, cameraName, scopeChoice(fields.scopes), problem], refusing(problem, (form) => {
    const typed = form.elements.shoot.value.trim();
    if (!/^\d{1,3}$/.test(typed)) throw new NotANumber("The shoot is a number up to 999.");
    return { shoot: Number(typed), shootName: form.elements.shootName.value.trim(), camera: tagNumber(form.elements.camera.value, "C"), cameraName: form.elements.cameraName.value.trim(), scope: form.elements.scope.value };
  }));
}

export function lensText(lens) {
  if (lens === null) return "not recorded in the file";
  const focal = `${Number(lens.focal_mm.toPrecision(4))} mm`;
  return lens.equivalent ? `${focal} (35 mm equivalent)` : `${focal}, sensor ${lens.sensor_mm[0]} × ${lens.sensor_mm[1]} mm`;
}

// Resolves to {lens, scope}: lens {focal_35mm}, {focal_mm, sensor_mm}, or null for what the file says.
export function askLens(fields) {
  const shown = fields.lens ?? fields.file_lens;
  const problem = html("p", { class: "hint", role: "alert", text: "50,5 and 50.5 are the same. Empty everywhere: what the file says." });
  const number = (name, label, value, recorded = null) => field(name, label, value, { inputmode: "decimal", placeholder: recorded });
  const own = fields.lens;
  let asked = null;
  return ask("Camera and lens", [
    html("p", { class: "hint", text: `Camera: ${fields.device || "not named in the file"}. ${fields.file_lens ? `The file says: ${lensText(fields.file_lens)}.` : "The file records no lens."}` }),
    html("fieldset", {}, html("legend", { text: "Lens and sensor" }), number("focal_mm", "Focal length, mm", own && !own.equivalent ? own.focal_mm : "", fields.file_lens?.equivalent === false ? fields.file_lens.focal_mm : null),
      number("sensor_width", "Sensor's long side, mm", shown && !shown.equivalent ? shown.sensor_mm[0] : ""), number("sensor_height", "Sensor's short side, mm", shown && !shown.equivalent ? shown.sensor_mm[1] : "")),
    html("fieldset", {}, html("legend", { text: "Or" }), number("focal_35mm", "35 mm equivalent, mm", own?.equivalent ? own.focal_mm : "")),
    scopeChoice(fields.scopes), problem,
  ], refusing(problem, (form) => {
    const typed = (name) => typedNumber(form.elements[name].value);
    const scope = form.elements.scope.value;
    const [focal, equivalent] = [typed("focal_mm"), typed("focal_35mm")];
    if (focal === null && equivalent === null) return { lens: null, scope };
    if (focal !== null && equivalent !== null) throw new NotANumber("Fill in only one focal length.");
    const lens = focal === null ? { focal_35mm: equivalent } : { focal_mm: focal, sensor_mm: [typed("sensor_width"), typed("sensor_height")] };
    if (lens.sensor_mm?.includes(null)) throw new NotANumber("A focal length in millimetres needs the sensor's two sides.");
    const mm = equivalentOf(lens, fields.width, fields.height);
    if ((mm < USUAL_35MM[0] || mm > USUAL_35MM[1]) && asked !== JSON.stringify(lens)) {
      asked = JSON.stringify(lens);
      throw new NotANumber(`That is a 35 mm equivalent of ${Number(mm.toPrecision(3))} mm; lenses for photos of people have ${USUAL_35MM.join(" to ")} mm. Save again if it is right.`);
    }
    return { lens, scope };
  }));
}
