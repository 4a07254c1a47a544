// Which page is shown: the address after # says it, so that the browser's own back and reload work.

import { showAgreement } from "./agreement.js";
import * as api from "./api.js";
import { CalibrateView } from "./calibrate.js";
import { showHelp } from "./dialogs.js";
import { showDrop } from "./drop.js";
import { showFolder } from "./folder.js";
import { html, tell } from "./elements.js";
import { START, showGallery } from "./gallery.js";
import { PhotoView } from "./photo.js";

const main = document.getElementById("main");
let about = null;
let view = null;
let turn = 0;

function placeOf(hash) {
  const [path, search] = hash.replace(/^#/, "").split("?");
  const given = new URLSearchParams(search ?? "");
  const query = { ...START };
  for (const name of Object.keys(START)) if (given.has(name)) query[name] = given.get(name);
  return { parts: path.split("/").filter(Boolean), query, page: Number(given.get("page") ?? 0) };
}

function openGallery(query, page) {
  const hash = `#/?${api.searchOf({ ...query, page })}`;
  if (location.hash === hash) show();
  else location.hash = hash;
}

async function show() {
  const mine = ++turn;
  const { parts, query, page } = placeOf(location.hash);
  try {
    about ??= await api.about();
    head();
    if (parts[0] === "photo" || parts[0] === "calibrate") {
      const fields = await api.photo(Number(parts[1]), query);
      if (mine !== turn) return;
      view?.close();
      view = new (parts[0] === "photo" ? PhotoView : CalibrateView)(main, fields, query);
      main.focus({ preventScroll: true });
    } else {
      view?.close();
      view = null;
      if (parts[0] === "agreement") await showAgreement(main);
      else if (about.mode === "drop" && about.photos === 0) {
        showDrop(main, opened);
        await showFolder(main, measured);
      }
      else {
        const typed = document.activeElement?.id;
        about = await showGallery(main, query, page, openGallery);
        if (about.mode === "drop") main.prepend(dropAgain());
        const field = typed ? document.getElementById(typed) : null;
        field?.focus();
        if (typed === "text") field.setSelectionRange(query.text.length, query.text.length);
      }
    }
    for (const [id, is] of [["nav-photos", parts[0] !== "agreement"], ["nav-agreement", parts[0] === "agreement"]]) {
      if (is) document.getElementById(id).setAttribute("aria-current", "page");
      else document.getElementById(id).removeAttribute("aria-current");
    }
  } catch (error) {
    if (!(error instanceof api.Problem)) throw error;
    main.replaceChildren(html("p", { class: "empty", text: error.message }));
  }
}

// One dropped photo opens; several show the gallery, with the list of those that were refused.
async function opened(id, refused = null) {
  about = null;
  if (id !== null) {
    location.hash = `#/photo/${id}?${api.searchOf(START)}`;
    return;
  }
  await show();
  if (refused) main.querySelector(".drop")?.append(refused);
}

function measured() {
  about = null;
  show();
}

function dropAgain() {
  const area = html("div", {});
  showDrop(area, opened, true);
  return area;
}

function head() {
  const folder = about.mode === "drop" ? "dropped photos" : about.folder;
  const where = document.getElementById("where");
  where.title = folder;
  where.textContent = `${folder.split(/[\\/]/).filter(Boolean).pop() ?? folder} · reviewing as ${about.who}${about.blind ? ", blind" : ""}`;
  document.getElementById("export").hidden = about.mode === "drop" && about.photos === 0;
  document.getElementById("nav-agreement").hidden = about.mode === "drop";
}

document.getElementById("help").addEventListener("click", showHelp);
document.getElementById("export").addEventListener("click", async (event) => {
  event.target.disabled = true;
  try {
    if (about.mode === "drop") {
      html("a", { href: api.tables, download: "proxemetry-tables.zip" }).click();
      tell("The tables are downloaded as a zip file");
      return;
    }
    tell("Writing the tables ...");
    const { files } = await api.exportTables();
    tell(`Written to the results folder: ${files.join(", ")}`);
  } catch (error) {
    tell(error.message, true);
  } finally {
    event.target.disabled = false;
  }
});
document.addEventListener("keydown", (event) => {
  if (document.getElementById("dialog").open || event.ctrlKey || event.metaKey || event.altKey) return;
  if (/^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName)) return;
  if (event.key === "?") showHelp();
  else if (view?.key(event)) event.preventDefault();
});
// A file dropped beside the frame must not replace the page.
for (const name of ["dragover", "drop"]) document.addEventListener(name, (event) => event.preventDefault());
window.addEventListener("hashchange", show);
show();
