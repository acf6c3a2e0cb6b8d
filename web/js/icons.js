// The pictures of the page as one hidden sprite, so that no view needs a request of its own. 24 by 24, drawn with strokes.

const SHAPES = {
  arc: "M4 19h6A9 9 0 0 0 19 10V4|M19 4m-2 0a2 2 0 1 0 4 0a2 2 0 1 0-4 0",
  stop: "M8 3h8l5 5v8l-5 5H8l-5-5V8z|M9 9h6v6H9z",
  machine: "M3 5h18v11H3z|M8 20h8M12 16v4M7 12l3-3 3 2 4-4",
  path: "M4 19c0-9 6-4 8-9s2-6 8-6|M4 19m-1.6 0a1.6 1.6 0 1 0 3.2 0a1.6 1.6 0 1 0-3.2 0|M20 4m-1.6 0a1.6 1.6 0 1 0 3.2 0a1.6 1.6 0 1 0-3.2 0",
  trends: "M3 3v18h18|M6 15l4-5 4 3 6-8",
  drive: "M12 3v18M3 12h18|M12 3l-2.5 3h5zM12 21l-2.5-3h5zM3 12l3-2.5v5zM21 12l-3-2.5v5z",
  program: "M8 7l-5 5 5 5M16 7l5 5-5 5M14 4l-4 16",
  ladder: "M4 3v18M20 3v18M4 8h5M15 8h5M9 5v6M15 5v6M4 17h6M14 17h6M10 17a2 2.5 0 0 1 4 0a2 2.5 0 0 1-4 0",
  tags: "M3 12V4a1 1 0 0 1 1-1h8l9 9-9 9z|M8 8m-1 0a1 1 0 1 0 2 0a1 1 0 1 0-2 0",
  events: "M4 6h2M4 12h2M4 18h2M9 6h11M9 12h11M9 18h11",
  pause: "M8 5v14M16 5v14",
  live: "M5 5l9 7-9 7zM18 5v14",
  run: "M7 4l12 8-12 8z",
  step: "M5 5l8 7-8 7zM17 5v14",
  eye: "M2 12s4-7 10-7 10 7 10 7-4 7-10 7S2 12 2 12z|M12 12m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0",
  copy: "M9 9h11v11H9z|M5 15H4V4h11v1",
  save: "M12 3v12M7 10l5 5 5-5M4 20h16",
  open: "M12 15V3M7 8l5-5 5 5M4 20h16",
  fit: "M4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5",
  close: "M5 5l14 14M19 5L5 19",
  check: "M4 12l5 6L20 6",
  warning: "M12 3L2 20h20z|M12 10v4M12 17v.5",
  lock: "M5 11h14v10H5z|M8 11V8a4 4 0 0 1 8 0v3",
  unlock: "M5 11h14v10H5z|M8 11V7a4 4 0 0 1 7.7-1.5",
  home: "M3 11l9-8 9 8M6 9v11h12V9",
  reset: "M4 4v6h6M4.6 10A8 8 0 1 1 4 14",
  star: "M12 3l2.7 6 6.3.6-4.8 4.3 1.4 6.4L12 17l-5.6 3.3 1.4-6.4L3 9.6 9.3 9z",
  right: "M9 5l7 7-7 7",
  sun: "M12 12m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0|M12 2v2M12 20v2M2 12h2M20 12h2M5 5l1.4 1.4M17.6 17.6L19 19M5 19l1.4-1.4M17.6 6.4L19 5",
  moon: "M20 14A8.5 8.5 0 1 1 10 4a7 7 0 0 0 10 10z",
  auto: "M12 3a9 9 0 1 0 0 18z|M12 3a9 9 0 0 1 0 18",
};

const SVG = "http://www.w3.org/2000/svg";

/** The sprite, to be put into the page once. */
export function sprite() {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "sprite");
  svg.setAttribute("aria-hidden", "true");
  for (const [name, shape] of Object.entries(SHAPES)) {
    const symbol = document.createElementNS(SVG, "symbol");
    symbol.setAttribute("id", `i-${name}`);
    symbol.setAttribute("viewBox", "0 0 24 24");
    for (const line of shape.split("|")) {
      const path = document.createElementNS(SVG, "path");
      path.setAttribute("d", line);
      symbol.append(path);
    }
    svg.append(symbol);
  }
  return svg;
}
