// The bar at one time. Its pictures have the axes, the obstacles at rest and where the bar has been and will be; what moves
// is drawn over them, in pixels.

/// The place of an obstacle that moves, linear in between output times.
const surfaceAt = ({ surface }, field, time) => Field.interpolated(field.t, surface, time);

/// 1 for an obstacle below, -1 for one above.
const signOf = (obstacle) => (obstacle.above ? -1 : 1);

/// True if a value lies in one of the intervals [begin, end, begin, end, ...].
const inParts = (parts = [], value) => parts.some((begin, i) => i % 2 === 0 && begin <= value && value <= parts[i + 1]);

/// A fill of about 120 colours along a bar from a place to another, and its definition.
function shadesAlong(name, from, to, count, place, shade) {
  const stride = Math.max(1, Math.floor(count / 120)), stops = [];
  for (let j = 0; j < count; j += stride)
    stops.push(svgElement("stop", { offset: Math.min(1, Math.max(0, (place(j) - from) / (to - from))), "stop-color": shade(j) }));
  return [`fill:url(#${name})`, svgElement("linearGradient", { id: name, gradientUnits: "userSpaceOnUse", x1: from, x2: to, y1: 0, y2: 0 }, ...stops)];
}

const pathOf = (kind, d, style = "") => svgElement("path", { class: kind, d, style });
const dot = (kind, cx, cy) => svgElement("circle", { class: kind, cx, cy, r: 5 });

/// Strokes of 45 degrees along an upright wall, which its picture clips.
function hatched(left, top, width, height) {
  const lines = [];
  for (let along = 0; along < height + width; along += 8) lines.push(`M${left} ${top + along}l${width} ${-width}`);
  return pathOf("hatch", lines.join(""));
}

/// Upright, from one height to another, the head at the second.
function arrow(kind, x, from, to) {
  const head = 6, towards = to < from ? head : -head;
  return pathOf(`arrow ${kind}`, `M${x} ${from}V${to + 0.8 * towards}M${x} ${to}l-3.6 ${towards}h7.2z`);
}
/// A distance, where there is room to show it.
const doubleArrow = (x, from, to) => (Math.abs(to - from) <= 14 ? [] : [from, to].map((head) => arrow("length", x, (from + to) / 2, head)));

const words = (text, x, y, leftwards) => svgElement("text", { class: "said", x, y, "text-anchor": leftwards ? "end" : "start" }, text);

/// Displacement upwards over position, coloured as in the map, above its obstacles.
class BarPicture {
  static thickness = 9;

  /// @param members of a chain, or the bar @param supports what holds the ends and the span
  /// @param reactions functions of time, or null: {left, right}
  constructor(field, members, supports, reactions) { Object.assign(this, { field, members, supports, reactions }); }

  draw(chart, time) {
    const { field } = this, { x } = field, profile = field.profile(time), { span } = this.supports;
    const corners = (lift, order) => order.map((j) => `${chart.px(x[j]).toFixed(2)} ${(chart.py(profile[j]) - lift).toFixed(2)}`);
    const [fill, shades] = shadesAlong("bar-shades", chart.px(x[0]), chart.px(x.at(-1)), x.length, (j) => chart.px(x[j]), (j) => field.shade(profile[j]));
    const member = ({ nodes: [first, last] }) => {
      if (first === last)
        return svgElement("rect", { class: "solid rigid", x: chart.px(x[first]) - 5, y: chart.py(profile[first]) - BarPicture.thickness - 3, width: 10, height: BarPicture.thickness + 6 });
      const along = Array.from({ length: last - first + 1 }, (_, k) => first + k), outline = [...corners(0, along), ...corners(BarPicture.thickness, along.reverse())];
      return pathOf("solid", `M${outline.join("L")}z`, fill);
    };
    return [shades, ...this.members.filter(({ nodes }) => nodes[0] < nodes[1]).map(member),
      ...this.members.filter(({ nodes }) => nodes[0] === nodes[1]).map(member), ...this.touching(chart, profile),
      ...(span ? (span.side === "both" ? [1, -1] : [signOf(span)]).flatMap((sign) => this.spanGap(chart, profile, sign)) : []),
      ...["left", "right"].flatMap((side) => this.end(chart, side, profile, time))];
  }

  /// Nodes that lie on the obstacle along the span: stretches, and single nodes as dots.
  touching(chart, profile) {
    const { x } = this.field, touches = (j) => this.field.touches(profile[j]), stretches = [], dots = [];
    for (let j = 0; j < x.length; ++j) {
      if (!touches(j)) continue;
      const place = `${chart.px(x[j])} ${chart.py(profile[j])}`;
      if (touches(j - 1)) stretches.push(`L${place}`);
      else if (touches(j + 1)) stretches.push(`M${place}`);
      else dots.push(dot("touching", chart.px(x[j]), chart.py(profile[j])));
    }
    return [...(stretches.length > 0 ? [pathOf("touched", stretches.join(""))] : []), ...dots];
  }

  length(value) { return withUnit(this.field.known(value), "length", 3); }
  inView(chart, surface) { return surface > chart.frame.top && surface < chart.frame.top + chart.frame.height; }

  /// Where the bar is nearest to the obstacle along its span.
  spanGap(chart, profile, sign) {
    const { x } = this.field, { gap } = this.supports.span, surface = chart.py(-sign * gap);
    const least = profile.reduce((best, u, j) => (sign * u < sign * profile[best] ? j : best), 0), at = chart.px(x[least]);
    if (this.field.touches(profile[least]) || !this.inView(chart, surface)) return [];
    const inLeftHalf = 2 * least < x.length;
    return [...doubleArrow(at, chart.py(profile[least]), surface),
      words(`gap ${this.length(sign * profile[least] + gap)}`, at + (inLeftHalf ? 12 : -12), surface + sign * 26, !inLeftHalf)];
  }

  end(chart, side, profile, time) {
    const { x } = this.field, end = side === "left" ? 0 : profile.length - 1, u = profile[end], isRight = side === "right";
    const support = this.supports[side], at = chart.px(x[end]), foot = chart.py(u), outwards = isRight ? -1 : 1;
    if (support.kind === "fixed") return [svgElement("rect", { class: "held", x: at - 2, y: foot - 20, width: 4, height: 31 })];
    if (support.kind !== "obstacle") return [];
    const sign = signOf(support), gap = support.surface ? -sign * surfaceAt(support, this.field, time) : support.gap;
    const surface = chart.py(-sign * gap), nodes = [];
    if (support.surface) {
      const depth = 0.03 * (x.at(-1) - x[0]), left = chart.px(x[end] - depth), width = chart.px(x[end] + depth) - left;
      nodes.push(svgElement("rect", { class: "body", x: left, y: sign > 0 ? surface : surface - 12, width, height: 12 }),
        pathOf("surface", `M${left} ${surface}h${width}`));
    }
    if (inParts(support.contact, time)) {
      const force = this.reactions[side], size = force ? Math.max(0, sign * force.at(time)) : 0;
      nodes.push(dot("touching", at, foot));
      if (!force) return nodes;
      // Below the surface, but where the bar goes there.
      const inner = x.findIndex((position) => chart.px(position) >= at + 70 * outwards);
      const level = inner >= 0 && chart.py(profile[inner]) > surface + 6 ? -20 : 26;
      nodes.push(arrow("force", at, surface + sign * (16 + (force.most > 0 ? (46 * size) / force.most : 0)), surface + sign * 4),
        words(`${chart.frame.width < 400 ? "" : "in contact, "}R = ${withUnit(sign * size, "force", 3)}`, at + 12 * outwards, surface + sign * level, isRight));
    } else if (this.inView(chart, surface)) {
      nodes.push(...doubleArrow(at, foot, surface), words(`gap ${this.length(sign * u + gap)}`, at + 12 * outwards, surface + sign * 26, isRight));
    }
    return nodes;
  }
}

/// The bar, or bars in line, as they lie, their points at x + s u between the walls, coloured by the stress. The gaps of
/// joints and rigid bodies, which are blocks, shift what is to the right of them.
class AxialPicture {
  static thickness = 44;

  /// @param layout what axial_json() of report/run/run_page.hpp writes
  constructor(field, stress, supports, layout) { Object.assign(this, { field, stress, supports, ...layout }); }

  draw(chart, time) {
    const { field, stress, members, joints, block } = this, u = field.profile(time), values = stress.profile(time);
    const { top, height } = chart.frame, half = AxialPicture.thickness / 2, middle = top + height / 2, upper = middle - half;
    const lying = members.map((member) => this.lying(chart, member, u)), nodes = [];
    const ends = ["left", "right"].map((side) => {
      const right = side === "right", member = members.at(right ? -1 : 0), rest = field.x.at(right ? -1 : 0) + member.shift;
      return { support: this.supports[side], side, rest: rest + (right && !member.elements ? block : 0), at: lying.at(right ? -1 : 0)[side] };
    });
    for (const { support, side, rest } of ends) {
      if (!support.surface) continue;
      const wall = chart.px(rest + this.magnification * surfaceAt(support, field, time)), right = Boolean(support.above), open = right !== (side === "right");
      nodes.push(hatched(right ? wall : wall - 12, top, 12, height), pathOf(open ? "surface open" : "surface", `M${wall} ${top}v${height}`));
    }
    const shape = { y: upper, height: 2 * half };
    members.forEach(({ elements }, m) => {
      const { left, right, place } = lying[m], width = Math.max(right - left, 1e-9);
      if (!elements) return nodes.push(svgElement("rect", { class: "solid rigid", x: left, width, ...shape }));
      const [fill, shades] = shadesAlong(`axial-shades-${m}`, left, left + width, elements[1] - elements[0] + 1,
        (j) => place(stress.x[elements[0] + j]), (j) => stress.shade(values[elements[0] + j]));
      nodes.push(shades, svgElement("rect", { class: "solid", style: fill, x: left, width, ...shape }));
    });
    // Sections at equal distances of a bar at rest; in a chain they would look like joints.
    const [begin, end] = [field.x[0], field.x.at(-1)];
    const sections = Array.from({ length: members.length === 1 ? 19 : 0 }, (_, k) => `M${lying[0].place(begin + ((end - begin) * (k + 1)) / 20)} ${upper}v${2 * half}`);
    nodes.push(pathOf("sections", sections.join("")));
    joints.forEach(({ contact }, k) => {
      const at = 0.5 * (lying[k].right + lying[k + 1].left);
      if (inParts(contact, time)) nodes.push(svgElement("rect", { class: "touching", x: at - 2.5, width: 5, ...shape }));
      nodes.push(pathOf("joint", `M${at} ${upper - 7}v${2 * half + 14}`));
    });
    for (const { support, at } of ends) {
      const kind = support.kind === "fixed" ? "held" : inParts(support.contact, time) ? "touching" : null;
      if (kind) nodes.push(svgElement("rect", { class: kind, x: at - 2.5, width: 5, ...shape }));
    }
    return nodes;
  }

  /// Where a member lies: its faces, and the place of what is at x at rest.
  lying(chart, { nodes: [first, last], shift, elements }, u) {
    const { x } = this.field, at = (node) => x[node] + this.magnification * u[node];
    const xs = x.slice(first, last + 1), places = xs.map((_, k) => at(first + k));
    return { left: chart.px(shift + at(first)), right: chart.px(shift + at(last) + (elements ? 0 : this.block)),
      place: (position) => chart.px(shift + Field.interpolated(xs, places, position)) };
  }
}
