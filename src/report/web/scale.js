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
  /// Pairs of place and label, labels at least `space` apart; a minor tick has none.
  ticks(space) {
    const { low, high } = this, most = Math.max(2, Math.floor(Math.abs(this.to - this.from) / space));
    const values = this.log ? decadeTicks(low, high, most) : [], step = tickSteps.find((size) => size * most >= high - low);
    if (!this.log) for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) values.push(k * step);
    const labels = this.log ? decadeLabels(values, low, high, most) : linearLabels(values, step);
    return values.map((value, i) => [this.at(value), labels[i]]);
  }
}

/// The grid of a frame, and its edge, ticks and names; an axis that is null has no ticks.
function axesOf({ left, top, width, height }, x, y, xName, yName) {
  const right = left + width, bottom = top + height, place = (at) => at.toFixed(1), narrow = width < 400;
  const across = x?.ticks(narrow ? 52 : 76) ?? [], upwards = y?.ticks(34) ?? [];
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
      svgElement("text", { class: "axis", x: (left + right) / 2, y: bottom + 39, "text-anchor": "middle" }, xName),
      svgElement("text", { class: "axis", transform: "rotate(-90)", x: -(top + bottom) / 2, y: 15, "text-anchor": "middle" }, yName)),
  };
}
