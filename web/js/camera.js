// A parallel projection that is turned, moved and scaled. Pixels of the style sheet, y downwards; the world in position units.

/** A point of the world. @typedef {[number, number, number]} Point */
/** The least and the greatest coordinates of some points. @typedef {[low: Point, high: Point]} Box */
/** The pixel of a point. @typedef {(x: number, y: number, z: number) => [number, number]} Projection */
/** A look along an axis of the world. @typedef {"top" | "front" | "side"} Plane */
/** A fixed look. @typedef {keyof typeof LOOKS} Look */
/** The angles of a look, in radians. @typedef {{ turn: number, height: number }} Angles */

const RIGHT_ANGLE = Math.PI / 2;
/** Margins between a fitted picture and the edges of its area, and between it and elements that cover a part of it, pixels. */
const MARGIN = 56;
const CLEAR = 12;

/** The fixed looks: turn about the vertical and height of the eye, in radians. */
export const LOOKS = {
  top: { turn: 0, height: RIGHT_ANGLE },
  front: { turn: 0, height: 0 },
  side: { turn: RIGHT_ANGLE, height: 0 },
  space: { turn: -Math.PI / 5, height: Math.PI / 6 },
};

/** The direction and scale of the view. */
export class Camera {
  turn = 0;
  height = RIGHT_ANGLE;
  /** Pixels a unit. */
  scale = 1;
  /** The point of the world in the middle of the picture. */
  centre = [0, 0, 0];
  width = 1;
  tall = 1;

  /** Takes one of `LOOKS`. @param {Angles} angles */
  look({ turn, height }) {
    this.turn = turn;
    this.height = height;
  }

  /** Direction of the screen's x, of its upward y, and towards the eye, as unit vectors. */
  axes() {
    const [c, s] = [Math.cos(this.turn), Math.sin(this.turn)];
    const [lift, flat] = [Math.sin(this.height), Math.cos(this.height)];
    return {
      right: [c, s, 0],
      up: [-s * lift, c * lift, flat],
      eye: [s * flat, -c * flat, lift],
    };
  }

  /** A function that gives the pixel of a point; made once for a picture. @returns {Projection} */
  projection() {
    const { right, up } = this.axes();
    const [cx, cy, cz] = this.centre;
    const { scale, width, tall } = this;
    return (x, y, z) => {
      const [dx, dy, dz] = [x - cx, y - cy, z - cz];
      return [
        width / 2 + scale * (dx * right[0] + dy * right[1] + dz * right[2]),
        tall / 2 - scale * (dx * up[0] + dy * up[1] + dz * up[2]),
      ];
    };
  }

  /** Moves the picture by pixels. @param {number} dx @param {number} dy */
  pan(dx, dy) {
    const { right, up } = this.axes();
    for (let k = 0; k < 3; k++) this.centre[k] += (-dx * right[k] + dy * up[k]) / this.scale;
  }

  /** Turns the world under the pointer by pixels. @param {number} dx @param {number} dy */
  orbit(dx, dy) {
    this.turn -= dx * 0.008;
    this.height = Math.min(RIGHT_ANGLE, Math.max(-RIGHT_ANGLE, this.height + dy * 0.008));
  }

  /** Scales about a pixel, which keeps its place in the world. @param {number} factor @param {number} x @param {number} y */
  zoom(factor, x, y) {
    const scale = Math.min(1e6, Math.max(1e-6, this.scale * factor));
    const real = scale / this.scale;
    const [dx, dy] = [x - this.width / 2, y - this.tall / 2];
    this.pan(dx * (1 / real - 1), dy * (1 / real - 1));
    this.scale = scale;
    return real;
  }

  /**
   * Shows a box whole; below the elements that cover the top of the picture, where one would hide a corner of the box.
   * @param {Box} box
   * @param {{ left: number, right: number, bottom: number }[]} covers
   */
  fit(box, covers = []) {
    this.#fit(box, 0);
    if (!covers.length) return;
    const project = this.projection();
    const hidden = corners(box).some((corner) => {
      const [x, y] = project(...corner);
      return covers.some(({ left, right, bottom }) => x > left - CLEAR && x < right + CLEAR && y < bottom + CLEAR);
    });
    if (hidden) this.#fit(box, Math.max(...covers.map(({ bottom }) => bottom)) - MARGIN + CLEAR);
  }

  /** Shows a box whole, with `top` pixels free at the top beside the margin. @param {Box} box @param {number} top */
  #fit([low, high], top) {
    const { right, up } = this.axes();
    let [wide, tall] = [0, 0];
    for (let k = 0; k < 3; k++) {
      wide += Math.abs(right[k]) * (high[k] - low[k]);
      tall += Math.abs(up[k]) * (high[k] - low[k]);
      this.centre[k] = (low[k] + high[k]) / 2;
    }
    const across = Math.max(this.width - 2 * MARGIN, 20) / Math.max(wide, 1e-9);
    const along = Math.max(this.tall - 2 * MARGIN - top, 20) / Math.max(tall, 1e-9);
    this.scale = Math.min(across, along);
    this.pan(0, top / 2);
  }

  /** The look along an axis, which is a drawing in two dimensions; `null` of any other look. @returns {Plane | null} */
  get plane() {
    const level = Math.abs(Math.sin(2 * this.turn)) < 1e-6;
    if (level && Math.abs(this.height - RIGHT_ANGLE) < 1e-6) return "top";
    if (level && Math.abs(this.height) < 1e-6) return Math.abs(Math.sin(this.turn)) < 0.5 ? "front" : "side";
    return null;
  }
}

/** The eight corners of a box. @param {Box} box */
function corners([low, high]) {
  return [0, 1, 2, 3, 4, 5, 6, 7].map((which) => /** @type {Point} */ (low.map((value, k) => ((which >> k) & 1 ? high[k] : value))));
}
