// The history of the page, in the page: no server is asked. A case throws when it does not hold.

import assert from "node:assert/strict";
import { close, open } from "./browser.mjs";

/** The history of the page: eleven minutes at 1 ms, exact values and extrema, gaps and restarts told. In the page. */
export async function the_history_is_exact({ browser, url }) {
  const page = await open(browser, url, "machine");
  const found = await page.evaluate(async () => {
    const { Samples } = await import("/assets/js/samples.js");
    const wrong = [];
    const expect = (what, value, wanted) => Object.is(value, wanted) || wrong.push(`${what}: ${value}, expected ${wanted}`);
    const samples = new Samples({ period_s: 0.001, axes: [{ name: "X" }], coordinate_systems: [{ name: "CS" }] });
    // Whole numbers, which 32-bit floats hold exactly.
    const command = (tick) => ((tick * 7919) % 100_003) - 50_000;
    const speed = (tick) => (tick * 31) % 1009;
    const frame = (first, count) => {
      const buffer = new ArrayBuffer(24 + 5 * 8 + count * 5 * 4);
      const view = new DataView(buffer);
      view.setUint32(0, 0x31435241, true);
      view.setUint32(4, count, true);
      view.setUint32(8, 5, true);
      view.setBigUint64(16, BigInt(first), true);
      view.setFloat64(24, 1000.5, true);
      for (let row = 0; row < count; row++) {
        const tick = first + row;
        [command(tick), 2 * tick % 64, tick % 5, command(tick) - 0.25, speed(tick)].forEach((value, k) => view.setFloat32(64 + 4 * (5 * row + k), value, true));
      }
      // The fourth signal has a base as well: the actual position lags by a quarter.
      view.setFloat64(48, 1000.5, true);
      return buffer;
    };
    const last = 800_000;
    for (let tick = 5; tick < last; tick += 4000) samples.add(frame(tick, Math.min(4000, last - tick)));
    expect("the newest", samples.end, last);
    if (samples.end - samples.first < 600_000) wrong.push(`only ${samples.end - samples.first} ticks are kept`);
    const { position, actual, error, jerk } = samples.axis("X");
    for (const tick of [samples.first, samples.first + 1, 400_000, last - 1]) {
      expect(`position at ${tick}`, position.at(tick), command(tick) + 1000.5);
      expect(`error at ${tick}`, error.at(tick), 0.25);
      expect(`actual at ${tick}`, actual.at(tick), command(tick) + 1000.25);
      expect(`path speed at ${tick}`, samples.system("CS").speed.at(tick), speed(tick));
    }
    expect("jerk", jerk.at(400_000), (0 - 4) / 0.001);
    expect("before the oldest", position.at(samples.first - 1), NaN);
    const pair = [0, 0];
    for (const [from, length, bucket] of [[400_000, 64, 16], [400_000, 160, 16], [399_872, 512, 256], [300_032, 256_000, 256], [400_001, 37, 1]]) {
      const values = Array.from({ length }, (_, k) => speed(from + k));
      samples.system("CS").speed.extrema(from, from + length, bucket, pair);
      expect(`least of ${length} from ${from}`, pair[0], values.reduce((a, b) => Math.min(a, b)));
      expect(`greatest of ${length} from ${from}`, pair[1], values.reduce((a, b) => Math.max(a, b)));
    }
    // The past, a few ticks at a time: a signal that rises by its tick, with a peak in the second piece.
    const late = new Samples({ period_s: 0.001, axes: [{ name: "X" }], coordinate_systems: [] });
    const live = (first) => {
      const buffer = new ArrayBuffer(24 + 4 * 8 + 4 * 4);
      const view = new DataView(buffer);
      [0x31435241, 1, 4, 0].forEach((word, k) => view.setUint32(4 * k, word, true));
      view.setBigUint64(16, BigInt(first), true);
      [first, 1, 0, first - 2].forEach((base, k) => view.setFloat64(24 + 8 * k, base, true));
      return buffer;
    };
    const piece = (first, every, rows, signals, each) => {
      const buffer = new ArrayBuffer(24 + signals * 8 + rows * signals * each.length * 4);
      const view = new DataView(buffer);
      [0x32435241, rows, signals, every].forEach((word, k) => view.setUint32(4 * k, word, true));
      view.setBigUint64(16, BigInt(first), true);
      const bases = [first, 1, 0, first - 2, 7, 2].slice(0, signals);
      bases.forEach((base, k) => view.setFloat64(24 + 8 * k, base, true));
      const at = 24 + 8 * signals;
      for (let row = 0; row < rows; row++) {
        for (let k = 0; k < signals; k++) each.forEach((of, which) => view.setFloat32(at + 4 * ((row * signals + k) * each.length + which), of(row, k), true));
      }
      return buffer;
    };
    const rising = (row, k) => (k === 0 || k === 3 ? row * 16 : 0);
    const peak = (row, k) => (k === 0 || k === 3 ? row * 16 + 15 : k === 4 && row === 1 ? 1000 : 0);
    late.add(live(1000));
    expect("nothing is known before", late.axis("X").position.at(999), NaN);
    late.fill(piece(990, 1, 10, 4, [(row, k) => (k === 0 || k === 3 ? row : 0)]), 1000);
    expect("a piece of every tick", late.axis("X").position.at(995), 995);
    expect("and its error", late.axis("X").error.at(995), 2);
    late.fill(piece(960, 16, 2, 6, [rising, rising, peak]), 990);
    const x = late.axis("X");
    expect("the oldest", late.first, 960);
    for (const tick of [960, 970, 976]) expect(`a straight line at ${tick}`, x.position.at(tick), tick);
    expect("its last value stays", x.position.at(989), 976);
    expect("every tick is known here", late.step(995), 1);
    expect("not here", late.step(970), 16);
    const [low, high] = x.jerk.extrema(960, 992, 16, [0, 0]);
    expect("least jerk", low, 0);
    expect("greatest jerk", high, 1007);
    expect("what is live stays", x.position.at(1000), 1000);
    samples.add(frame(last + 100, 10));
    expect("in a gap", position.at(last + 50), NaN);
    expect("behind a gap", position.at(last + 105), command(last + 105) + 1000.5);
    samples.system("CS").speed.extrema(last, last + 100, 1, pair);
    expect("least of a gap", pair[0], NaN);
    samples.add(frame(0, 40));
    expect("the server began again", samples.end, 40);
    expect("and nothing older is left", samples.first, 0);
    return wrong;
  });
  assert.deepEqual(found, []);
  await close(page);
}
