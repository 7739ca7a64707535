// A field over space and time, the displacement at nodes or the stress of elements, as thinned and rounded by the program (report/run/run_page.hpp).

class Field {
  constructor({ t, x, low, high, u, colours }) {
    Object.assign(this, { t, x, low, high, colours });
    const bytes = Uint8Array.from(atob(u), (c) => c.charCodeAt(0));
    this.u = new Float64Array(bytes.length / 2);
    for (let i = 0; i < this.u.length; ++i) this.u[i] = low + ((high - low) * (bytes[2 * i] + 256 * bytes[2 * i + 1])) / 65535;
    // The field is rounded, so what touches may lie half a step above.
    this.step = (high - low) / 65535;
    const slack = 0.75 * this.step;
    this.contactUpTo = (colours.contactUpTo ?? -Infinity) + slack;
    this.contactFrom = (colours.contactFrom ?? Infinity) - slack;
  }

  /// Among increasing values: the index of the last one up to a value, and the part of the way to the next.
  static locate(values, value) {
    let low = 0, high = values.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (values[middle] <= value) low = middle;
      else high = middle;
    }
    const part = values.length > 1 ? (value - values[low]) / (values[low + 1] - values[low]) : 0;
    return [low, Math.min(1, Math.max(0, part))];
  }
  /// A value between others at increasing places, linear in between.
  static interpolated(places, values, at) {
    const [node, part] = Field.locate(places, at);
    return part > 0 ? values[node] + part * (values[node + 1] - values[node]) : values[node];
  }

  /// The values of every place, linear in between output times.
  profile(time) {
    const [row, part] = Field.locate(this.t, time), width = this.x.length, at = row * width;
    const profile = this.u.slice(at, at + width);
    if (part > 0) for (let j = 0; j < width; ++j) profile[j] += part * (this.u[at + width + j] - profile[j]);
    return profile;
  }
  value(time, x) { return Field.interpolated(this.x, this.profile(time), x); }

  /// A value, or a difference of one, to the digits that it has: what is below the rounding is 0.
  known(value) {
    if (!(this.step > 0)) return value;
    const unit = 10 ** Math.floor(Math.log10(this.step));
    return Math.abs(value) <= this.step ? 0 : Number((Math.round(value / unit) * unit).toPrecision(12));
  }
  /// True of a displacement in contact with the span obstacle.
  touches(u) { return u <= this.contactUpTo || u >= this.contactFrom; }
  /// The colour of a value, as in the map.
  shade(value) {
    const { anchors, low, high } = this.colours;
    return `rgb(${mixed(anchors, Math.min(1, Math.max(0, (value - low) / (high - low))))})`;
  }
}

/// Red, green and blue at a part of a colour scale, whose anchors "#rrggbb" are at equal distances; linear in between.
function mixed(anchors, part) {
  const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
  const scaled = part * (anchors.length - 1), at = Math.min(Math.floor(scaled), anchors.length - 2);
  const to = channels(anchors[at + 1]);
  return channels(anchors[at]).map((from, k) => Math.round(from + (scaled - at) * (to[k] - from)));
}
