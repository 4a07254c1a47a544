// Numbers as people type them: a comma or a point before the decimals, and nothing guessed.

export class NotANumber extends Error {}

// The number in a text field, null where it is empty; throws NotANumber, with what to write, for anything else.
export function typedNumber(text) {
  const trimmed = text.trim();
  if (trimmed === "") return null;
  if (!/^\d+([.,]\d+)?$/.test(trimmed)) throw new NotANumber(`"${trimmed.slice(0, 20)}" is not a number: write it like 50 or 50,5`);
  const value = Number(trimmed.replace(",", "."));
  if (value === 0) throw new NotANumber("A length must be more than 0.");
  return value;
}

// A length or, `signed`, a coordinate in metres; throws NotANumber for anything else, emptiness included.
export function typedMetres(text, signed = false) {
  const trimmed = text.trim().replace(/^[−–]/, "-");
  const fits = signed ? /^-?\d+([.,]\d+)?$/ : /^\d+([.,]\d+)?$/;
  if (!fits.test(trimmed)) throw new NotANumber(`"${trimmed.slice(0, 20)}" is no number of metres: write it like 2.4 or 2,4`);
  const value = Number(trimmed.replace(",", "."));
  if (!signed && value === 0) throw new NotANumber("A distance must be more than 0.");
  return value;
}

// Lenses for photos of people; what lies outside is asked about, not refused.
export const USUAL_35MM = [8, 800];
const DIAGONAL_35MM = Math.hypot(36, 24);

// The 35 mm equivalent of a stated focal length, by the diagonals of sensor or picture.
export function equivalentOf(stated, width, height) {
  if ("focal_35mm" in stated) return stated.focal_35mm;
  if ("focal_mm" in stated) return (stated.focal_mm * DIAGONAL_35MM) / Math.hypot(...stated.sensor_mm);
  return (stated.focal_px * DIAGONAL_35MM) / Math.hypot(width, height);
}
