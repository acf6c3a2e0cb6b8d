// A canvas that is as large as its place and as fine as the screen, drawn once a frame while it is seen.

const FINEST = 2;

/** A canvas in `host`; `draw(context, width, height)` is called before each frame in pixels of the style sheet. */
export class Stage {
  /** Called with the new width and height. @type {((width: number, height: number) => void) | null} */
  onresize = null;
  #running = false;
  #dirty = true;

  /**
   * @param {HTMLElement} host
   * @param {(context: CanvasRenderingContext2D, width: number, height: number) => void} draw
   * @param {Record<string, string>} attributes
   */
  constructor(host, draw, attributes) {
    this.element = document.createElement("canvas");
    for (const [name, value] of Object.entries(attributes)) this.element.setAttribute(name, value);
    this.context = /** @type {CanvasRenderingContext2D} */ (this.element.getContext("2d"));
    this.draw = draw;
    this.width = 0;
    this.height = 0;
    host.append(this.element);
    new ResizeObserver(([entry]) => this.#resize(entry.contentRect)).observe(host);
  }

  /** @param {DOMRectReadOnly} size */
  #resize({ width, height }) {
    const ratio = Math.min(FINEST, devicePixelRatio || 1);
    this.width = Math.max(1, Math.round(width));
    this.height = Math.max(1, Math.round(height));
    this.element.width = Math.round(this.width * ratio);
    this.element.height = Math.round(this.height * ratio);
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.onresize?.(this.width, this.height);
    this.#dirty = true;
    this.paint();
  }

  /** Draws at once, for a picture that is taken or a place that has changed its size. */
  paint() {
    if (this.width > 1 && this.height > 1) {
      this.#dirty = false;
      this.draw(this.context, this.width, this.height);
    }
  }

  /** Asks for a picture before the next frame. */
  touch() {
    this.#dirty = true;
  }

  /** Draws while it is seen: in every frame if `live()` holds, else when it was touched. @param {() => boolean} live */
  start(live) {
    if (this.#running) return;
    this.#running = true;
    this.#dirty = true;
    const frame = () => {
      if (!this.#running) return;
      if (this.#dirty || live()) this.paint();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  /** Draws no more until `start`. */
  stop() {
    this.#running = false;
  }
}

/**
 * Pointers on an element: `drag(dx, dy, event, fingers)`, `zoom(factor, x, y)` by wheel or two fingers, `tap(x, y, event)`.
 * @param {HTMLElement} element
 * @param {object} handlers
 * @param {(dx: number, dy: number, event: PointerEvent, fingers: number) => void} handlers.drag
 * @param {(factor: number, x: number, y: number, event?: WheelEvent) => void} handlers.zoom
 * @param {(x: number, y: number, event: PointerEvent) => void} [handlers.tap]
 * @param {(event: PointerEvent) => void} [handlers.start]
 * @param {() => void} [handlers.end]
 */
export function gestures(element, { drag, zoom, tap, start, end }) {
  const fingers = new Map();
  let moved = 0;
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    moved = 0;
    start?.(event);
  });
  element.addEventListener("pointermove", (event) => {
    const last = fingers.get(event.pointerId);
    if (!last) return;
    const place = [event.offsetX, event.offsetY];
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    fingers.set(event.pointerId, place);
    const [dx, dy] = [place[0] - last[0], place[1] - last[1]];
    moved += Math.abs(dx) + Math.abs(dy);
    if (other) {
      const spread = (/** @type {number[]} */ a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      zoom(spread(place) / spread(last), (place[0] + other[0]) / 2, (place[1] + other[1]) / 2);
      drag(dx / 2, dy / 2, event, 2);
    } else {
      drag(dx, dy, event, 1);
    }
  });
  const up = (/** @type {PointerEvent} */ event) => {
    if (fingers.delete(event.pointerId) && moved < 4) tap?.(event.offsetX, event.offsetY, event);
    if (!fingers.size) end?.();
  };
  element.addEventListener("pointerup", up);
  element.addEventListener("pointercancel", up);
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 20 : 1;
    zoom(Math.exp(-event.deltaY * lines * 0.0016), event.offsetX, event.offsetY, event);
  }, { passive: false });
}
