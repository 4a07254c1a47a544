// Where labels go: each beside its line, off people where there is room, none over another (as in the figures).

const ALONG = [0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74];
// How far labels go from their lines: so many steps of a part of their height.
const RINGS = 20;
const STEP = 0.62;

const touch = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const boxAt = ([x, y], w, h) => [x - w / 2, y - h / 2, x + w / 2, y + h / 2];

const overlap = (a, b) => Math.max(0, Math.min(a[2], b[2]) - Math.max(a[0], b[0])) * Math.max(0, Math.min(a[3], b[3]) - Math.max(a[1], b[1]));

// items: {from, to, w, h} in order of preference; taken: boxes; avoid: {box, cost}, where covering all of a label with it
// costs so many heights of the label; bounds: box. Answers a centre or null for each: where its way and what it covers
// cost least.
export function place(items, taken, avoid, bounds) {
  const occupied = [...taken];
  return items.map((item) => {
    let best = null;
    for (const { centre, away } of candidates(item, bounds)) {
      if (best && away >= best.cost) break; // farther ones cost more, whatever they cover
      const box = boxAt(centre, item.w, item.h);
      if (occupied.some((other) => touch(box, other))) continue;
      const covered = avoid.reduce((sum, other) => sum + other.cost * overlap(box, other.box), 0) / (item.w * item.h);
      if (!best || away + covered < best.cost) best = { centre, box, cost: away + covered };
    }
    if (best) occupied.push(best.box);
    return best?.centre ?? null;
  });
}

function* candidates({ from, to, w, h }, bounds) {
  const way = [to[0] - from[0], to[1] - from[1]];
  const length = Math.hypot(...way);
  const normal = length > 0 ? [-way[1] / length, way[0] / length] : [0, 1];
  const inside = ([x, y]) => [
    Math.min(Math.max(x, bounds[0] + w / 2), bounds[2] - w / 2),
    Math.min(Math.max(y, bounds[1] + h / 2), bounds[3] - h / 2),
  ];
  for (let ring = 0; ring < RINGS; ring++) {
    for (const sign of ring ? [1, -1] : [1]) {
      for (const t of ALONG) {
        const shift = sign * ring * h * STEP;
        const centre = inside([from[0] + t * way[0] + shift * normal[0], from[1] + t * way[1] + shift * normal[1]]);
        yield { centre, away: ring * STEP };
      }
    }
  }
}

export function placeBadges(points, radius, bounds) {
  const occupied = [];
  const directions = [90, 60, 120, 30, 150, 0, 180].map((d) => [Math.cos((d * Math.PI) / 180), -Math.sin((d * Math.PI) / 180)]);
  return points.map(([x, y, reach]) => {
    for (let ring = 0; ring < 9; ring++) {
      for (const [dx, dy] of directions) {
        const distance = reach + radius * (1.2 + 0.5 * ring);
        const centre = [
          Math.min(Math.max(x + dx * distance, bounds[0] + radius), bounds[2] - radius),
          Math.min(Math.max(y + dy * distance, bounds[1] + radius), bounds[3] - radius),
        ];
        const box = boxAt(centre, 2 * radius, 2 * radius);
        if (occupied.some((other) => touch(box, other))) continue;
        occupied.push(box);
        return { centre, box };
      }
    }
    return null;
  });
}
