// Saves the displayed data as a file: CSV with every tick, or the picture. No data leaves the computer.

import { clock } from "./format.js";

/** @import { Samples, Series } from "./samples.js" */

const MOST_ROWS = 700_000;

/**
 * The ticks `from` to before `to` as CSV, those that are known: `tick,time_s` and a column for each `{name, series}`.
 * @param {Samples} samples
 * @param {{ name: string, series: Series }[]} columns
 * @param {number} from
 * @param {number} to
 */
export function csv(samples, columns, from, to) {
  const first = Math.max(Math.ceil(from), samples.first, Math.floor(to) - MOST_ROWS);
  const lines = [["tick", "time_s", ...columns.map(({ name }) => name)].join(",")];
  for (let tick = first; tick < Math.min(to, samples.end); tick++) {
    if (tick % samples.step(tick)) continue;
    const values = columns.map(({ series }) => {
      const value = series.at(tick);
      return Number.isNaN(value) ? "" : String(value);
    });
    lines.push([tick, Number(samples.time(tick).toFixed(9)), ...values].join(","));
  }
  return new Blob([lines.join("\n"), "\n"], { type: "text/csv" });
}

/** Offers a file to be saved. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const address = URL.createObjectURL(blob);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Saves the picture of a canvas as PNG. @param {HTMLCanvasElement} canvas @param {string} name */
export function savePicture(canvas, name) {
  canvas.toBlob((blob) => blob && save(blob, name), "image/png");
}

/** A name for a file, from its content and the moment. @param {string} what @param {Samples} samples @param {number} tick @param {string} ending */
export function fileName(what, samples, tick, ending) {
  return `arcline-${what}-${clock(samples.time(tick), 1).replaceAll(":", "-")}.${ending}`;
}
