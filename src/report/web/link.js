// A link is shared by charts with an axis of the same meaning: it has the part of it in view, and where on it the reader is.

class Link {
  bounds = null;   // [low, high] of the whole
  range = null;    // [low, high] in view; null is the whole
  pointed = null;  // the place under the pointer
  rest = null;     // the place when nobody points: the time of the slider
  onRange = new Set();
  onPlace = new Set();

  constructor(logarithmic = false) {
    this.to = logarithmic ? Math.log : (value) => value;
    this.from = logarithmic ? Math.exp : (value) => value;
  }
  include(low, high) {
    this.bounds = this.bounds ? [Math.min(low, this.bounds[0]), Math.max(high, this.bounds[1])] : [low, high];
  }
  get place() { return this.pointed ?? this.rest; }
  point(value) {
    if (this.pointed === value) return;
    this.pointed = value;
    for (const listener of this.onPlace) listener();
  }
  stand(value) {
    this.rest = value;
    for (const listener of this.onPlace) listener();
  }
  show(range) {
    if (range) {
      const [low, high] = this.bounds.map(this.to), whole = high - low;
      let [begin, end] = range.map(this.to);
      const size = Math.min(end - begin, whole);
      if (!(size > 1e-9 * whole)) return;
      begin = Math.min(Math.max(begin, low), high - size);
      end = begin + size;
      range = size < whole * (1 - 1e-9) ? [this.from(begin), this.from(end)] : null;
    }
    this.range = range;
    for (const listener of this.onRange) listener();
  }
  /// Shows `factor` times as much, the place `around` staying where it is.
  zoom(factor, around) {
    const [low, high] = (this.range ?? this.bounds).map(this.to);
    const at = Math.min(Math.max(this.to(around ?? this.from((low + high) / 2)), low), high);
    this.show([this.from(at - (at - low) * factor), this.from(at + (high - at) * factor)]);
  }
  /// By a part of what is shown.
  pan(part) {
    if (!this.range) return;
    const [low, high] = this.range.map(this.to), step = part * (high - low);
    this.show([this.from(low + step), this.from(high + step)]);
  }
}
