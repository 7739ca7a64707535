// The legend of a picture: each line of it a button that hides or shows what it stands for, and values at the cursor.

class Legend {
  constructor(chart) {
    this.node = element("div", { className: "legend" });
    this.readouts = [];
    for (const key of chart.legend?.querySelectorAll(".key") ?? []) this.node.append(this.line(chart, key));
    const scale = chart.legend?.querySelector(".scale");
    if (scale) this.node.append(...scaleOf(scale));
    if (this.readouts.length === 0) return;
    const read = () => {
      const place = chart.link.x.place;
      for (const [curve, node] of this.readouts) node.textContent = place === null ? "" : readable(chart.valueOf(curve, place), 4);
    };
    chart.link.x.onPlace.add(read);
    read();
  }

  line(chart, key) {
    const label = key.querySelector("text").textContent, name = key.dataset.key, marks = [...key.children].filter((node) => node.tagName !== "text");
    const sample = marks.length > 0 ? [svgElement("svg", { class: "sample", viewBox: "0 -6 20 12", "aria-hidden": "true" }, ...marks)] : [];
    const words = element("span", { textContent: label });
    if (!name) return element("span", { className: marks.length > 0 ? "" : "note" }, ...sample, words);
    const button = element("button", { type: "button", ariaPressed: "true", title: "Hide or show" }, ...sample, words);
    button.addEventListener("click", () => {
      chart.toggle(name);
      button.ariaPressed = String(!chart.hidden.has(name));
    });
    const curve = chart.overTime && !chart.y.log && chart.curves.find((one) => one.key === name);
    if (!curve) return button;
    const value = element("span", { className: "value" });
    button.append(value);
    this.readouts.push([curve, value]);
    return button;
  }
}

/// The colours of a map, lying down.
function scaleOf(scale) {
  const ramp = svgElement("svg", { class: "ramp", viewBox: "0 0 180 11", preserveAspectRatio: "none", "aria-hidden": "true" });
  const rect = svgElement("rect", { width: 11, height: 180, transform: "translate(180 0) rotate(90)", style: scale.querySelector("rect").getAttribute("style") });
  ramp.append(rect);
  const { name, low, high, unit } = scale.dataset, end = (value) => `${readable(Number(value), 3)}${unit ? `\u00a0${unit}` : ""}`;
  return [element("span", { className: "scale", textContent: `${name} from ${end(low)}` }), ramp, element("span", { textContent: `to ${end(high)}` })];
}

/// The numbers of the nearest point, by mouse or by arrow keys: for pictures of few points.
class PointReader {
  static reach = 40;

  constructor(chart) {
    this.chart = chart;
    this.chosen = null;
    this.points = this.pointsOf(chart);
    this.tip = element("div", { className: "tip", hidden: true, role: "status" });
    chart.over.append(this.tip);
    chart.onPointer = (at) => this.show(at && this.nearest(at));
    chart.painters.push(() => this.ring());
    chart.host.addEventListener("keydown", (event) => this.key(event));
    chart.host.addEventListener("blur", () => this.show(null));
  }

  /// Markers, which tell their numbers; the corners of lines without markers; and levels, which have no place along.
  pointsOf({ inner, curves, drawn }) {
    const markers = [...inner.querySelectorAll("[data-at]")].map((node) => {
      const [x, y] = node.dataset.at.split(" ").map(Number);
      return { key: node.dataset.key, x, y };
    });
    const marked = new Set(markers.map(({ key }) => key));
    const corners = curves.filter(({ key }) => !marked.has(key)).flatMap(({ key, x, y }) =>
      x.map((at, i) => ({ key, x: drawn.x.value(at), y: drawn.y.value(y[i]) })));
    const levels = [...inner.querySelectorAll("[data-level]")].map((node) => ({ key: node.dataset.key, x: null, y: Number(node.dataset.level) }));
    return [...markers, ...corners.filter(({ key }) => !levels.some((level) => level.key === key)), ...levels];
  }

  visible() {
    const [left, right] = this.chart.seen("x"), { hidden } = this.chart;
    return this.points.filter(({ key, x }) => !hidden.has(key) && (x === null || (x >= left && x <= right)));
  }

  nearest([x, y]) {
    const { chart } = this;
    let best = null, least = PointReader.reach;
    for (const point of this.visible()) {
      // A level is only meant when the pointer is on it.
      const across = point.x === null ? 0 : chart.px(point.x) - x, upwards = (chart.py(point.y) - y) * (point.x === null ? 6 : 1);
      const distance = Math.hypot(across, upwards);
      if (distance < least) [best, least] = [point, distance];
    }
    return best;
  }

  key(event) {
    const points = this.visible().filter(({ x }) => x !== null).sort((a, b) => a.x - b.x || a.y - b.y);
    if (points.length === 0) return;
    const lines = [...new Set(points.map(({ key }) => key))];
    const line = this.chosen?.key ?? lines[0], own = points.filter(({ key }) => key === line);
    const at = own.indexOf(this.chosen), beside = (step) => lines[(lines.indexOf(line) + step + lines.length) % lines.length];
    const next = {
      ArrowRight: () => own[Math.min(at + 1, own.length - 1)],
      ArrowLeft: () => own[Math.max(at < 0 ? 0 : at - 1, 0)],
      Home: () => own[0],
      End: () => own.at(-1),
      ArrowDown: () => points.find(({ key }) => key === beside(1)),
      ArrowUp: () => points.find(({ key }) => key === beside(-1)),
      Escape: () => null,
    }[event.key];
    if (!next) return;
    event.preventDefault();
    this.show(next());
  }

  show(point) {
    if (point === this.chosen) return;
    const { chart, tip } = this, { frame } = chart;
    this.chosen = point;
    tip.hidden = !point;
    if (point) {
      const lines = [point.key, ...(point.x === null ? [] : [`${chart.x.label} = ${readable(point.x)}`]), `${chart.y.label} = ${readable(point.y)}`];
      tip.replaceChildren(...lines.filter(Boolean).map((text) => element("div", { textContent: text })));
      const place = point.x === null ? frame.width / 2 : chart.px(point.x) - frame.left, height = chart.py(point.y) - frame.top;
      Object.assign(tip.style, { left: `${place}px`, top: `${height}px` });
      tip.classList.toggle("leftwards", place > frame.width / 2);
      tip.classList.toggle("downwards", height < 80);
    }
    chart.paint();
  }

  ring() {
    const { chart, chosen } = this;
    if (!chosen || chosen.x === null) return [];
    return [svgElement("circle", { class: "ring", cx: chart.px(chosen.x), cy: chart.py(chosen.y), r: 6.5 })];
  }
}
