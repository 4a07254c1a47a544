// Beside the photo: the people with their parts, the rules for what is being placed, and where the photo belongs.

import { askAndPlace, askAndState } from "./annotate_answers.js";
import { lensText } from "./annotate_dialogs.js";
import { called, colourOf, PART_KEYS, shootName } from "./annotate_names.js";
import { html } from "./elements.js";

const PART_TITLES = { Eyes: "Eyes", Shoulder: "Shoulders", Torso: "Torso", Head: "Head" };

export class Side {
  constructor(host, view) {
    this.host = host;
    this.view = view;
  }

  show() {
    const { view } = this;
    const focused = this.host.contains(document.activeElement) ? document.activeElement.dataset.control : null;
    this.host.replaceChildren(this.people(), this.rules(), this.photo());
    if (focused) this.host.querySelector(`[data-control="${focused}"]`)?.focus();
    if (view.state.person !== null) this.host.querySelector("li.chosen")?.scrollIntoView({ block: "nearest" });
  }

  people() {
    const { fields, state, about } = this.view;
    return html("section", {}, html("h2", { text: "People" }),
      fields.people.length ? html("ul", { class: "who" }, fields.people.map((p) => this.person(p, state, about)))
        : html("p", { class: "hint", text: "Nobody is annotated on this photo." }));
  }

  person(p, state, about) {
    const chosen = p.key === state.person;
    const { fill } = colourOf(p.tag, about.colours);
    const swatch = html("span", { class: "swatch" });
    swatch.style.background = fill;
    return html("li", { class: chosen ? "chosen" : "", "data-person": p.key },
      html("button", { type: "button", class: "tag", "aria-pressed": String(chosen), "data-control": `p${p.key}`, onclick: () => this.view.choose(p.key) },
        swatch, p.tag === null ? "unnamed" : called(p.tag, about.names)),
      html("span", { class: "parts", role: "group", "aria-label": `Points of ${p.tag ?? "unnamed person"}` }, about.parts.map((part) => {
        const is = Boolean(p.points[part]);
        return html("button", { type: "button", class: is ? "part set" : "part", "data-control": `p${p.key}${part}`, title: `${PART_TITLES[part]}: ${is ? "set" : "not set"}`,
          "aria-label": `${PART_TITLES[part]}, ${is ? "set" : "not set"}`, "aria-pressed": String(chosen && state.part === part),
          onclick: () => this.view.partOf(p.key, part), text: PART_KEYS[part] });
      })));
  }

  rules() {
    const { state, about } = this.view;
    const [title, rules] = state.part ? [PART_TITLES[state.part], about.rules.parts[state.part]] : ["People to annotate", about.rules.people];
    return html("section", { class: "rules" }, html("h2", { text: title }), html("ul", {}, rules.map((text) => html("li", { text }))));
  }

  photo() {
    const { fields, about } = this.view;
    const shoot = about.shoots.find((s) => s.number === fields.shoot);
    const cameraName = shoot?.camera_names[fields.camera];
    const lens = fields.lens ? `${lensText(fields.lens)}, stated` : lensText(fields.file_lens);
    return html("section", {}, html("h2", { text: "This photo" }), html("dl", {},
      html("dt", { text: "Shoot" }), html("dd", { text: shoot?.name ? `${fields.shoot}: ${shoot.name}` : shootName(shoot, fields.shoot) }),
      html("dt", { text: "Camera place" }), html("dd", { text: cameraName ? `${fields.camera}: ${cameraName}` : fields.camera }),
      html("dt", { text: "Camera" }), html("dd", { text: fields.device || "not named in the file" }),
      html("dt", { text: "Lens" }), html("dd", { text: lens })),
    html("div", { class: "row" },
      html("button", { type: "button", "data-control": "place", "aria-keyshortcuts": "O", onclick: () => askAndPlace(this.view) }, "Shoot and camera ", html("kbd", { text: "O" })),
      html("button", { type: "button", "data-control": "lens", "aria-keyshortcuts": "C", onclick: () => askAndState(this.view) }, "Lens ", html("kbd", { text: "C" }))));
  }
}
