// Every request of the annotation page to the server. Nothing here leaves this machine.

import { ask } from "./api.js";

const post = (path, fields) =>
  ask(path, { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(fields ?? {}) });

export const about = () => ask("/api/about");
export const photos = () => ask("/api/photos");
export const photo = (id) => ask(`/api/photos/${id}`);
export const propose = (id) => post(`/api/photos/${id}/propose`);
export const picture = (id, size) => `/api/photos/${id}/picture?size=${size}`;
export const act = (photo, action, value) => post("/api/actions", { photo, action, value });
export const undo = () => post("/api/undo");
export const redo = () => post("/api/redo");
export const places = (shoot) => ask(`/api/places/${shoot}`);
export const check = () => ask("/api/check");
export const scoring = () => ask("/api/scoring");
export const startScoring = () => post("/api/scoring");
export const stopScoring = () => ask("/api/scoring", { method: "DELETE" });
