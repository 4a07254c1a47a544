// Questions in a dialog: focal length, note, reason, and the list of keys.

import { html } from "./elements.js";

const KEYS = [
  ["→ or J", "next photo"], ["← or K", "previous photo"], ["Enter", "all right, next photo"], ["G", "back to the gallery"],
  ["0 to 9", "choose that person"], ["] and [", "choose the next, previous person"], ["X or Delete", "remove the chosen person"], ["A", "add a missed person"],
  ["O", "chosen person is not on the same floor"], ["B", "body size of the chosen person"], [".", "choose a joint to move by arrow keys"], ["Shift + arrow", "move it ten times as far"],
  ["F", "set the focal length"], ["E", "exclude the photo, or count it again"], ["N", "write a note"], ["U", "undo your last change here"],
  ["P", "all pairs, or nearest neighbours"], ["H", "hide what is drawn on the photo"], ["+ and -", "zoom; R shows the whole photo"], ["Esc", "leave whatever was begun"],
];

// Resolves to what `read` makes of the form, or to null where it was left.
export function ask(title, body, read, action = "Keep") {
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

export function askFocal(camera) {
  const number = (name, label, unit) => html("label", {}, label,
    html("span", {}, html("input", { type: "number", name, id: `focal-${name}`, min: "0.1", step: "any", "aria-label": `${label}, ${unit}` }), ` ${unit}`));
  const problem = html("p", { role: "alert", class: "hint", text: "State one of them." });
  const body = [
    html("p", { class: "hint", text: `Now: ${camera.known ? camera.text : "unknown"}` }),
    html("fieldset", {}, html("legend", { text: "35 mm equivalent" }), number("focal_35mm", "Focal length", "mm")),
    html("fieldset", {}, html("legend", { text: "Lens and sensor" }), number("focal_mm", "Focal length", "mm"),
      number("sensor_width", "Sensor's long side", "mm"), number("sensor_height", "Sensor's short side", "mm")),
    html("fieldset", {}, html("legend", { text: "In pixels of the full-size photo" }), number("focal_px", "Focal length", "px")),
    problem,
  ];
  return ask("Set the focal length", body, (form) => {
    const value = (name) => (form.elements[name].value === "" ? null : Number(form.elements[name].value));
    const stated = ["focal_35mm", "focal_mm", "focal_px"].filter((name) => value(name) !== null);
    const sensor = [value("sensor_width"), value("sensor_height")];
    if (stated.length !== 1) {
      problem.textContent = "State exactly one focal length.";
      return null;
    }
    if (stated[0] === "focal_mm" && sensor.includes(null)) {
      problem.textContent = "A focal length in millimetres needs the sensor's two sides.";
      return null;
    }
    return { [stated[0]]: value(stated[0]), ...(stated[0] === "focal_mm" ? { sensor_mm: sensor } : {}) };
  });
}

export function askText(title, label, text, action) {
  const area = html("textarea", { name: "text", id: "dialog-text", maxlength: 10000, "aria-label": label });
  area.value = text;
  return ask(title, [area], () => area.value, action);
}
