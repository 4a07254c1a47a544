// The gallery: every photo as a card, filtered, sorted, page by page.

import * as api from "./api.js";
import { html, metres, plural } from "./elements.js";

const SHOWS = {
  all: "All photos", unchecked: "Not yet reviewed", pairs: "With distances", nobody: "No people found",
  camera: "Camera doubtful or unknown", doubles: "A person perhaps found twice", doubts: "A person in doubt", failed: "Could not be read", corrected: "Corrected", excluded: "Excluded",
  notes: "With a note",
};
const SORTS = { name: "Name", uncertain: "Least certain first", nearest: "Nearest pair first", people: "Most people first", doubts: "Most doubtful people first" };

export const START = { show: "all", sort: "name", group: null, text: "" };

export async function showGallery(main, query, page, go) {
  const [about, found] = await Promise.all([api.about(), api.photos(query, page)]);
  const last = Math.max(0, Math.ceil(found.total / about.page_size) - 1);
  main.replaceChildren(
    tools(about, query, found.total, go),
    found.photos.length
      ? html("ul", { class: "cards", "aria-label": "Photos" }, found.photos.map((p) => card(p, query)))
      : html("p", { class: "empty", text: about.photos ? "No matching photos." : "There are no photos yet." }),
    ...(last > 0 ? [pages(page, last, query, go)] : []),
  );
  return about;
}

function tools(about, query, total, go) {
  const changed = (name) => (event) => go({ ...query, [name]: event.target.value === "*" ? null : event.target.value }, 0);
  let typing;
  const typed = (event) => {
    const text = event.target.value;
    clearTimeout(typing);
    typing = setTimeout(() => go({ ...query, text }, 0), 250);
  };
  return html("form", { class: "tools", role: "search", onsubmit: (e) => e.preventDefault() },
    html("label", {}, "Show", choice("show", Object.entries(SHOWS).map(([k, v]) => [k, `${v} (${about.counts[k].toLocaleString("en")})`]),
      query.show, changed("show"))),
    html("label", {}, "Sort by", choice("sort", Object.entries(SORTS), query.sort, changed("sort"))),
    about.groups.length > 1 && html("label", {}, "Group", choice("group",
      [["*", "All groups"], ...about.groups.map((g) => [g, g || "(top folder)"])], query.group ?? "*", changed("group"))),
    html("label", {}, "Name contains", html("input", { type: "search", id: "text", value: query.text, oninput: typed })),
    html("span", { class: "total", text: `${plural(total, "photo", "photos")} · ${about.reviewed.toLocaleString("en")} of ${about.photos.toLocaleString("en")} reviewed` }),
  );
}

function choice(id, options, chosen, onchange) {
  return html("select", { id, onchange },
    options.map(([value, text]) => html("option", { value, selected: value === chosen, text })));
}

const ENDING = 14;

function card(photo, query) {
  const facts = photo.status === "failed" ? "could not be read"
    : `${plural(photo.people, "person", "people")}${photo.nearest_m === null ? "" : ` · nearest ${metres(photo.nearest_m)}`}`;
  const chips = [
    photo.status === "excluded" && ["excluded", ""],
    photo.status === "no_camera" && ["no focal length", "warn"],
    photo.status === "failed" && ["not read", "warn"],
    photo.assumed && photo.status === "ok" && ["lens assumed", ""],
    photo.doubtful && !photo.assumed && photo.status === "ok" && ["camera doubtful", "warn"],
    photo.duplicates > 0 && ["perhaps found twice", "warn"],
    photo.doubts > photo.duplicates && ["perhaps no person", "warn"],
    photo.spread > 1 && ["wide interval", ""],
    photo.corrections > 0 && [plural(photo.corrections, "correction", "corrections"), "done"],
    photo.marks.includes("checked") && ["reviewed", "done"],
    photo.marks.includes("note") && ["note", "done"],
  ].filter(Boolean);
  const image = html("img", { src: api.picture(photo.id, 320), alt: "", loading: "lazy" });
  image.addEventListener("error", () => image.replaceWith(html("div", { class: "thumb", text: "no picture" })));
  return html("li", { class: "card" },
    html("a", { href: `#/photo/${photo.id}?${api.searchOf(query)}`, title: photo.reason || photo.photo },
      photo.status === "failed" ? html("div", { class: "thumb", text: "no picture" }) : image,
      html("div", { class: "text" },
        // A long name is shortened at its beginning: file names of one camera differ at the end.
        html("span", { class: "name" }, html("span", { class: "start", text: photo.photo.slice(0, -ENDING) }), html("span", { text: photo.photo.slice(-ENDING) })),
        html("span", { class: "facts", text: facts }),
        html("span", { class: "chips" }, chips.map(([text, kind]) => html("span", { class: `chip ${kind}`, text }))))));
}

function pages(page, last, query, go) {
  const button = (text, target, disabled) =>
    html("button", { type: "button", disabled, onclick: () => go(query, target), text });
  return html("nav", { class: "pages", "aria-label": "Pages of the gallery" },
    button("First", 0, page === 0), button("Previous", page - 1, page === 0),
    html("span", { text: `Page ${page + 1} of ${last + 1}` }),
    button("Next", page + 1, page >= last), button("Last", last, page >= last));
}
