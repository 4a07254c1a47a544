// What each key does on the page of a photo.

import { askAndName, askAndPlace, askAndState, takeNames } from "./annotate_answers.js";

// Digits typed within this time are one number: 1 and 2 name P12.
const DIGITS_MS = 700;
// Moves by arrow keys are kept once no key is pressed for this long.
const NUDGE_MS = 600;
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function digit(view, key) {
  if (!view.person) return;
  const now = performance.now();
  const together = view.typed && view.typed.person === view.person.key && now - view.typed.at < DIGITS_MS ? `${view.typed.text}${key}` : key;
  const text = Number(together) > 999 ? key : together;
  view.typed = { text, at: now, person: view.person.key };
  view.act("name_person", { person: view.person.key, tag: `P${Number(text)}` }, `This is P${Number(text)}`);
}

function nudge(view, event) {
  const { state, person } = view;
  const step = Math.max(1, Math.round(view.canvas.unit)) * (event.shiftKey ? 10 : 1);
  const [dx, dy] = ARROWS[event.key].map((v) => v * step);
  if (state.armed) {
    state.cursor = view.canvas.inside([state.cursor[0] + dx, state.cursor[1] + dy]);
    view.canvas.draw();
    return;
  }
  const [x, y] = person.points[state.part];
  if (view.nudged && (view.nudged.person !== person.key || view.nudged.part !== state.part)) view.flush();
  const to = view.canvas.inside([x + dx, y + dy]);
  person.points[state.part] = to;
  view.nudged = { person: person.key, part: state.part, to };
  view.canvas.draw();
  clearTimeout(view.resting);
  view.resting = setTimeout(() => view.rest(), NUDGE_MS);
}

// Returns whether the key has a meaning here.
export function pressed(view, event) {
  const { state, person } = view;
  const onControl = /^(BUTTON|A|SUMMARY)$/.test(event.target.tagName) || event.target.getAttribute?.("role") === "button";
  if (ARROWS[event.key] && (state.armed || (person && state.part && person.points[state.part]))) return nudge(view, event), true;
  if (onControl && (event.key === "Enter" || event.key === " ")) return false;
  if (state.armed && (event.key === " " || event.key === "Enter")) return view.placeCross(), true;
  if (/^[0-9]$/.test(event.key)) return digit(view, event.key), true;
  const keys = {
    ArrowRight: () => view.go(1), j: () => view.go(1), ArrowLeft: () => view.go(-1), k: () => view.go(-1), Enter: () => view.done(),
    e: () => view.choosePart("Eyes"), s: () => view.choosePart("Shoulder"), t: () => view.choosePart("Torso"), h: () => view.choosePart("Head"),
    v: () => view.hide(), Delete: () => view.hide(), Backspace: () => view.hide(), x: () => view.remove(), a: () => view.add(), n: () => askAndName(view), m: () => takeNames(view),
    z: () => view.near(), o: () => askAndPlace(view), c: () => askAndState(view), i: () => view.skip(), "]": () => view.step(1), "[": () => view.step(-1),
    "+": () => view.canvas.zoom(1 / 1.3), "-": () => view.canvas.zoom(1.3), r: () => view.canvas.reset(),
    g: () => (location.hash = "#/"), l: () => (location.hash = `#/places/${view.fields.shoot}`), Escape: () => view.escape(),
  };
  const run = keys[event.key] ?? keys[event.key.toLowerCase()];
  return Boolean(run) && (run(), true);
}
