// Questions in a dialog: focal length, note, reason, and the list of keys.

import { html } from "./elements.js";
import { equivalentOf, NotANumber, typedNumber, USUAL_35MM } from "./numbers.js";

const KEYS = [
  ["→ or J", "next photo"], ["← or K", "previous photo"], ["Enter", "accept, next photo"], ["G", "back to the gallery"],
  ["0, 1, 2 ...", "choose that person; 1 and 2 in quick succession: person 12"], ["] and [", "choose the next, previous person"], ["X or Delete", "remove the chosen person"], ["A", "add a missed person"],
  ["O", "chosen person is not on the same floor"], ["B", "body size of the chosen person: child, adult or as in the run"], [".", "choose a joint to move by arrow keys"], ["Shift + arrow", "move it ten times as far"],
  ["F", "set the focal length"], ["E", "exclude the photo, or count it again"], ["N", "write a note"], ["U", "undo your last change here"],
  ["C", "where the camera is, from points of the floor"], ["P", "all pairs, or nearest neighbours"], ["H", "hide what is drawn on the photo"], ["+ and -", "zoom; R shows the whole photo"], ["Esc", "cancel"],
];

// Resolves to what `read` makes of the form, or to null where the dialog was closed. Enter submits, Shift+Enter begins a new line.
export function ask(title, body, read, action = "Save") {
  const dialog = document.getElementById("dialog");
  return new Promise((resolve) => {
    const form = html("form", { method: "dialog" }, body, html("div", { class: "row" },
      html("button", { type: "button", onclick: () => dialog.close(), text: "Cancel" }),
      html("button", { type: "submit", class: "first", text: action })));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const answer = read(form);
      if (answer === null) return;
      resolve(answer);
      dialog.close();
    });
    form.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" || event.target.tagName !== "TEXTAREA" || event.shiftKey || event.isComposing) return;
      event.preventDefault();
      form.requestSubmit();
    });
    dialog.replaceChildren(html("h2", { id: "dialog-title", text: title }), form);
    dialog.addEventListener("close", () => resolve(null), { once: true });
    dialog.showModal();
  });
}

export function showHelp() {
  const dialog = document.getElementById("dialog");
  dialog.replaceChildren(
    html("h2", { id: "dialog-title", text: "Keys" }),
    html("dl", { class: "keys" }, KEYS.flatMap(([key, text]) => [html("dt", {}, html("kbd", { text: key })), html("dd", { text })])),
    html("p", { class: "hint", text: "Drag a joint to move it. Drag beside people to move a zoomed photo, double-click to see all of it." }),
    html("div", { class: "row" }, html("button", { type: "button", class: "first", onclick: () => dialog.close(), text: "Close" })));
  dialog.showModal();
}

// What a focal length is also stated for: the photo alone, or others that share its camera or its folder.
function scopes({ camera, folder }) {
  const choices = [
    ["photo", "this photo only"],
    camera && ["camera", `and the other ${camera} of the same camera`],
    folder && ["folder", `and the other ${folder} in the same folder`],
  ].filter(Boolean);
  if (choices.length === 1) return null;
  return html("fieldset", {}, html("legend", { text: "Applies to" }), choices.map(([value, text], k) => html("label", { class: "choice" },
    html("input", { type: "radio", name: "scope", value, checked: k === 0 }), text)));
}

// Resolves to {value, scope}: what is stated, and for which photos ("photo", "camera" or "folder").
export function askFocal({ camera, width, height, others }) {
  const number = (name, label, unit) => html("label", {}, label,
    html("span", {}, html("input", { type: "text", inputmode: "decimal", autocomplete: "off", name, id: `focal-${name}`, "aria-label": `${label}, ${unit}` }), ` ${unit}`));
  const problem = html("p", { role: "alert", class: "hint", text: "Fill in one of these. 50,5 and 50.5 are the same." });
  const body = [
    html("p", { class: "hint", text: `Now: ${camera.known ? camera.text : "unknown"}` }),
    html("fieldset", {}, html("legend", { text: "35 mm equivalent" }), number("focal_35mm", "Focal length", "mm")),
    html("fieldset", {}, html("legend", { text: "Lens and sensor" }), number("focal_mm", "Focal length", "mm"),
      number("sensor_width", "Sensor's long side", "mm"), number("sensor_height", "Sensor's short side", "mm")),
    html("fieldset", {}, html("legend", { text: "In pixels of the full-size photo" }), number("focal_px", "Focal length", "px")),
    scopes(others),
    problem,
  ];
  let asked = null;
  return ask("Set the focal length", body, (form) => {
    try {
      const value = readFocal((name) => typedNumber(form.elements[name].value));
      const scope = form.elements.scope?.value ?? "photo";
      if (scope !== "photo" && "focal_px" in value) throw new NotANumber("Pixels hold for this photo only, since photos differ in size: fill in the 35 mm equivalent.");
      const equivalent = equivalentOf(value, width, height);
      const unusual = equivalent < USUAL_35MM[0] || equivalent > USUAL_35MM[1];
      if (unusual && asked !== JSON.stringify(value)) {
        asked = JSON.stringify(value);
        throw new NotANumber(`That is a 35 mm equivalent of ${Number(equivalent.toPrecision(3))} mm; lenses for photos of people have ${USUAL_35MM.join(" to ")} mm. Save again if it is right.`);
      }
      return { value, scope };
    } catch (error) {
      if (!(error instanceof NotANumber)) throw error;
      problem.textContent = error.message;
      problem.classList.add("problem");
      return null;
    }
  });
}

function readFocal(typed) {
  const stated = ["focal_35mm", "focal_mm", "focal_px"].filter((name) => typed(name) !== null);
  if (stated.length !== 1) throw new NotANumber(stated.length ? "Fill in only one focal length." : "Fill in one focal length.");
  const [name] = stated;
  if (name !== "focal_mm") return { [name]: typed(name) };
  const sensor_mm = [typed("sensor_width"), typed("sensor_height")];
  if (sensor_mm.includes(null)) throw new NotANumber("A focal length in millimetres needs the sensor's two sides.");
  return { focal_mm: typed(name), sensor_mm };
}

const SIZE_CHOICES = [["children", "Child", "c"], ["adults", "Adult", "a"], [null, "As in the run", "r"]];

// Resolves to {size}: "children", "adults" or null for the run's own setting; each has a key of its own.
export function askSize(person, now) {
  const dialog = document.getElementById("dialog");
  return new Promise((resolve) => {
    const take = (size) => { resolve({ size }); dialog.close(); };
    const buttons = SIZE_CHOICES.map(([size, text, key]) => html("button", { type: "button", "data-size": key, "aria-pressed": String(size === now), "aria-keyshortcuts": key.toUpperCase(),
      onclick: () => take(size) }, `${text} `, html("kbd", { text: key.toUpperCase() })));
    const pressed = (event) => {
      const found = SIZE_CHOICES.find(([, , key]) => key === event.key.toLowerCase());
      if (!found || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation(); // the page has keys of its own
      take(found[0]);
    };
    dialog.replaceChildren(html("h2", { id: "dialog-title", text: `Body size of person ${person}` }),
      html("p", { class: "hint", text: "Which body lengths to expect. State them only where you are sure: a wrong size is worse than none." }),
      html("div", { class: "row choices" }, buttons),
      html("div", { class: "row" }, html("button", { type: "button", onclick: () => dialog.close(), text: "Cancel" })));
    dialog.addEventListener("keydown", pressed);
    dialog.addEventListener("close", () => { dialog.removeEventListener("keydown", pressed); resolve(null); }, { once: true });
    dialog.showModal();
    buttons[SIZE_CHOICES.findIndex(([size]) => size === now)].focus();
  });
}

export function askText(title, label, text, action) {
  const area = html("textarea", { name: "text", id: "dialog-text", maxlength: 10000 });
  area.value = text;
  return ask(title, [html("label", { for: "dialog-text", text: label }), area, html("p", { class: "hint", text: "Enter saves, Shift+Enter begins a new line." })], () => area.value.trim(), action);
}
