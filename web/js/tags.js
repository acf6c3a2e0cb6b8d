// The view of the tags: search, browse with pages, a list of watched values, and writing.

import { refusalOf } from "./connection.js";
import { calm, fill, h, icon, text } from "./dom.js";
import { plain } from "./format.js";
import { keep } from "./keep.js";

/** @import { TagRow } from "../types/protocol.js" */

const KEY = "arcline.watch";
const SEARCH_MS = 150;
const MOST_WATCHED = 64;

export class Tags {
  title = "Tags";
  /** @type {Map<string, HTMLElement>} */
  #rows = new Map();
  /** Access of the tags that were listed, by name in lower case. @type {Map<string, TagRow["access"]>} */
  #access = new Map();
  /** Watched names that cannot be written, as the server said. @type {Set<string>} */
  #readOnly = new Set();

  /** @param {import("./app.js").App} app */
  constructor(app) {
    this.app = app;
    this.watched = (keep.list(KEY) ?? []).slice(0, MOST_WATCHED);
    this.search = h("input", { type: "search", placeholder: "Search, for example Move or CS1.*", "aria-label": "Search tags", autocomplete: "off", spellcheck: "false",
      oninput: calm(SEARCH_MS, () => this.#list()) });
    this.table = h("tbody");
    this.more = h("button", { type: "button", hidden: true, onclick: () => this.#list(this.last) }, "More");
    this.count = h("small", { role: "status" });
    this.watch = h("tbody");
    this.empty = h("p.empty", {}, "No watched tags. Press a star, or type a name above.");
    this.add = h("input", { type: "text", placeholder: "Move1.PC", "aria-label": "Name of a tag or member to watch", autocomplete: "off", spellcheck: "false",
      onkeydown: (event) => event.key === "Enter" && this.#add() });
    const heard = (/** @type {string} */ name) => h("span.heard", {}, name);
    const head = (/** @type {(string | HTMLElement)[]} */ ...names) => h("thead", {}, h("tr", {}, names.map((name) => h("th", { scope: "col" }, name))));
    this.watchTable = h("div.scroll", {}, h("table", {}, head("Name", "Value", "Write", heard("Stop watching")), this.watch));
    this.element = h("section.view.tags", { "aria-label": this.title },
      h("div.panel.tag-list", {}, h("div.row", {}, h("h2", {}, "Tags"), this.search, this.count),
        h("div.scroll", {}, h("table", {}, head(heard("Value"), "Name", "Type", "Access", heard("Watch")), this.table), this.more)),
      h("div.panel.watch-list", {}, h("div.row", {}, h("h2", {}, "Watched"), this.add, h("button", { type: "button", onclick: () => this.#add() }, "Watch")),
        this.empty, this.watchTable));
    app.store.on("values", (values) => this.#values(values));
    app.connection.on("open", () => this.element.isConnected && this.show());
    this.#showWatched();
  }

  show() {
    this.#list();
    this.#watchAll();
  }

  hide() {
    this.app.connection.tell("watch", { names: [] });
  }

  /** @param {string} [after] The name behind which the list begins. */
  async #list(after) {
    if (!this.app.connection.isOpen) return;
    const pattern = this.search.value.trim();
    try {
      const { tags, more } = await this.app.connection.request("tags", { pattern, after });
      if (pattern !== this.search.value.trim()) return;
      if (!after) fill(this.table);
      for (const tag of tags) {
        this.#access.set(tag.name.toLowerCase(), tag.access);
        this.table.append(...this.#tag(tag));
      }
      if (this.watched.some((name) => this.#isReadOnly(name) && !this.#rows.get(name)?.classList.contains("read-only"))) this.#showWatched();
      this.last = tags.at(-1)?.name;
      this.more.hidden = !more;
      text(this.count, `${this.table.querySelectorAll("tr.tag").length}${more ? " and more" : ""}`);
    } catch (error) {
      // The list is read again with the next connection.
      if (this.app.connection.isOpen) this.app.toasts.bad("The tags cannot be listed", error);
    }
  }

  /** @param {TagRow} tag */
  #tag(tag) {
    const dims = tag.dims?.length ? `[${tag.dims.join(", ")}]` : "";
    const detail = h("tr.tag-detail", { hidden: true });
    const open = h("button.bare", { type: "button", "aria-expanded": "false", "aria-label": `Value of ${tag.name}`, onclick: () => {
      this.#expand(tag, open, detail);
    } }, icon("right"));
    const row = h("tr.tag", {}, h("td", {}, open), h("th", { scope: "row" }, breakable(tag.name)), h("td.type", {}, `${tag.type}${dims}`), h("td", {}, tag.access ?? ""),
      h("td", {}, this.#star(tag.name)));
    return [row, detail];
  }

  /** @param {string} name */
  #star(name) {
    return h("button.bare", { type: "button", title: "Watch", "aria-label": `Watch ${name}`, onclick: () => this.#watchOne(name) }, icon("star"));
  }

  /** @param {TagRow} tag @param {HTMLElement} open @param {HTMLElement} detail */
  async #expand(tag, open, detail) {
    const shown = open.getAttribute("aria-expanded") === "true";
    open.setAttribute("aria-expanded", String(!shown));
    detail.hidden = shown;
    if (shown) return;
    try {
      const { values } = await this.app.connection.request("read", { names: [tag.name] });
      const parts = members(tag.name, values[tag.name]);
      fill(detail, h("td", { colspan: 5 }, h("dl.members", {}, parts.map(([name, value]) => [
        h("dt", {}, this.#star(name), name === tag.name ? "value" : name.slice(tag.name.length)), h("dd.number", {}, plain(value))]))));
    } catch (error) {
      fill(detail, h("td.bad", { colspan: 5 }, refusalOf(error).text));
    }
  }

  #add() {
    const name = this.add.value.trim();
    if (name) this.#watchOne(name);
    this.add.value = "";
  }

  /** @param {string} name */
  #watchOne(name) {
    if (this.watched.includes(name) || this.watched.length >= MOST_WATCHED) return;
    this.watched.push(name);
    this.#showWatched();
    this.#watchAll();
  }

  /** @param {string} name */
  #unwatch(name) {
    this.watched = this.watched.filter((other) => other !== name);
    this.#showWatched();
    this.#watchAll();
  }

  async #watchAll() {
    keep.set(KEY, JSON.stringify(this.watched));
    if (!this.element.isConnected || !this.app.connection.isOpen) return;
    try {
      const { read_only: names } = await this.app.connection.request("watch", { names: this.watched });
      const known = this.watched.filter((name) => this.#isReadOnly(name)).length;
      this.#readOnly = new Set(names);
      if (this.watched.filter((name) => this.#isReadOnly(name)).length !== known) this.#showWatched();
    } catch (error) {
      if (this.app.connection.isOpen) this.app.toasts.bad("These tags cannot be watched", error);
    }
  }

  #showWatched() {
    this.empty.hidden = this.watched.length > 0;
    this.watchTable.hidden = !this.watched.length;
    this.#rows.clear();
    fill(this.watch, this.watched.map((name) => {
      const value = h("td.number.value", {}, "–");
      const readOnly = this.#isReadOnly(name);
      if (readOnly) value.classList.add("read-only");
      const input = h("input", { type: "text", "aria-label": `New value of ${name}`, placeholder: "New value", autocomplete: "off", onkeydown: (event) => {
        if (event.key === "Enter") this.#write(name, input);
      } });
      this.#rows.set(name, value);
      return h("tr", {}, h("th", { scope: "row" }, breakable(name)), value,
        h("td", {}, readOnly ? h("small", {}, "read only") : h("span.pair", {}, input, h("button", { type: "button", onclick: () => this.#write(name, input) }, "Write"))),
        h("td", {}, h("button.bare", { type: "button", "aria-label": `Stop watching ${name}`, onclick: () => this.#unwatch(name) }, icon("close"))));
    }));
  }

  /** Whether the tag at the beginning of a path is known to be read only. @param {string} name */
  #isReadOnly(name) {
    return this.#readOnly.has(name) || this.#access.get(tagOf(name)) === "read";
  }

  /** @param {Record<string, unknown>} values */
  #values(values) {
    for (const [name, value] of Object.entries(values ?? {})) {
      const cell = this.#rows.get(name);
      if (!cell) continue;
      const failed = value !== null && typeof value === "object" && "error" in value && typeof value.error === "string" ? value.error : null;
      text(cell, failed ?? plain(value));
      cell.classList.toggle("bad", failed !== null);
    }
  }

  /** @param {string} name @param {HTMLInputElement} input */
  async #write(name, input) {
    try {
      await this.app.connection.request("write", { tag: name, value: typed(input.value) });
      input.value = "";
      this.app.toasts.good(`${name} was written`);
    } catch (error) {
      this.app.toasts.bad(`${name} was not written`, error);
    }
  }
}

/** The tag that a path begins with, in small letters. @param {string} path */
function tagOf(path) {
  return (/^(program:[^.[]*\.)?[^.[]*/i.exec(path)?.[0] ?? path).toLowerCase();
}

/** A name that may be broken behind its parts, and nowhere else. @param {string} name */
function breakable(name) {
  return name.split(/(?<=[._:\]])/).flatMap((part) => [part, h("wbr")]);
}

/** A typed value: a number, true or false, a list or structure as JSON, otherwise text. @param {string} source */
function typed(source) {
  const plainText = source.trim();
  // A number of the browser would lose the last digits of a LINT.
  if (/^[+-]?\d+$/.test(plainText) && !Number.isSafeInteger(Number(plainText))) return plainText;
  try {
    return JSON.parse(plainText);
  } catch {
    if (/^(true|false)$/i.test(plainText)) return /^t/i.test(plainText);
    return plainText;
  }
}

/** A structure or array as names and values, one level of names at a time. @param {string} name @param {unknown} value @returns {[string, unknown][]} */
function members(name, value) {
  if (Array.isArray(value)) return value.slice(0, 256).flatMap((item, k) => members(`${name}[${k}]`, item));
  if (value !== null && typeof value === "object") return Object.entries(value).flatMap(([member, item]) => members(`${name}.${member}`, item));
  return [[name, value]];
}
