// Lines as functions: their value at a place, and the range they have over a part of x.

class Curve {
  constructor({ x, y }) {
    this.x = x;
    this.y = y.map((value) => value ?? NaN);
    this.most = y.reduce((most, value) => Math.max(most, value ?? -Infinity), -Infinity);
  }
  at(place) {
    const { x, y } = this;
    if (x.length === 0 || place < x[0] || place > x[x.length - 1]) return NaN;
    if (x.length === 1) return y[0];
    const [index, part] = Field.locate(x, place);
    return y[index] + part * (y[index + 1] - y[index]);
  }
  /// Least and greatest value over [from, to].
  range(from, to) {
    let low = Infinity, high = -Infinity;
    const add = (value) => {
      if (value < low) low = value;
      if (value > high) high = value;
    };
    add(this.at(from));
    add(this.at(to));
    for (let i = 0; i < this.x.length; ++i) if (this.x[i] >= from && this.x[i] <= to) add(this.y[i]);
    return [low, high];
  }
}

/// An axis for what is visible of some curves, with room around them and the levels that lie near.
function fittedRange(curves, levels, from, to) {
  let low = Infinity, high = -Infinity;
  for (const curve of curves) {
    const [least, most] = curve.range(from, to);
    low = Math.min(low, least);
    high = Math.max(high, most);
  }
  if (!(low <= high)) return null;
  const size = Math.max(high - low, 1e-9 * Math.max(Math.abs(low), Math.abs(high)));
  if (size === 0) return null;
  for (const level of levels)
    if (level > low - size && level < high + size) {
      low = Math.min(low, level);
      high = Math.max(high, level);
    }
  const margin = 0.06 * Math.max(high - low, size);
  return [low - margin, high + margin];
}
