// Elements made by hand. Text is always set as text: a file name is never markup.

const SVG = "http://www.w3.org/2000/svg";

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "text") element.textContent = value;
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((c) => c !== null && c !== undefined && c !== false));
  return element;
}

export const html = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);
export const svg = (tag, attributes = {}, ...children) =>
  filled(document.createElementNS(SVG, tag), attributes, children);

let fading;

export function tell(text, problem = false) {
  const status = document.getElementById("status");
  status.textContent = text;
  status.className = problem ? "shown problem" : "shown";
  clearTimeout(fading);
  fading = setTimeout(() => (status.className = ""), problem ? 7000 : 2600);
}

// As in the figures: the decimals that the interval supports, one where there is none.
export function metres(value, low = null, high = null) {
  if (value === null) return "unknown";
  const digits = low !== null && high !== null && high - low < 0.2 ? 2 : 1;
  const number = (v) => v.toFixed(digits);
  return low === null || high === null ? `${number(value)} m` : `${number(value)} m [${number(low)}, ${number(high)}]`;
}

/** A pair's distance with its interval; a question mark where only the interval is to be read. */
export const pairText = (p) => metres(p.distance_m, p.low_m, p.high_m) + (p.vague ? " ?" : "");

/** A pair's distance alone, or its ends where a bare number would claim too much. */
export const shortPairText = (p) => p.vague ? `${metres(p.low_m).replace(" m", "")}–${metres(p.high_m)} ?` : metres(p.distance_m, p.low_m, p.high_m).replace(/ \[.*/, "");

export const plural = (count, one, many) => `${count.toLocaleString("en")} ${count === 1 ? one : many}`;
