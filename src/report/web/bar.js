// The bar at one time: its displacement upwards over position, coloured as in the map, above its obstacles.

class BarPicture {
  static thickness = 9;

  /// @param supports what holds the ends @param reactions functions of time, or null: {left, right}
  constructor(field, colours, supports, reactions) {
    Object.assign(this, { field, colours, supports, reactions });
    this.envelope = field.envelope();
  }

  drawEnvelope(chart, context) {
    const { x } = this.field, { low, high } = this.envelope, lift = BarPicture.thickness * chart.ratio;
    context.beginPath();
    x.forEach((at, j) => context.lineTo(chart.px(at), chart.py(low[j])));
    for (let j = x.length - 1; j >= 0; --j) context.lineTo(chart.px(x[j]), chart.py(high[j]) - lift);
    context.fillStyle = colour("var(--faint)");
    context.globalAlpha = 0.7;
    context.fill();
    context.globalAlpha = 1;
  }

  draw(chart, context, time) {
    const { x } = this.field, profile = this.field.profile(time), lift = BarPicture.thickness * chart.ratio;
    const outline = new Path2D();
    for (let j = 0; j < x.length; ++j) outline.lineTo(chart.px(x[j]), chart.py(profile[j]));
    for (let j = x.length - 1; j >= 0; --j) outline.lineTo(chart.px(x[j]), chart.py(profile[j]) - lift);
    outline.closePath();
    context.fillStyle = shadesAlong(context, chart.px(x[0]), chart.px(x.at(-1)), x.length,
      (j) => chart.px(x[j]), (j) => this.colours.shade(profile[j]));
    context.fill(outline);
    strokeStyle(chart, context, "var(--ink)", 1);
    context.lineJoin = "round";
    context.stroke(outline);
    this.drawTouching(chart, context, profile);
    const { span } = this.supports;
    if (span) for (const sign of span.side === "both" ? [1, -1] : [signOf(span)]) this.drawSpanGap(chart, context, profile, sign);
    for (const side of ["left", "right"]) this.drawEnd(chart, context, side, profile, time);
  }

  /// What lies on the obstacle along the span: stretches, and single nodes as dots.
  drawTouching(chart, context, profile) {
    const { x } = this.field, touches = (j) => this.colours.touches(profile[j]);
    strokeStyle(chart, context, this.colours.touching, 3);
    context.fillStyle = this.colours.touching;
    for (let j = 0; j < x.length; ++j) {
      if (!touches(j)) continue;
      if (touches(j + 1)) segment(context, chart.px(x[j]), chart.py(profile[j]), chart.px(x[j + 1]), chart.py(profile[j + 1]));
      else if (!touches(j - 1)) dot(context, chart.px(x[j]), chart.py(profile[j]), 5 * chart.ratio);
    }
  }

  /// Where the bar is nearest to the obstacle along its span.
  drawSpanGap(chart, context, profile, sign) {
    const { x } = this.field, { gap } = this.supports.span, unit = chart.ratio, surface = chart.py(-sign * gap);
    const least = profile.reduce((best, u, j) => (sign * u < sign * profile[best] ? j : best), 0);
    const at = chart.px(x[least]), foot = chart.py(profile[least]), inLeftHalf = 2 * least < x.length;
    if (this.colours.touches(profile[least]) || surface > chart.box.top + chart.box.height || surface < chart.box.top) return;
    doubleArrow(chart, context, at, foot, surface);
    write(chart, context, `gap ${readable(sign * profile[least] + gap, 3)}`, at + (inLeftHalf ? 12 : -12) * unit, surface + sign * 26 * unit,
      { css: "var(--ink)", align: inLeftHalf ? "left" : "right", halo: true });
  }

  drawEnd(chart, context, side, profile, time) {
    const end = side === "left" ? 0 : profile.length - 1, u = profile[end];
    const support = this.supports[side], at = chart.px(this.field.x[end]), foot = chart.py(u), unit = chart.ratio;
    if (support.kind === "fixed") {
      context.fillStyle = colour("var(--ink)");
      context.fillRect(at - 2 * unit, foot - 20 * unit, 4 * unit, 31 * unit);
    }
    if (support.kind !== "obstacle") return;
    const outwards = side === "left" ? 1 : -1, words = { css: "var(--ink)", align: side === "left" ? "left" : "right", halo: true };
    const sign = signOf(support), gap = support.surface ? -sign * surfaceAt(support, this.field, time) : support.gap, surface = chart.py(-sign * gap);
    if (support.surface) {
      const { x } = this.field, place = x[end], depth = 0.03 * (x[x.length - 1] - x[0]);
      layerPainters.body(chart, context, { y: -sign * gap, from: place - depth, to: place + depth, above: sign < 0 });
    }
    if (inParts(support.contact, time)) {
      const force = this.reactions[side], size = force ? Math.max(0, sign * force.at(time)) : 0, most = force ? force.most : 0;
      const length = (16 + (most > 0 ? (46 * size) / most : 0)) * unit;
      context.fillStyle = this.colours.touching;
      dot(context, at, foot, 5 * unit);
      if (force) {
        arrow(chart, context, at, surface + sign * length, surface + sign * 4 * unit, this.colours.touching);
        // Below the surface, but where the bar goes there.
        const { x } = this.field, inner = x.findIndex((position) => chart.px(position) >= at + 70 * outwards * unit);
        const level = inner >= 0 && chart.py(profile[inner]) > surface + 6 * unit ? -20 : 26;
        write(chart, context, `in contact, R = ${readable(sign * size, 3)}`, at + 12 * outwards * unit, surface + sign * level * unit, words);
      }
    } else if (surface > chart.box.top && surface < chart.box.top + chart.box.height) {
      doubleArrow(chart, context, at, foot, surface);
      write(chart, context, `gap ${readable(sign * u + gap, 3)}`, at + 12 * outwards * unit, surface + sign * 26 * unit, words);
    }
  }
}

/// Of an obstacle that moves, linear in between output times.
const surfaceAt = ({ surface }, field, time) => Field.interpolated(field.t, surface, time);

/// 1 for an obstacle below, -1 for one above.
const signOf = (obstacle) => (obstacle.above ? -1 : 1);

/// Whether a value lies in one of the intervals [begin, end, begin, end, ...].
const inParts = (parts = [], value) => parts.some((begin, i) => i % 2 === 0 && begin <= value && value <= parts[i + 1]);

/// A gradient along a bar, from and to its ends, of about 120 colours at places between.
function shadesAlong(context, from, to, count, place, shade) {
  const gradient = context.createLinearGradient(from, 0, to, 0), stride = Math.max(1, Math.floor(count / 120));
  for (let j = 0; j < count; j += stride) gradient.addColorStop(Math.min(1, Math.max(0, (place(j) - from) / (to - from))), shade(j));
  return gradient;
}

function dot(context, x, y, radius) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
}

/// Upright, from one y to another, the head at the second.
function arrow(chart, context, x, from, to, css, width = 2) {
  const head = 6 * chart.ratio, towards = to < from ? 1 : -1;
  strokeStyle(chart, context, css, width);
  segment(context, x, from, x, to + 0.8 * head * towards);
  context.fillStyle = css;
  context.beginPath();
  context.moveTo(x, to);
  context.lineTo(x - 0.6 * head, to + head * towards);
  context.lineTo(x + 0.6 * head, to + head * towards);
  context.fill();
}

/// A distance, where there is room to show it.
function doubleArrow(chart, context, x, from, to) {
  if (Math.abs(to - from) <= 14 * chart.ratio) return;
  const middle = (from + to) / 2;
  for (const head of [from, to]) arrow(chart, context, x, middle, head, colour("var(--ink)"), 1);
}

/// The bar as it lies, its points at x + s u between its walls, coloured by the stress.
class AxialPicture {
  static thickness = 44;

  constructor(field, stress, colours, supports, magnification) {
    Object.assign(this, { field, stress, colours, supports, magnification });
  }

  draw(chart, context, time) {
    const { field, stress, magnification: s } = this, { x } = field, u = field.profile(time), values = stress.profile(time);
    const { top, height } = chart.box, half = (AxialPicture.thickness / 2) * chart.ratio, middle = top + height / 2;
    const place = (at) => chart.px(at + s * Field.interpolated(x, u, at));
    for (const [side, end] of [["left", x[0]], ["right", x.at(-1)]]) {
      const { surface, above = false } = this.supports[side];
      if (surface) layerPainters.wall(chart, context, { x: end + s * surfaceAt(this.supports[side], field, time), right: above, open: above !== (side === "right") });
    }
    const left = place(x[0]), right = place(x.at(-1)), size = Math.max(right - left, 1e-9);
    context.fillStyle = shadesAlong(context, left, left + size, values.length, (j) => place(stress.x[j]), (j) => this.colours.shade(values[j]));
    context.fillRect(left, middle - half, size, 2 * half);
    strokeStyle(chart, context, "var(--ink)", 1);
    context.strokeRect(left, middle - half, size, 2 * half);
    // Sections at equal distances of the bar at rest.
    context.globalAlpha = 0.35;
    for (let k = 1; k < 20; ++k) {
      const at = place(x[0] + ((x.at(-1) - x[0]) * k) / 20);
      segment(context, at, middle - half, at, middle + half);
    }
    context.globalAlpha = 1;
    for (const [side, at] of [["left", left], ["right", right]]) {
      const support = this.supports[side];
      context.fillStyle = support.kind === "fixed" ? colour("var(--ink)") : this.colours.touching;
      if (support.kind === "fixed" || inParts(support.contact, time)) context.fillRect(at - 2.5 * chart.ratio, middle - half, 5 * chart.ratio, 2 * half);
    }
  }
}
