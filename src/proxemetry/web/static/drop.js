// Drop photos, or choose them: they are measured by the program behind this page and go nowhere else.

import * as api from "./api.js";
import { html, plural, tell } from "./elements.js";

// `opened` receives the number of the photo where there was one, null where there were several.
export function showDrop(main, opened, again = false) {
  const input = html("input", { type: "file", id: "file", accept: "image/*,.heic,.heif,.dng,.jp2,.jfif", multiple: true, hidden: true });
  const message = html("p", { class: "hint", text: "JPEG, PNG, TIFF, WebP, and HEIC or raw files where support for them is installed. Photos stay on this machine and are deleted when the program ends." });
  const queue = html("ul", { class: "queue", "aria-live": "polite" });
  const area = html("section", { class: "drop", "aria-label": "Drop photos" },
    html("h2", { text: again ? "Drop more photos here" : "Drop photos here" }),
    message,
    html("button", { type: "button", class: "first", onclick: () => input.click(), text: "Choose photos" }),
    input, queue);
  let busy = false;

  // One after the other: a photo's networks use all cores, and an answer has its line as soon as it is there.
  async function take(list) {
    const files = [...list]; // the input's own list is emptied below
    if (busy) {
      tell("The photos dropped before are still being measured", true);
      return;
    }
    if (!files.length) return;
    busy = true;
    area.setAttribute("aria-busy", "true");
    const lines = files.map((file) => html("span", { text: "waiting" }));
    queue.replaceChildren(...files.map((file, k) => html("li", {}, html("span", { text: file.name }), lines[k])));
    const taken = [];
    try {
      for (const [k, file] of files.entries()) {
        message.textContent = files.length > 1 ? `Measuring photo ${k + 1} of ${files.length} ...` : `Measuring ${file.name} ...`;
        lines[k].textContent = "measuring ...";
        try {
          taken.push((await api.drop(file)).id);
          lines[k].textContent = "measured";
        } catch (error) {
          if (!(error instanceof api.Problem)) throw error;
          lines[k].textContent = error.message;
          lines[k].className = "problem";
          if (files.length === 1) tell(error.message, true);
        }
      }
    } finally {
      busy = false;
      area.removeAttribute("aria-busy");
      input.value = "";
    }
    message.textContent = `${plural(taken.length, "photo", "photos")} measured${taken.length < files.length ? `, ${files.length - taken.length} refused (see below)` : ""}`;
    if (taken.length === 1 && files.length === 1) opened(taken[0]);
    else if (taken.length) opened(null, taken.length < files.length ? queue : null);
  }

  input.addEventListener("change", () => take(input.files));
  area.addEventListener("dragover", (event) => { event.preventDefault(); area.classList.add("over"); });
  area.addEventListener("dragleave", () => area.classList.remove("over"));
  area.addEventListener("drop", (event) => {
    event.preventDefault();
    area.classList.remove("over");
    take(event.dataTransfer.files);
  });
  main.replaceChildren(area);
}
