// The legend of a picture: what is drawn, each line of it a button that hides or shows it, and values at the cursor.

class Legend {
  constructor(chart, { values = false } = {}) {
    this.chart = chart;
    this.readouts = [];
    this.node = element("div", { className: "legend" });
    for (const { text } of chart.figure.layers.filter(({ kind }) => kind === "note"))
      this.node.append(element("span", { className: "note", textContent: text }));
    for (const { label, layer } of chart.groups.labels) {
      const button = element("button", { type: "button", ariaPressed: "true", title: "Hide or show" },
        swatch(layer), element("span", { textContent: label }));
      button.addEventListener("click", () => {
        chart.toggle(label);
        button.ariaPressed = String(!chart.hidden.has(label));
      });
      const curve = chart.lines.findIndex((line) => line.label === label);
      if (values && curve >= 0) {
        const value = element("span", { className: "value" });
        button.append(value);
        this.readouts.push([chart.curves[curve], value]);
      }
      this.node.append(button);
    }
    if (this.readouts.length > 0) {
      chart.link.x.onPlace.add(() => this.read());
      this.read();
    }
  }

  read() {
    const place = this.chart.link.x.place;
    for (const [curve, node] of this.readouts) node.textContent = place === null ? "" : readable(curve.at(place), 4);
  }
}

/// A sample of how a layer is drawn.
function swatch(layer) {
  const { kind, colour: css, dashed, shape, width = 2 } = layer;
  if (kind === "line" && (dashed || shape)) {
    return svgElement("svg", { class: "sample", viewBox: "0 0 30 10", "aria-hidden": "true" },
      svgElement("path", { d: "M0 5h30", style: `stroke:${css};stroke-width:${Math.max(2, Math.min(width, 5))};stroke-dasharray:${dashOf(layer).join(" ")}` }));
  }
  const box = element("span", { className: `swatch ${kind === "line" || kind === "level" ? "stroke" : kind}`, ariaHidden: "true" });
  box.style.setProperty("--colour", css);
  if (dashed) box.classList.add("dashed");
  box.style.setProperty("--width", `${Math.max(2, Math.min(width, 7))}px`);
  return box;
}

/// The numbers of the nearest point, by mouse or by arrow keys: for pictures of few points.
class PointReader {
  static reach = 40;

  constructor(chart) {
    this.chart = chart;
    this.points = chart.lines.flatMap((line) => line.x.map((x, i) => ({ line, x, y: line.y[i] })))
      .concat(chart.figure.layers.filter(({ kind }) => kind === "level").map((line) => ({ line, x: null, y: line.y })))
      .filter(({ y }) => y !== null);
    this.chosen = null;
    this.tip = element("div", { className: "tip", hidden: true, role: "status" });
    chart.plot.over.append(this.tip);
    chart.onPointer = (at) => this.show(at && this.nearest(at));
    chart.overlays.push((_, context) => this.ring(context));
    chart.host.addEventListener("keydown", (event) => this.key(event));
    chart.host.addEventListener("blur", () => this.show(null));
  }

  visible() {
    const [left, right] = this.chart.shown("x"), { hidden, groups } = this.chart;
    return this.points.filter(({ line, x }) => !hidden.has(groups.of.get(line)) && (x === null || (x >= left && x <= right)));
  }

  nearest({ left, top }) {
    let best = null, least = PointReader.reach;
    for (const point of this.visible()) {
      const across = point.x === null ? 0 : this.chart.plot.valToPos(point.x, "x") - left;
      // A level is only meant when the pointer is on it.
      const upwards = (this.chart.plot.valToPos(point.y, "y") - top) * (point.x === null ? 6 : 1);
      const distance = Math.hypot(across, upwards);
      if (distance < least) [best, least] = [point, distance];
    }
    return best;
  }

  key(event) {
    const points = this.visible().filter(({ x }) => x !== null).sort((a, b) => a.x - b.x || a.y - b.y);
    if (points.length === 0) return;
    const lines = [...new Set(points.map(({ line }) => line))];
    const line = this.chosen?.line ?? lines[0], own = points.filter((point) => point.line === line);
    const at = own.indexOf(this.chosen);
    const next = {
      ArrowRight: () => own[Math.min(at + 1, own.length - 1)],
      ArrowLeft: () => own[Math.max(at < 0 ? 0 : at - 1, 0)],
      Home: () => own[0],
      End: () => own[own.length - 1],
      ArrowDown: () => points.find((point) => point.line === lines[(lines.indexOf(line) + 1) % lines.length]),
      ArrowUp: () => points.find((point) => point.line === lines[(lines.indexOf(line) + lines.length - 1) % lines.length]),
      Escape: () => null,
    }[event.key];
    if (!next) return;
    event.preventDefault();
    this.show(next());
  }

  show(point) {
    if (point === this.chosen) return;
    this.chosen = point;
    this.tip.hidden = !point;
    if (point) {
      const { chart } = this, { x, y } = chart.figure;
      const name = chart.groups.of.get(point.line) ?? point.line.label;
      const lines = [name, ...(point.x === null ? [] : [`${x.label} = ${readable(point.x)}`]), `${y.label} = ${readable(point.y)}`];
      this.tip.replaceChildren(...lines.filter(Boolean).map((text) => element("div", { textContent: text })));
      const place = point.x === null ? chart.plot.over.clientWidth / 2 : chart.plot.valToPos(point.x, "x");
      const height = chart.plot.valToPos(point.y, "y");
      this.tip.style.left = `${place}px`;
      this.tip.style.top = `${height}px`;
      this.tip.classList.toggle("leftwards", place > chart.plot.over.clientWidth - 220);
      this.tip.classList.toggle("downwards", height < 80);
    }
    this.chart.redraw();
  }

  ring(context) {
    if (!this.chosen || this.chosen.x === null) return;
    const { chart, chosen } = this;
    strokeStyle(chart, context, "var(--ink)", 2);
    context.beginPath();
    context.arc(chart.px(chosen.x), chart.py(chosen.y), 6.5 * chart.ratio, 0, 2 * Math.PI);
    context.stroke();
  }
}
