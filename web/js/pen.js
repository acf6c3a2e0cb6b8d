// A line over a canvas from many points, of which only those are drawn that make a difference.

/** How far a point may be from the line that is drawn, in pixels upwards or downwards. */
export const TOLERANCE = 0.15;

/** Draws points from left to right: a point that the straight line to a later one passes within `TOLERANCE` is left out. */
export class Pen {
  /** @param {Pick<CanvasRenderingContext2D, "moveTo" | "lineTo">} context */
  constructor(context) {
    this.context = context;
    /** Whether a line is drawn, and its last point. */
    this.isDown = false;
    this.x = 0;
    this.y = 0;
    /** Whether there is a point behind it that is not drawn yet, and that point. */
    this.waits = false;
    this.nextX = 0;
    this.nextY = 0;
    /** The slopes of the lines from the last point that pass all points since. */
    this.least = -Infinity;
    this.greatest = Infinity;
  }

  /** Goes to a point, or begins a line there. @param {number} x @param {number} y */
  to(x, y) {
    if (!this.isDown) {
      this.context.moveTo(x, y);
      this.isDown = true;
      this.#begin(x, y);
      return;
    }
    const slope = (y - this.y) / (x - this.x);
    if (this.waits && !(slope >= this.least && slope <= this.greatest)) this.#draw();
    const wide = x - this.x;
    this.least = Math.max(this.least, (y - TOLERANCE - this.y) / wide);
    this.greatest = Math.min(this.greatest, (y + TOLERANCE - this.y) / wide);
    this.waits = true;
    this.nextX = x;
    this.nextY = y;
  }

  /** Ends the line. */
  lift() {
    if (this.waits) this.#draw();
    this.isDown = false;
  }

  #draw() {
    this.context.lineTo(this.nextX, this.nextY);
    this.#begin(this.nextX, this.nextY);
  }

  /** @param {number} x @param {number} y */
  #begin(x, y) {
    this.x = x;
    this.y = y;
    this.waits = false;
    this.least = -Infinity;
    this.greatest = Infinity;
  }
}
