// What is asked in a dialog about a photo or a person, and what follows from the answer.

import * as api from "./annotate_api.js";
import { askLens, askName, askPlace } from "./annotate_dialogs.js";
import { numberOf } from "./annotate_names.js";
import { tell } from "./elements.js";

function seenTags(view) {
  const here = view.fields.people.map((p) => p.tag).filter(Boolean);
  return [...new Set([...view.fields.before, ...here, ...Object.keys(view.about.names)])].sort((a, b) => numberOf(a) - numberOf(b));
}

export async function askAndName(view) {
  const { person } = view;
  if (!person) return;
  const answer = await askName(person, view.about.names, seenTags(view));
  if (answer === null) return;
  if (answer.tag !== person.tag) await view.act("name_person", { person: person.key, tag: answer.tag });
  if (answer.tag !== null && answer.name !== (view.about.names[answer.tag] ?? "")) {
    await view.act("name_tag", { tag: answer.tag, name: answer.name });
    view.about = await api.about();
    view.draw();
  }
}

export function canTakeNames(view) {
  const unnamed = view.fields.people.filter((p) => p.tag === null);
  return unnamed.length > 0 && unnamed.length === view.fields.people.length && unnamed.length === view.fields.before.length;
}

export function takeNames(view) {
  if (!canTakeNames(view)) return tell("Only where as many people are unnamed here as were named on the previous photo", true);
  const middle = (p) => Object.values(p.points).reduce((sum, [x], _, all) => sum + x / all.length, 0);
  const people = [...view.fields.people].sort((a, b) => middle(a) - middle(b));
  return view.act("name_people", { names: people.map((p, k) => ({ person: p.key, tag: view.fields.before[k] })) }, "Named as on the previous photo: check that the names are right");
}

export async function askAndPlace(view) {
  const answer = await askPlace(view.fields, view.about);
  if (answer === null) return;
  const { shoot, camera, scope } = answer;
  const known = view.about.shoots.find((s) => s.number === shoot);
  if (shoot !== view.fields.shoot || camera !== view.fields.camera || scope !== "photo") await view.act("place_photos", { shoot, camera, scope });
  if (answer.shootName !== (known?.name ?? "")) await view.act("name_shoot", { shoot, name: answer.shootName });
  if (answer.cameraName !== (known?.camera_names[camera] ?? "")) await view.act("name_camera", { shoot, tag: camera, name: answer.cameraName });
  view.about = await api.about();
  view.draw();
}

export async function askAndState(view) {
  const answer = await askLens(view.fields);
  if (answer !== null) await view.act("set_lens", answer, answer.lens === null ? "As the file says" : "Lens stated");
}
