// Values along an axis, its ticks, and the frame around a picture that has two of them.

/// From value to place and back; linear, or logarithmic.
class Scale {
  /// @param from where `low` lies @param to where `high` lies
  constructor({ low, high, log = false }, from, to) {
    Object.assign(this, { low, high, log, from, to });
  }
  at(value) {
    const { low, high, from, to } = this;
    return from + (to - from) * (this.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low));
  }
  value(at) {
    const { low, high } = this, part = (at - this.from) / (this.to - this.from);
    return this.log ? low * (high / low) ** part : low + (high - low) * part;
  }
  /// The power of ten that labels of very large or small numbers share; 0: none.
  get exponent() {
    const magnitude = Math.floor(Math.log10(Math.max(Math.abs(this.low), Math.abs(this.high))));
    return !this.log && (magnitude >= 5 || magnitude <= -3) && Number.isFinite(magnitude) ? magnitude : 0;
  }
  /// Pairs of place and label, labels at least `space` apart, two of them at least; a minor tick has none.
  ticks(space) {
    const { low, high } = this, most = Math.max(2, Math.floor(Math.abs(this.to - this.from) / space));
    if (this.log) {
      const values = decadeTicks(low, high, most), labels = decadeLabels(values, low, high, most);
      if (labels.filter(Boolean).length > 1) return values.map((value, i) => [this.at(value), labels[i]]);
    }
    let values = [], k = tickSteps.findIndex((size) => size * most >= high - low);
    for (; values.length < 2 && k >= 0; --k) {
      const step = tickSteps[k], first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
      values = Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => (first + i) * step);
    }
    const labels = linearLabels(values, tickSteps[k + 1], this.exponent);
    return values.map((value, i) => [this.at(value), labels[i]]);
  }
  /// The name of the axis, with the factor of its labels.
  name(label) { return this.exponent ? `${label} / ${powerOfTen(this.exponent)}` : label; }
}

/// An axis of places without numbers.
class WordScale {
  constructor(words, from, to) { Object.assign(this, { words, from, to }); }
  at(index) { return this.from + ((index + 0.5) / this.words.length) * (this.to - this.from); }
  ticks(space) {
    const most = Math.max(2, Math.floor(Math.abs(this.to - this.from) / space)), stride = Math.ceil(this.words.length / most);
    return this.words.map((word, i) => [this.at(i), word]).filter((_, i) => i % stride === 0);
  }
  name(label) { return label; }
}

/// Least distance of the labels of an axis upwards, and the room that they and its name take beside the frame.
const upwardSpace = 34;
function roomBeside(scale, space = upwardSpace) {
  const letters = Math.max(0, ...scale.ticks(space).map(([, label]) => label.length));
  return Math.ceil(33 + 7.3 * letters);
}

/// The grid of a frame, and its edge, ticks and names; an axis that is null has no ticks.
function axesOf({ left, top, width, height }, x, y, xName, yName, space = upwardSpace) {
  const right = left + width, bottom = top + height, place = (at) => at.toFixed(1), narrow = width < 400;
  const across = x?.ticks(narrow ? 52 : 76) ?? [], upwards = y?.ticks(space) ?? [];
  // A name that is longer than the frame is high takes the whole height, and smaller letters if it must.
  const upName = y?.name(yName) ?? yName, long = 7.4 * upName.length, whole = bottom + 46;
  const middle = long <= height ? (top + bottom) / 2 : whole / 2;
  const smaller = long > whole - 8 ? { style: `font-size:${((14 * (whole - 8)) / long).toFixed(1)}px` } : {};
  const length = (label) => (label ? 5 : 3);
  return {
    grid: svgElement("path", { class: "grid", d: across.map(([at]) => `M${place(at)} ${top}V${bottom}`).join("") +
      upwards.map(([at]) => `M${left} ${place(at)}H${right}`).join("") }),
    edge: svgElement("g", {},
      svgElement("rect", { class: "frame", x: left, y: top, width, height }),
      svgElement("path", { class: "frame", d: across.map(([at, label]) => `M${place(at)} ${bottom}v${length(label)}`).join("") +
        upwards.map(([at, label]) => `M${left} ${place(at)}h${-length(label)}`).join("") }),
      ...across.filter(([, label]) => label).map(([at, label]) =>
        svgElement("text", { x: place(at), y: bottom + 19, "text-anchor": "middle" }, label)),
      ...upwards.filter(([, label]) => label).map(([at, label]) =>
        svgElement("text", { x: left - 9, y: place(at), dy: ".35em", "text-anchor": "end" }, label)),
      svgElement("text", { class: "axis", x: (left + right) / 2, y: bottom + 39, "text-anchor": "middle" }, x?.name(xName) ?? xName),
      svgElement("text", { class: "axis", transform: "rotate(-90)", x: -middle, y: 15, "text-anchor": "middle", ...smaller }, upName)),
  };
}
