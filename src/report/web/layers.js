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
    const { top, height } = chart.box;
    context.fillStyle = colour(css);
    context.globalAlpha = 0.2;
    for (let i = 0; i < parts.length; i += 2) {
      const from = chart.px(parts[i]);
      context.fillRect(from, top, Math.max(chart.ratio, chart.px(parts[i + 1]) - from), height);
    }
    context.globalAlpha = 1;
  },

  bars(chart, context, { parts, y, colour: css }) {
    const middle = chart.py(y), half = 5.5 * chart.ratio;
    context.fillStyle = colour(css);
    for (let i = 0; i < parts.length; i += 2) {
      const from = chart.px(parts[i]);
      context.fillRect(from, middle - half, Math.max(0.75 * chart.ratio, chart.px(parts[i + 1]) - from), 2 * half);
    }
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
    context.save();
    context.beginPath();
    context.rect(left, top, right - left, depth);
    context.clip();
    context.fillStyle = colour("var(--faint)");
    context.fillRect(left, top, right - left, depth);
    strokeStyle(chart, context, "var(--soft)", 1);
    for (let x = left - depth; x < right; x += 6 * chart.ratio) segment(context, x, top + depth, x + depth, top);
    context.restore();
    strokeStyle(chart, context, "var(--ink)", 1.6);
    segment(context, left, surface, right, surface);
  },

  /// Upright, hatched on the side where the material is; an open one lets the bar pass.
  wall(chart, context, { x, right, open }) {
    const { top, height } = chart.box, at = chart.px(x), depth = (right ? 11 : -11) * chart.ratio;
    context.save();
    context.beginPath();
    context.rect(Math.min(at, at + depth), top, Math.abs(depth), height);
    context.clip();
    strokeStyle(chart, context, "var(--soft)", 1);
    for (let y = top; y < top + height + 12 * chart.ratio; y += 7 * chart.ratio)
      segment(context, Math.min(at, at + depth), y, Math.max(at, at + depth), y - 11 * chart.ratio);
    context.restore();
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
