// How well two reviewers agree.

import * as api from "./api.js";
import { html } from "./elements.js";

export async function showAgreement(main) {
  const { reviewers } = await api.reviewers();
  const answer = html("div", { "aria-live": "polite" });
  const pick = (id, chosen) => html("select", { id },
    reviewers.map((name) => html("option", { value: name, text: name, selected: name === chosen })));
  const one = pick("one", reviewers[0]);
  const other = pick("other", reviewers[1]);

  async function compare() {
    answer.replaceChildren();
    try {
      answer.append(table(await api.agreement(one.value, other.value)));
    } catch (error) {
      answer.append(html("p", { text: error.message }));
    }
  }

  main.replaceChildren(html("section", { class: "sheet" },
    html("h2", { text: "Agreement between two reviewers" }),
    html("p", { class: "hint", text: "Counted over the photos that both looked at, whether they changed anything or marked them as right. For two independent reviews, start the second with --who NAME --blind." }),
    reviewers.length < 2
      ? html("p", { text: `The log has ${reviewers.length === 1 ? `one reviewer, ${reviewers[0]}` : "no reviewer yet"}: there is no second one to compare with.` })
      : html("div", { class: "pick" },
        html("label", { for: "one" }, "One", one), html("label", { for: "other" }, "Other", other),
        html("button", { type: "button", class: "first", onclick: compare, text: "Compare" })),
    answer));
}

function table(a) {
  const number = (v, digits = 2) => (v === null ? "undefined" : v.toFixed(digits));
  const share = a.share_alike === null ? "undefined" : `${(100 * a.share_alike).toFixed(1)} %`;
  const rows = [
    ["Photos looked at by both", a.n_photos],
    ["Left in the same state", `${a.n_alike} (${share})`],
    ["Changed by both / by one / by the other / by neither", `${a.n_both_changed} / ${a.n_one_only} / ${a.n_other_only} / ${a.n_none}`],
    ["Cohen's kappa, changed or not", number(a.kappa)],
    ["People in both versions / only one's / only the other's", `${a.n_people} / ${a.n_people_one} / ${a.n_people_other}`],
    ["Distances in both versions", a.n_pairs],
    [`Mean difference, ${a.one} minus ${a.other}`, `${number(a.mean_difference_m, 3)} m (SD ${number(a.sd_difference_m, 3)} m)`],
    ["Mean absolute difference", `${number(a.mean_absolute_m, 3)} m`],
    ["95 % limits of agreement", `${number(a.low_m, 3)} to ${number(a.high_m, 3)} m`],
  ];
  return html("table", { id: "agreement" }, html("tbody", {},
    rows.map(([name, value]) => html("tr", {}, html("th", { scope: "row", text: name }), html("td", { class: "num", text: String(value) })))));
}
