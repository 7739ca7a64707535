// A field over space and time, the displacement at nodes or the stress of elements, as thinned and rounded by the program (report/run/run_page.hpp).

class Field {
  constructor({ t, x, low, high, u }) {
    Object.assign(this, { t, x, low, high });
    const bytes = Uint8Array.from(atob(u), (c) => c.charCodeAt(0));
    this.u = new Float64Array(bytes.length / 2);
    for (let i = 0; i < this.u.length; ++i) this.u[i] = low + ((high - low) * (bytes[2 * i] + 256 * bytes[2 * i + 1])) / 65535;
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

  /// The values of every place, linear in between output times.
  profile(time) {
    const [row, part] = Field.locate(this.t, time), width = this.x.length, at = row * width;
    const profile = this.u.slice(at, at + width);
    if (part > 0) for (let j = 0; j < width; ++j) profile[j] += part * (this.u[at + width + j] - profile[j]);
    return profile;
  }

  value(time, x) { return Field.interpolated(this.x, this.profile(time), x); }
  /// Of values at increasing places.
  static interpolated(places, values, at) { return Field.between(values, ...Field.locate(places, at)); }
  static between(profile, node, part) {
    return part > 0 ? profile[node] + part * (profile[node + 1] - profile[node]) : profile[node];
  }

  /// The least and the greatest displacement of every node.
  envelope() {
    const width = this.x.length, low = this.u.slice(0, width), high = this.u.slice(0, width);
    for (let i = width; i < this.u.length; ++i) {
      const j = i % width;
      if (this.u[i] < low[j]) low[j] = this.u[i];
      else if (this.u[i] > high[j]) high[j] = this.u[i];
    }
    return { low, high };
  }
}

/// Displacements to colours: 255 steps of a scale, as report/run/field_map.cpp has them.
class FieldColours {
  static steps = 255;
  constructor({ anchors, low, high, touching, contactLevel, contactFrom }, field) {
    Object.assign(this, { low, high, touching });
    // The field is rounded, so what touches may lie half a step above.
    const slack = (0.75 * (field.high - field.low)) / 65535;
    this.contactLevel = contactLevel === undefined ? -Infinity : contactLevel + slack;
    this.contactFrom = contactFrom === undefined ? Infinity : contactFrom - slack;
    this.palette = Array.from({ length: FieldColours.steps }, (_, i) => mixed(anchors, i / (FieldColours.steps - 1)));
    this.palette.push(channels(touching));
    this.touched = this.touches(field.low) || this.touches(field.high);
  }
  touches(u) { return u <= this.contactLevel || u >= this.contactFrom; }
  /// The step of the scale; the one after the last stands for contact.
  index(u) { return this.touches(u) ? FieldColours.steps : this.step(u); }
  step(u) {
    const part = (u - this.low) / (this.high - this.low);
    return Math.round(Math.min(1, Math.max(0, part)) * (FieldColours.steps - 1));
  }
  shade(u) { return `rgb(${this.palette[this.step(u)]})`; }
}
