"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const colours = ["#3b6ea5", "#b5533c", "#4f8a4c", "#8a5fa8", "#a8862d", "#2f8a8a", "#a84f78", "#667"];
const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const ink = dark ? "#e6e6e6" : "#222", faint = dark ? "#4a4a4a" : "#d5d5d5", paper = dark ? "#1c1c1e" : "#fff";

function prepared(id, height) {
  const canvas = document.getElementById(id);
  const width = canvas.clientWidth, scale = window.devicePixelRatio || 1;
  canvas.width = width * scale; canvas.height = height * scale; canvas.style.height = height + "px";
  const c = canvas.getContext("2d");
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.font = "12px system-ui, sans-serif"; c.fillStyle = paper; c.fillRect(0, 0, width, height);
  return [c, width, height];
}
function ticks(low, high, about) {
  const raw = (high - low) / Math.max(1, about), power = Math.pow(10, Math.floor(Math.log10(raw || 1)));
  const step = [1, 2, 5, 10].map(k => k * power).find(s => s >= raw) || 1;
  const found = [];
  for (let v = Math.ceil(low / step) * step; v <= high + 1e-9; v += step) found.push(Math.round(v / step) * step);
  return found.map(v => +v.toFixed(6));
}
function floorScale(width, height) {
  const [x0, y0, x1, y1] = data.extent, pad = 34;
  const k = Math.min((width - 2 * pad) / Math.max(x1 - x0, 1), (height - 2 * pad) / Math.max(y1 - y0, 1));
  const left = (width - k * (x1 - x0)) / 2, top = (height - k * (y1 - y0)) / 2;
  return { k, x: v => left + k * (v - x0), y: v => height - top - k * (v - y0) };
}
function grid(c, s, width, height) {
  const [x0, y0, x1, y1] = data.extent;
  c.strokeStyle = faint; c.fillStyle = ink; c.lineWidth = 0.5; c.textAlign = "center";
  for (const v of ticks(x0, x1, 8)) {
    c.beginPath(); c.moveTo(s.x(v), s.y(y0)); c.lineTo(s.x(v), s.y(y1)); c.stroke(); c.fillText(v, s.x(v), s.y(y0) + 14);
  }
  c.textAlign = "right";
  for (const v of ticks(y0, y1, 6)) {
    c.beginPath(); c.moveTo(s.x(x0), s.y(v)); c.lineTo(s.x(x1), s.y(v)); c.stroke(); c.fillText(v, s.x(x0) - 4, s.y(v) + 4);
  }
}
function at(track, t) {
  const times = track.t;
  if (t < times[0] - data.step || t > times[times.length - 1] + data.step) return null;
  let k = 0; while (k < times.length - 1 && times[k + 1] <= t) k++;
  const j = Math.min(k + 1, times.length - 1), w = j > k ? Math.min(1, Math.max(0, (t - times[k]) / (times[j] - times[k]))) : 0;
  return { x: track.x[k] * (1 - w) + track.x[j] * w, y: track.y[k] * (1 - w) + track.y[j] * w, seen: track.s[k], heading: track.h[k] };
}
let now = data.t.length ? data.t[0] : 0, playing = false, last = 0;
function drawFloor() {
  const [c, width, height] = prepared("floor", Math.max(260, Math.min(520, document.getElementById("floor").clientWidth * 0.62)));
  const s = floorScale(width, height), limit = data.limits[data.limits.length - 1];
  grid(c, s, width, height);
  const there = data.tracks.map(track => [track, at(track, now)]).filter(p => p[1]);
  for (let i = 0; i < there.length; i++) for (let j = i + 1; j < there.length; j++) {
    const a = there[i][1], b = there[j][1], d = Math.hypot(a.x - b.x, a.y - b.y);
    if (d > limit) continue;
    c.strokeStyle = there[i][0].g === there[j][0].g ? faint : "#c0392b"; c.lineWidth = there[i][0].g === there[j][0].g ? 4 : 2;
    c.beginPath(); c.moveTo(s.x(a.x), s.y(a.y)); c.lineTo(s.x(b.x), s.y(b.y)); c.stroke();
    c.fillStyle = ink; c.textAlign = "center"; c.fillText(d.toFixed(1) + " m", s.x((a.x + b.x) / 2), s.y((a.y + b.y) / 2) - 4);
  }
  for (const [track, p] of there) {
    const colour = colours[track.n % colours.length];
    c.strokeStyle = colour; c.globalAlpha = 0.35; c.lineWidth = 1.5; c.beginPath();
    let begun = false;
    track.t.forEach((t, k) => { if (t > now || t < now - 5) return; const f = begun ? "lineTo" : "moveTo"; c[f](s.x(track.x[k]), s.y(track.y[k])); begun = true; });
    c.stroke(); c.globalAlpha = 0.12; c.fillStyle = colour;
    c.beginPath(); c.arc(s.x(p.x), s.y(p.y), Math.max(2, s.k * limit / 2), 0, 7); c.fill();
    c.globalAlpha = 1; c.beginPath(); c.arc(s.x(p.x), s.y(p.y), 5, 0, 7);
    if (p.seen) c.fill(); else { c.lineWidth = 1.5; c.stroke(); }
    if (p.heading !== null) {
      c.strokeStyle = colour; c.lineWidth = 2; c.beginPath(); c.moveTo(s.x(p.x), s.y(p.y));
      c.lineTo(s.x(p.x) + 12 * Math.cos(p.heading), s.y(p.y) - 12 * Math.sin(p.heading)); c.stroke();
    }
    c.fillStyle = ink; c.textAlign = "left"; c.fillText(track.n, s.x(p.x) + 7, s.y(p.y) - 6);
  }
  document.getElementById("clock").textContent = now.toFixed(1) + " s";
  document.getElementById("when").value = now;
}
function chart(id, height, series, top, unit, mark) {
  const [c, width] = prepared(id, height), left = 44, right = width - 18, bottom = height - 22, ceiling = 10;
  const t0 = data.t[0] || 0, t1 = data.t[data.t.length - 1] || 1;
  const x = t => left + (right - left) * (t - t0) / Math.max(t1 - t0, 1e-9), y = v => bottom - (bottom - ceiling) * v / top;
  c.strokeStyle = faint; c.fillStyle = ink; c.lineWidth = 0.5; c.textAlign = "right";
  for (const v of ticks(0, top, 4)) { c.beginPath(); c.moveTo(left, y(v)); c.lineTo(right, y(v)); c.stroke(); c.fillText(v, left - 5, y(v) + 4); }
  c.textAlign = "center";
  for (const v of ticks(t0, t1, width / 90)) c.fillText(v + " s", x(v), height - 6);
  c.save(); c.beginPath(); c.rect(left, ceiling - 2, right - left, bottom - ceiling + 4); c.clip();
  for (const one of series) {
    c.fillStyle = c.strokeStyle = one.colour;
    if (one.low) {
      c.globalAlpha = 0.22; c.beginPath();
      one.t.forEach((t, k) => c[k ? "lineTo" : "moveTo"](x(t), y(one.high[k])));
      for (let k = one.t.length - 1; k >= 0; k--) c.lineTo(x(one.t[k]), y(one.low[k]));
      c.fill(); c.globalAlpha = 1;
    }
    c.lineWidth = 1.6; c.beginPath(); let before = null;
    one.t.forEach((t, k) => {
      if (one.v[k] === null) { before = null; return; }
      c[before === null || t - before > 3 * data.step ? "moveTo" : "lineTo"](x(t), y(one.v[k])); before = t;
    });
    c.stroke();
  }
  if (mark) { c.strokeStyle = ink; c.globalAlpha = 0.5; c.beginPath(); c.moveTo(x(now), ceiling); c.lineTo(x(now), bottom); c.stroke(); c.globalAlpha = 1; }
  c.restore();
}
const largest = rows => rows.reduce((m, v) => Math.max(m, v === null ? 0 : v), 0);
function drawTimeline() {
  const choice = +document.getElementById("limit").value, apart = document.getElementById("apart").checked;
  const near = (apart ? data.apart : data.within)[choice];
  chart("people", 120, [{ t: data.t, v: data.n, colour: colours[0] }], Math.max(1, largest(data.n)) * 1.1, "", true);
  chart("near", 120, [{ t: data.t, v: near, colour: colours[1] }], Math.max(1, largest(near)) * 1.1, "", true);
  if (document.getElementById("density"))
    chart("density", 120, [{ t: data.t, v: data.density, colour: colours[2] }], Math.max(0.02, largest(data.density)) * 1.1, "", true);
}
function drawPair() {
  if (!data.pairs.length) return;
  const pair = data.pairs[+document.getElementById("pair").value];
  const top = Math.min(12, Math.max(2.5, largest(pair.d) * 1.1));
  const lines = data.limits.map((v, k) => ({ t: [data.t[0], data.t[data.t.length - 1]], v: [v, v], colour: faint }));
  chart("curve", 190, [...lines, { t: pair.t, v: pair.d, low: pair.low, high: pair.high, colour: colours[0] }], top, "m", true);
}
function drawHeat() {
  const which = document.getElementById("map").value, values = data.maps[which];
  const [c, width, height] = prepared("heat", Math.max(240, Math.min(480, document.getElementById("heat").clientWidth * 0.62)));
  const s = floorScale(width, height), top = largest(values.flat()), side = data.mapCell;
  values.forEach((row, j) => row.forEach((v, i) => {
    if (!v) return;
    c.globalAlpha = 0.15 + 0.85 * Math.sqrt(v / top); c.fillStyle = which === "density" ? colours[0] : "#c0392b";
    c.fillRect(s.x(data.mapOrigin[0] + i * side), s.y(data.mapOrigin[1] + (j + 1) * side), s.k * side + 0.6, s.k * side + 0.6);
  }));
  c.globalAlpha = 1; grid(c, s, width, height);
  document.getElementById("most").textContent = top.toPrecision(2) + (which === "density" ? " persons per m²" : " person-seconds per m²");
}
function drawAll() {
  if (document.getElementById("floor")) drawFloor();
  drawTimeline();
  if (document.getElementById("curve")) drawPair();
  if (document.getElementById("heat")) drawHeat();
}
function go(t) { now = t; if (document.getElementById("floor")) drawFloor(); drawTimeline(); if (document.getElementById("curve")) drawPair(); }
function tick(stamp) {
  if (!playing) return;
  const end = data.t[data.t.length - 1];
  now += last ? (stamp - last) / 1000 * +document.getElementById("speed").value : 0; last = stamp;
  if (now >= end) { now = data.t[0]; }
  go(now); requestAnimationFrame(tick);
}
for (const [id, act] of [["limit", drawTimeline], ["apart", drawTimeline], ["pair", drawPair], ["map", drawHeat]]) {
  const box = document.getElementById(id); if (box) box.addEventListener("change", act);
}
const play = document.getElementById("play");
if (play) {
  play.addEventListener("click", () => { playing = !playing; last = 0; play.textContent = playing ? "Pause" : "Play"; if (playing) requestAnimationFrame(tick); });
  document.getElementById("when").addEventListener("input", e => go(+e.target.value));
}
addEventListener("resize", drawAll);
drawAll();
