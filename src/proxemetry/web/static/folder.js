// Choose a folder of this machine and measure it: progress, time left, then the review of its photos.

import * as api from "./api.js";
import { html, plural, tell } from "./elements.js";
import { NotANumber, typedNumber } from "./numbers.js";

const ASK_EVERY_MS = 700;

function duration(seconds) {
  if (seconds < 90) return `${Math.round(seconds)} s`;
  return seconds < 7200 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds / 3600)} h`;
}

// `opened` is called when the page shows the measured folder.
export async function showFolder(main, opened) {
  const where = html("input", { type: "text", id: "folder", class: "wide", spellcheck: "false", "aria-label": "Folder with photos" });
  const out = html("input", { type: "text", id: "out", class: "wide", spellcheck: "false" });
  const focal = html("input", { type: "text", id: "focal", inputmode: "decimal", autocomplete: "off", placeholder: "from the files" });
  const list = html("ul", { class: "folders", "aria-label": "Subfolders" });
  const told = html("p", { class: "hint", role: "status" });
  const bar = html("progress", { max: 1, value: 0, hidden: true, "aria-label": "Photos measured" });
  const start = html("button", { type: "button", class: "first", id: "measure", onclick: () => begin(), text: "Measure this folder" });
  const stop = html("button", { type: "button", hidden: true, onclick: () => api.stopMeasuring(), text: "Stop" });
  const area = html("section", { class: "sheet", "aria-label": "Measure a folder" },
    html("h2", { text: "Measure a folder of photos" }),
    html("label", { class: "line" }, "Folder", where, html("button", { type: "button", onclick: () => go(where.value), text: "Open" })),
    list,
    html("label", { class: "line" }, "Results go to", out),
    html("label", { class: "line" }, "Focal length of all photos as 35 mm equivalent, if you know it", focal, " mm"),
    told, bar, html("div", { class: "row" }, stop, start));
  main.append(area);

  async function go(path) {
    try {
      const found = await api.folders(path);
      where.value = found.path;
      out.value = found.results;
      told.textContent = `${plural(found.photos, "photo", "photos")} here, plus those in its subfolders`;
      const items = [found.parent === null ? null : ["↑ parent folder", found.parent], ...found.folders.map((name) => [name, `${found.path.replace(/[\\/]$/, "")}/${name}`])];
      list.replaceChildren(...items.filter(Boolean).map(([name, target]) => html("li", {}, html("button", { type: "button", onclick: () => go(target), text: name }))));
    } catch (error) {
      if (!(error instanceof api.Problem)) throw error;
      told.textContent = error.message;
    }
  }

  async function begin() {
    try {
      await api.startMeasuring({ folder: where.value, out: out.value, focal_35mm: typedNumber(focal.value) });
    } catch (error) {
      if (!(error instanceof api.Problem || error instanceof NotANumber)) throw error;
      tell(error.message, true);
      return;
    }
    follow();
  }

  async function follow() {
    start.disabled = true;
    stop.hidden = bar.hidden = false;
    let state;
    do {
      await new Promise((done) => setTimeout(done, ASK_EVERY_MS));
      if (!area.isConnected) return;
      state = await api.measuring();
      if (state.total) bar.value = state.done / state.total;
      const left = state.seconds_left ? `, ${duration(state.seconds_left)} left` : "";
      told.textContent = state.total ? `${state.done} of ${plural(state.total, "photo", "photos")}${left}` : state.note ?? "looking for photos and people-finding networks ...";
    } while (state.status === "running");
    start.disabled = false;
    stop.hidden = true;
    if (state.status === "failed") told.textContent = state.error;
    else if (state.status === "stopped") told.textContent = "Stopped. What was measured stays; measure the folder again to continue.";
    else {
      await api.openMeasured();
      opened();
    }
  }

  await go("");
  if ((await api.measuring()).status === "running") follow();
}
