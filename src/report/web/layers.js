// How the layers of a picture (plot::Figure::live) are drawn, the lines apart, which uPlot draws. Lengths are in pixels of
// the canvas, `chart.ratio` of them in one of the page.

/// Dashes and markers tell series apart without colour; the still pictures have the same (plot/figure.cpp).
const lineDashes = [[], [7, 4], [2, 3], [9, 3, 2, 3], [4, 2], [12, 4]];
const dashOf = ({ dashed, shape = 0 }) => (dashed ? [6, 4] : lineDashes[shape % lineDashes.length]);
const markerPath = (shape, x, y, r) => [
  `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`,
  `M${x - r} ${y - r}h${2 * r}v${2 * r}h${-2 * r}z`,
  `M${x} ${y - 1.2 * r}l${1.2 * r} ${2.1 * r}h${-2.4 * r}z`,
  `M${x} ${y - 1.35 * r}l${1.2 * r} ${1.35 * r}l${-1.2 * r} ${1.35 * r}l${-1.2 * r} ${-1.35 * r}z`,
  `M${x - r} ${y - r}l${2 * r} ${2 * r}M${x + r} ${y - r}l${-2 * r} ${2 * r}`,
  `M${x} ${y + 1.2 * r}l${1.2 * r} ${-2.1 * r}h${-2.4 * r}z`,
][shape % 6];

const layerPainters = {
  bands(chart, context, { parts, colour: css }) {
    context.globalAlpha = 0.2;
    boxes(chart, context, parts, css, chart.box.top, chart.box.height, 1);
    context.globalAlpha = 1;
  },

  bars(chart, context, { parts, y, colour: css }) {
    boxes(chart, context, parts, css, chart.py(y) - 5.5 * chart.ratio, 11 * chart.ratio, 0.75);
  },

  level(chart, context, { y, colour: css, dashed, width }) {
    const { left, width: whole } = chart.box;
    strokeStyle(chart, context, css, width, dashed);
    segment(context, left, chart.py(y), left + whole, chart.py(y));
  },

  /// A solid, hatched as in mechanics.
  body(chart, context, { y, from, to, above }) {
    const left = chart.px(from), right = chart.px(to), surface = chart.py(y), depth = 11 * chart.ratio;
    const top = above ? surface - depth : surface;
    context.fillStyle = colour("var(--faint)");
    context.fillRect(left, top, right - left, depth);
    hatched(chart, context, left, top, right - left, depth, 6);
    strokeStyle(chart, context, "var(--ink)", 1.6);
    segment(context, left, surface, right, surface);
  },

  /// Upright, hatched on the side where the material is; an open one lets the bar pass.
  wall(chart, context, { x, right, open }) {
    const { top, height } = chart.box, at = chart.px(x), depth = 11 * chart.ratio;
    hatched(chart, context, right ? at : at - depth, top, depth, height, 7);
    strokeStyle(chart, context, "var(--ink)", 1.6, open);
    segment(context, at, top, at, top + height);
  },

  marks(chart, context, { x, y, shape = 0, colour: css }) {
    strokeStyle(chart, context, css, 1.2);
    context.fillStyle = colour(css);
    for (let i = 0; i < x.length; ++i) {
      const path = new Path2D(markerPath(shape, chart.px(x[i]), chart.py(y[i]), 3.5 * chart.ratio));
      context.fill(path);
      context.stroke(path);
    }
  },

  upright(chart, context, { x, colour: css, width, dashed, text }) {
    const { top, height } = chart.box, at = chart.px(x);
    strokeStyle(chart, context, css, width, dashed);
    segment(context, at, top, at, top + height);
    write(chart, context, text, at + 5 * chart.ratio, top + 14 * chart.ratio);
  },

  text(chart, context, { x, y, text }) {
    write(chart, context, text, chart.px(x) + 6 * chart.ratio, chart.py(y) - 6 * chart.ratio);
  },
};

/// Below the lines; the others above.
const lowerLayers = new Set(["bands", "bars", "level", "body", "map", "stress-map", "wall", "envelope"]);

function strokeStyle(chart, context, css, width, dashed = false) {
  context.strokeStyle = colour(css);
  context.lineWidth = width * chart.ratio;
  context.setLineDash(dashed ? [6 * chart.ratio, 4 * chart.ratio] : []);
}

/// Boxes over parts [begin, end, begin, end, ...] of x, none shorter than some pixels.
function boxes(chart, context, parts, css, top, height, least) {
  context.fillStyle = colour(css);
  for (let i = 0; i < parts.length; i += 2) {
    const from = chart.px(parts[i]);
    context.fillRect(from, top, Math.max(least * chart.ratio, chart.px(parts[i + 1]) - from), height);
  }
}

/// Strokes of 45 degrees in a rectangle.
function hatched(chart, context, left, top, width, height, pitch) {
  context.save();
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  strokeStyle(chart, context, "var(--soft)", 1);
  for (let along = 0; along < width + height; along += pitch * chart.ratio)
    segment(context, left + along - height, top + height, left + along, top);
  context.restore();
}

/// A straight line.
function segment(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

const fontOf = (chart, size) => `${size * chart.ratio}px ${getComputedStyle(document.body).fontFamily}`;

function write(chart, context, text, x, y, { css = "var(--soft)", align = "left", halo = false } = {}) {
  context.font = fontOf(chart, 12);
  context.textAlign = align;
  context.textBaseline = "alphabetic";
  if (halo) {
    strokeStyle(chart, context, "var(--paper)", 4);
    context.lineJoin = "round";
    context.strokeText(text, x, y);
  }
  context.fillStyle = colour(css);
  context.fillText(text, x, y);
}
