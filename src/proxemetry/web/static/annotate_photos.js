// All photos as cards, with how far each is, and what to do.

import * as api from "./annotate_api.js";
import { html, plural } from "./elements.js";
import { shootName } from "./annotate_names.js";

function chips(card) {
  const chip = (text, kind = "") => html("span", { class: `chip ${kind}`, text });
  if (card.skipped) return [chip("left out")];
  return [
    card.done && chip("done", "done"),
    card.named > 0 && chip(plural(card.named, "person", "people")),
    card.unnamed > 0 && chip(`${card.unnamed} unnamed`, "warn"),
    !card.done && !card.named && !card.unnamed && chip(card.proposed ? "nobody" : "not opened yet"),
  ];
}

// File names of one camera differ at the end: the beginning is shortened.
function fileName(path) {
  const name = path.split("/").pop();
  return [html("span", { class: "start", text: name.slice(0, -12) }), name.slice(-12)];
}

function steps(about) {
  const rule = (text) => html("li", { text });
  return html("section", { class: "steps", "aria-label": "How it goes" },
    html("ol", {},
      html("li", {}, html("b", { text: "Photos. " }), "Open each photo, correct the proposed points, and name everyone whose place you measured."),
      html("li", {}, html("b", { text: "Places. " }), "Type coordinates or taped distances, once for each shoot."),
      html("li", {}, html("b", { text: "Check and score. " }), "See what is missing, then how well the tool measures your photos.")),
    html("details", {}, html("summary", { text: "The benchmark's rules for people" }), html("ul", {}, about.rules.people.map(rule))));
}

export async function showPhotos(main, about) {
  const { photos } = await api.photos();
  const shoots = new Map(about.shoots.map((s) => [s.number, s]));
  main.replaceChildren(
    steps(about),
    about.lost ? html("p", { class: "notice", text: `${plural(about.lost, "entry", "entries")} of the log cannot be followed any more and count for nothing.` }) : "",
    about.left_out.length ? html("details", { class: "notice" }, html("summary", { text: `${plural(about.left_out.length, "file", "files")} left out` }),
      html("ul", {}, about.left_out.map((text) => html("li", { text })))) : "",
    html("ul", { class: "cards" }, photos.map((card) => html("li", { class: `card${card.skipped ? " skipped" : ""}` },
      html("a", { href: `#/photo/${card.id}`, title: card.name },
        html("img", { src: api.picture(card.id, 320), alt: "", loading: "lazy" }),
        html("div", { class: "text" }, html("span", { class: "name" }, fileName(card.name)),
          html("span", { class: "facts", text: `${shootName(shoots.get(card.shoot), card.shoot)} · camera ${card.camera}` }),
          html("span", { class: "chips" }, chips(card))))))));
  const next = photos.find((card) => !card.done && !card.skipped);
  return {
    key: (event) => {
      if (event.key !== "Enter" || /^(A|BUTTON|SUMMARY)$/.test(event.target.tagName) || !next) return false;
      location.hash = `#/photo/${next.id}`;
      return true;
    },
  };
}
