// Drop one photo, or choose it: it is measured by the program behind this page and goes nowhere else.

import * as api from "./api.js";
import { html, tell } from "./elements.js";

export function showDrop(main, opened) {
  const input = html("input", { type: "file", id: "file", accept: "image/*", hidden: true });
  const message = html("p", { class: "hint", text: "JPEG, PNG, TIFF or WebP. It stays on this machine and is forgotten when the program ends." });
  const area = html("section", { class: "drop", "aria-label": "Drop a photo" },
    html("h2", { text: "Drop a photo here" }),
    message,
    html("button", { type: "button", class: "first", onclick: () => input.click(), text: "Choose a photo" }),
    input);

  async function take(file) {
    if (!file) return;
    message.textContent = `Measuring ${file.name} ...`;
    area.setAttribute("aria-busy", "true");
    try {
      const { id } = await api.drop(file);
      opened(id);
    } catch (error) {
      message.textContent = error.message;
      tell(error.message, true);
    } finally {
      area.removeAttribute("aria-busy");
    }
  }

  input.addEventListener("change", () => take(input.files[0]));
  area.addEventListener("dragover", (event) => { event.preventDefault(); area.classList.add("over"); });
  area.addEventListener("dragleave", () => area.classList.remove("over"));
  area.addEventListener("drop", (event) => {
    event.preventDefault();
    area.classList.remove("over");
    take(event.dataTransfer.files[0]);
  });
  main.replaceChildren(area);
}
