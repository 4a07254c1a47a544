// Every request to the server. Nothing here leaves this machine.

export class Problem extends Error {}

export async function ask(path, options) {
  let answer;
  try {
    answer = await fetch(path, { credentials: "same-origin", ...options });
  } catch {
    throw new Problem("The program that serves this page has ended: start it again.");
  }
  const fields = answer.headers.get("content-type")?.startsWith("application/json") ? await answer.json() : {};
  if (!answer.ok) throw new Problem(fields.error ?? `The page was refused (${answer.status}).`);
  return fields;
}

export function searchOf(query) {
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    if (value !== null && value !== undefined && !(name === "text" && value === "")) search.set(name, value);
  }
  return search.toString();
}

export const about = () => ask("/api/about");
export const photos = (query, page) => ask(`/api/photos?${searchOf({ ...query, page })}`);
export const photo = (id, query) => ask(`/api/photos/${id}?${searchOf(query)}`);
export const picture = (id, size) => `/api/photos/${id}/picture?size=${size}`;
export const undo = (id, query) => ask(`/api/photos/${id}/undo?${searchOf(query)}`, { method: "POST" });
export const folders = (path) => ask(`/api/folders?${searchOf({ path })}`);
export const measuring = () => ask("/api/measuring");
export const stopMeasuring = () => ask("/api/measuring", { method: "DELETE" });
export const openMeasured = () => ask("/api/measuring/open", { method: "POST" });
export const startMeasuring = (run) =>
  ask("/api/measuring", { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(run) });
export const reviewers = () => ask("/api/reviewers");
export const agreement = (one, other) => ask(`/api/agreement?${searchOf({ one, other })}`);
export const tables = "/api/tables.zip";
export const exportTables = () => ask("/api/export", { method: "POST" });

export const act = (id, query, action, value) =>
  ask(`/api/photos/${id}/actions?${searchOf(query)}`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify({ action, value }),
  });

const told = (path, value) => ask(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(value) });
export const calibrate = (id, clicked) => told(`/api/photos/${id}/calibration`, clicked);
export const saveCamera = (id, name, clicked) => told(`/api/photos/${id}/calibration/${encodeURIComponent(name)}`, clicked);

export const alike = (id, scope) => ask(`/api/photos/${id}/alike?${searchOf({ scope })}`);

export const drop = (file) =>
  ask(`/api/drop?${searchOf({ name: file.name })}`, {
    method: "POST",
    headers: { "Content-Type": "application/octet-stream" },
    body: file,
  });
