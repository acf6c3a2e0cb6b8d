// A text area with line numbers, colours, the line that runs, and errors at their place. It knows the
// syntax of Structured Text, not its meaning: the server finds the errors.

import { fill, h, property } from "./dom.js";

/**
 * An error of the text; line and column count from 1.
 * @typedef {{ line?: number | null, column?: number | null, text: string }} Problem
 */

const TOKENS = /(\/\/[^\n]*|\(\*[\s\S]*?(?:\*\)|$))|\b(IF|THEN|ELSIF|ELSE|END_IF|FOR|TO|BY|DO|END_FOR|WHILE|END_WHILE|WAIT|DELAY|AND|OR|NOT|XOR|MOD|TRUE|FALSE)\b|\b(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)\b|([A-Za-z_][A-Za-z0-9_]*)(?=\s*\()/gi;

/** An editor; `onchange(text)` after every change. */
export class Editor {
  /** @type {Problem[]} */
  #errors = [];
  /** The line that runs. @type {number | null} */
  #line = null;

  /** @param {{ mnemonics: string[], onchange: (text: string) => void, label: string }} options */
  constructor({ mnemonics, onchange, label }) {
    this.mnemonics = new Set(mnemonics);
    this.onchange = onchange;
    this.gutter = h("div.editor-gutter", { "aria-hidden": "true" });
    this.colours = h("pre.editor-colours", { "aria-hidden": "true" });
    this.area = h("textarea.editor-area", {
      spellcheck: "false", autocomplete: "off", autocapitalize: "off", wrap: "off", "aria-label": label,
      oninput: () => this.#changed(), onscroll: () => this.#follow(), onkeydown: (event) => this.#key(event),
    });
    this.messages = h("ul.editor-errors", { "aria-live": "polite" });
    this.element = h("div.editor", {}, h("div.editor-box", {}, this.gutter, h("div.editor-text", {}, this.colours, this.area)), this.messages);
  }

  get text() {
    return this.area.value;
  }

  set text(value) {
    this.area.value = value;
    this.#paint();
  }

  /** Shows errors `{line, column, text}`, both counted from 1. @param {Problem[]} errors */
  setErrors(errors) {
    this.#errors = errors;
    fill(this.messages, errors.map((error) => h("li", {},
      h("button", { type: "button", onclick: () => this.go(error.line ?? 1, error.column ?? 1) }, `Line ${error.line}`), " ", error.text)));
    this.#paint();
  }

  /** Shows the line that runs, `null` for none. @param {number | null} line */
  setLine(line) {
    if (line === this.#line) return;
    this.#line = line;
    this.#paint();
    if (line === null) return;
    const tall = parseFloat(getComputedStyle(this.area).lineHeight);
    const top = (line - 1) * tall;
    const { scrollTop, clientHeight } = this.area;
    if (top < scrollTop || top > scrollTop + clientHeight - 2 * tall) this.area.scrollTop = Math.max(0, top - clientHeight / 3);
  }

  /** Puts the caret to a place. @param {number} line @param {number} column */
  go(line, column = 1) {
    const lines = this.text.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, one) => sum + one.length + 1, 0) + Math.max(0, column - 1);
    this.area.focus();
    this.area.setSelectionRange(start, start);
  }

  #changed() {
    this.#paint();
    this.onchange(this.text);
  }

  /** Tab indents; Escape is the stop of the page, so Tab leaves with Alt held. @param {KeyboardEvent} event */
  #key(event) {
    if (event.key !== "Tab" || event.shiftKey || event.altKey || event.ctrlKey) return;
    event.preventDefault();
    this.area.setRangeText("  ", this.area.selectionStart, this.area.selectionEnd, "end");
    this.#changed();
  }

  #follow() {
    property(this.colours, "transform", `translate(${-this.area.scrollLeft}px, ${-this.area.scrollTop}px)`);
    property(this.gutter, "--scroll", `${-this.area.scrollTop}px`);
  }

  #paint() {
    const wrong = new Map(this.#errors.map((error) => [error.line, error]));
    const lines = coloured(this.text, this.mnemonics);
    fill(this.colours, lines.map((parts, k) => {
      const error = wrong.get(k + 1);
      const kind = [error && "wrong", k + 1 === this.#line && "running"].filter(Boolean).join(".");
      return h(kind ? `div.code-line.${kind}` : "div.code-line", {}, parts.length ? parts : "\u200b");
    }));
    fill(this.gutter, h("div.gutter-lines", {}, lines.map((_, k) => {
      const error = wrong.get(k + 1);
      return h(error ? "span.wrong" : k + 1 === this.#line ? "span.running" : "span", { title: error?.text }, String(k + 1));
    })));
    this.#follow();
  }
}

/** The text as lines of coloured parts. @param {string} source @param {Set<string>} mnemonics */
function coloured(source, mnemonics) {
  /** @type {(string | HTMLElement)[][]} */
  const lines = [[]];
  const put = (/** @type {string} */ piece, /** @type {string | null} */ kind = null) => piece.split("\n").forEach((part, k) => {
    if (k) lines.push([]);
    if (part) lines[lines.length - 1].push(kind ? h(`span.${kind}`, {}, part) : part);
  });
  let at = 0;
  for (const found of source.matchAll(TOKENS)) {
    const [whole, comment, keyword, number, call] = found;
    put(source.slice(at, found.index));
    const known = call && mnemonics.has(call.toUpperCase());
    put(whole, comment ? "c-comment" : keyword ? "c-keyword" : number ? "c-number" : known ? "c-call" : null);
    at = found.index + whole.length;
  }
  put(source.slice(at));
  return lines;
}
