// Lines as functions: their value at a place, and the range they have over a part of x.

class Curve {
  constructor({ x, y }) {
    this.x = x;
    this.y = y.map((value) => value ?? NaN);
    this.most = y.reduce((most, value) => Math.max(most, value ?? -Infinity), -Infinity);
  }
  at(place) {
    const { x, y } = this;
    if (x.length === 0 || place < x[0] || place > x.at(-1)) return NaN;
    return Field.interpolated(x, y, place);
  }
  /// The values over [from, to], at its ends too.
  values(from, to) {
    const inside = this.y.filter((_, i) => this.x[i] >= from && this.x[i] <= to);
    return [this.at(from), ...inside, this.at(to)].filter(Number.isFinite);
  }
}

/// An axis for what is visible of some curves, with room around them and the levels that lie near.
function fittedRange(curves, levels, from, to) {
  const values = curves.flatMap((curve) => curve.values(from, to));
  let low = Math.min(...values), high = Math.max(...values);
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
