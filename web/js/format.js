// Numbers, times and units as they are shown. Positions are in the axis's own units, times in seconds.

const MINUS = "\u2212";

/** A number with `decimals` decimals and a real minus sign; a dash if there is no number. @param {number} value @param {number} decimals */
export function fixed(value, decimals = 3) {
  if (!Number.isFinite(value)) return "–";
  const shown = Math.abs(value).toFixed(decimals);
  return (value < 0 && Number(shown) !== 0 ? MINUS : "") + shown;
}

/** A number in about five significant digits, for labels and cursors. @param {number} value */
export function short(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2).replace("-", MINUS).replace("e+", "e");
  const decimals = Math.max(0, Math.min(6, 4 - Math.floor(Math.log10(size))));
  return (value < 0 ? MINUS : "") + String(Number(size.toFixed(decimals)));
}

/** A number that reads back to the same value, for fields that are typed in. @param {number} value */
export function exact(value) {
  return Number.isFinite(value) ? String(Number(value.toPrecision(12))) : "";
}

/** Minutes and seconds: `12:34.567`. @param {number} seconds @param {number} decimals */
export function clock(seconds, decimals = 3) {
  if (!Number.isFinite(seconds)) return "–";
  const sign = seconds < 0 ? MINUS : "";
  const scale = 10 ** decimals;
  const whole = Math.round(Math.abs(seconds) * scale) / scale;
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor((whole % 3600) / 60);
  const rest = (whole % 60).toFixed(decimals).padStart(decimals ? decimals + 3 : 2, "0");
  const head = hours ? `${hours}:${String(minutes).padStart(2, "0")}` : String(minutes);
  return `${sign}${head}:${rest}`;
}

/** Date and time of the day of milliseconds since 1970, by the browser's time zone: `2026-11-22 14:03:22.123`. @param {number} milliseconds */
export function timestamp(milliseconds) {
  if (!Number.isFinite(milliseconds)) return "–";
  const date = new Date(milliseconds);
  const two = (/** @type {number} */ number, digits = 2) => String(number).padStart(digits, "0");
  const day = [date.getFullYear(), two(date.getMonth() + 1), two(date.getDate())].join("-");
  const time = [date.getHours(), date.getMinutes(), date.getSeconds()].map((part) => two(part)).join(":");
  return `${day} ${time}.${two(date.getMilliseconds(), 3)}`;
}

/** A duration: `850 ms`, `12.4 s`, `3:20`. @param {number} seconds */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const size = Math.abs(seconds);
  if (size < 1) return `${fixed(seconds * 1000, size < 0.01 ? 2 : 0)} ms`;
  if (size < 100) return `${fixed(seconds, size < 10 ? 3 : 1)} s`;
  return clock(seconds, 0);
}

/** A unit of an axis raised to a rate: `mm`, `mm/s`, `mm/s²`, `mm/s³`. @param {string} units @param {number} order */
export function rate(units, order) {
  return order === 0 ? units : `${units}/s${["", "", "²", "³"][order]}`;
}

/** A round step of 1, 2 or 5 times a power of ten that is at least `least`. @param {number} least */
export function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  for (const factor of [1, 2, 5]) if (factor * power >= least * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

/** Decimals that a multiple of `step` needs. @param {number} step */
export function decimals(step) {
  return Math.max(0, Math.min(9, -Math.floor(Math.log10(step) + 1e-9)));
}

/** A value of a tag as text that can be typed back. @param {unknown} value */
export function plain(value) {
  if (value === null || value === undefined) return "";
  if (typeof value === "object") return JSON.stringify(value);
  return String(value);
}
