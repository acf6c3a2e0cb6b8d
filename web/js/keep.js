// The choices that the browser stores for this page. If the browser does not allow that, a choice lasts as long as the page.
// Users can change the stored values, and an older page may have written them: every value is checked when it is read.

export const keep = {
  /** The text of a key, or `null`. @param {string} key */
  get(key) {
    try {
      return localStorage.getItem(key);
    } catch {
      return null;
    }
  },
  /** Keeps a text. @param {string} key @param {string} value */
  set(key, value) {
    try {
      localStorage.setItem(key, value);
    } catch {
      // A private window.
    }
  },
  /** The list of texts of a key, or `null` if there is none. @param {string} key @returns {string[] | null} */
  list(key) {
    return texts(parsed(keep.get(key)));
  },
  /** The lists of texts of a key by their names; a name without a list is absent. @param {string} key @returns {Record<string, string[]>} */
  lists(key) {
    const value = parsed(keep.get(key));
    if (value === null || typeof value !== "object" || Array.isArray(value)) return {};
    const named = Object.entries(value).map(([name, list]) => /** @type {const} */ ([name, texts(list)]));
    return Object.fromEntries(named.flatMap(([name, list]) => (list ? [[name, list]] : [])));
  },
};

/** @param {string | null} source @returns {unknown} */
function parsed(source) {
  if (source === null) return null;
  try {
    return JSON.parse(source);
  } catch {
    return null;
  }
}

/** @param {unknown} value @returns {string[] | null} */
function texts(value) {
  return Array.isArray(value) ? value.filter((item) => typeof item === "string") : null;
}
