// Which step is shown: the address after # says it, so that the browser's own back and reload work.

import * as api from "./annotate_api.js";
import { showHelp } from "./annotate_dialogs.js";
import { showPhotos } from "./annotate_photos.js";
import { PhotoView } from "./annotate_photo.js";
import { showPlaces } from "./annotate_places.js";
import { showScore } from "./annotate_score.js";
import { Problem } from "./api.js";
import { html, plural, tell } from "./elements.js";

const main = document.getElementById("main");
let view = null;
let turn = 0;

async function show() {
  const mine = ++turn;
  const [step, argument] = location.hash.replace(/^#\/?/, "").split("/");
  try {
    await view?.leave?.();
    const about = await api.about();
    const fields = step === "photo" ? await api.photo(Number(argument)) : null;
    if (mine !== turn) return;
    head(about);
    view?.close?.();
    view = null;
    if (step === "photo") {
      view = new PhotoView(main, fields, about, changed);
      main.focus({ preventScroll: true });
    } else if (step === "places") view = await showPlaces(main, about, argument, changed);
    else if (step === "score") view = await showScore(main, about);
    else view = await showPhotos(main, about);
    mark(step);
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    main.replaceChildren(html("p", { class: "empty", text: error.message }));
  }
}

function mark(step) {
  const current = step === "places" || step === "score" ? step : "photos";
  for (const name of ["photos", "places", "score"]) {
    const link = document.getElementById(`nav-${name}`);
    if (name === current) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
}

function head(about) {
  const where = document.getElementById("where");
  where.title = about.out;
  const counted = about.photos - about.skipped;
  where.textContent = `${about.out.split(/[\\/]/).filter(Boolean).pop()} · ${about.done} of ${plural(counted, "photo", "photos")} done`;
  steps(about);
}

// The buttons say what undo and redo would do.
function steps({ undo, redo }) {
  for (const [id, text] of [["undo", undo], ["redo", redo]]) {
    const button = document.getElementById(id);
    button.disabled = text === null;
    button.title = text === null ? "" : `${id === "undo" ? "Undo" : "Redo"}: ${text}`;
  }
}

// Called after every change, with the server's answer on undo and redo, or null to ask for it.
async function changed(fields = null) {
  if (fields?.undo !== undefined) steps(fields);
  else head(await api.about());
}

let stepping = false;

async function step(which) {
  if (stepping) return;
  stepping = true;
  try {
    await view?.leave?.();
    const { photo, shoot, text } = await api[which]();
    const target = photo !== null ? `#/photo/${photo}` : shoot !== null && shoot !== undefined ? `#/places/${shoot}` : null;
    if (target !== null && location.hash !== target) location.hash = target;
    else await show();
    tell(`${which === "undo" ? "Undone" : "Done again"}: ${text}`);
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    tell(error.message, true);
  } finally {
    stepping = false;
  }
}

document.getElementById("help").addEventListener("click", showHelp);
document.getElementById("undo").addEventListener("click", () => step("undo"));
document.getElementById("redo").addEventListener("click", () => step("redo"));
document.addEventListener("keydown", (event) => {
  if (document.getElementById("dialog").open || event.altKey) return;
  if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  const key = event.key.toLowerCase();
  if (event.ctrlKey || event.metaKey) {
    if (key === "z" || key === "y") {
      event.preventDefault();
      step(key === "y" || event.shiftKey ? "redo" : "undo");
    }
    return;
  }
  if (event.key === "?") showHelp();
  else if (key === "u") step("undo");
  else if (key === "y") step("redo");
  else if (view?.key?.(event)) event.preventDefault();
});
// A file dropped beside must not replace the page.
for (const name of ["dragover", "drop"]) document.addEventListener(name, (event) => event.preventDefault());
window.addEventListener("hashchange", show);
show();
