// A line over a canvas from many points, of which only those are drawn that make a difference.

/** How far a point may be from the line that is drawn, in pixels upwards or downwards. */
export const TOLERANCE = 0.15;

/** Draws points from left to right: a point that the straight line to a later one passes within `TOLERANCE` is left out. */
export class Pen {
  /** @param {Pick<CanvasRenderingContext2D, "moveTo" | "lineTo">} context */
  constructor(context) {
    this.context = context;
    /** The last point that was drawn. @type {[number, number] | null} */
    this.drawn = null;
    /** The point after it that is not drawn yet. @type {[number, number] | null} */
    this.waiting = null;
    /** The slopes of the lines from `drawn` that pass all points since. */
    this.least = -Infinity;
    this.greatest = Infinity;
  }

  /** Goes to a point, or begins a line there. @param {number} x @param {number} y */
  to(x, y) {
    if (!this.drawn) {
      this.context.moveTo(x, y);
      this.drawn = [x, y];
      return;
    }
    if (this.waiting) {
      const slope = (y - this.drawn[1]) / (x - this.drawn[0]);
      if (!(slope >= this.least && slope <= this.greatest)) this.#draw();
    }
    const [fromX, fromY] = this.drawn;
    const wide = x - fromX;
    this.least = Math.max(this.least, (y - TOLERANCE - fromY) / wide);
    this.greatest = Math.min(this.greatest, (y + TOLERANCE - fromY) / wide);
    this.waiting = [x, y];
  }

  /** Ends the line. */
  lift() {
    if (this.waiting) this.#draw();
    this.drawn = null;
  }

  #draw() {
    const [x, y] = /** @type {[number, number]} */ (this.waiting);
    this.context.lineTo(x, y);
    this.drawn = [x, y];
    this.waiting = null;
    this.least = -Infinity;
    this.greatest = Infinity;
  }
}
