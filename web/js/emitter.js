// Events with typed data.

/**
 * An `EventTarget` whose events are the members of `E`, each with the type of its detail.
 * @template {Record<string, unknown>} E
 */
export class Emitter extends EventTarget {
  /**
   * Calls `action` with the detail of each event of a type.
   * @template {keyof E & string} K
   * @param {K} type
   * @param {(detail: E[K]) => void} action
   * @param {AddEventListenerOptions} [options]
   */
  on(type, action, options) {
    this.addEventListener(type, (event) => action(/** @type {CustomEvent<E[K]>} */ (event).detail), options);
  }

  /**
   * @template {keyof E & string} K
   * @param {K} type
   * @param {E[K]} detail
   */
  emit(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }
}
