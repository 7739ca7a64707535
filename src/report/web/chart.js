// One picture, drawn by uPlot from its layers, which zooms, pans and points together with those that share its axes.

class Chart {
  static leftAxis = 88;

  /// @param figure what plot::Figure::live() wrote @param links Link by name @param special painters of layers that are not
  /// in layerPainters @param dragY whether dragging upwards zooms, too
  constructor(host, name, figure, links, { special = {}, dragY = false, height = figure.height } = {}) {
    Object.assign(this, { host, name, figure, links, special, height });
    this.overlays = [];  // functions (chart, context), painted last
    this.hidden = new Set();
    this.lines = figure.layers.filter(({ kind }) => kind === "line");
    this.curves = this.lines.map((line) => new Curve(line));
    this.groups = groupsOf(figure.layers);
    this.link = { x: this.linkOf(figure.x), y: this.linkOf(figure.y) };
    this.isSeries = this.lines.length > 0 && !figure.y.log && figure.x.link === "t";
    this.plot = new uPlot(this.options(dragY), this.data(), host);
    this.addCursor();
    this.listen();
  }

  linkOf(axis) {
    const link = (axis.link && this.links[axis.link]) || new Link(Boolean(axis.log));
    link.include(Math.min(axis.low, axis.high), Math.max(axis.low, axis.high));
    return link;
  }

  data() {
    const { x } = this.figure;
    return [null, ...this.lines.map((line) => [line.x, line.y]), [[x.low, x.high], [null, null]]];
  }

  options(dragY) {
    const { x, y, title } = this.figure;
    const scale = (axis, key) => ({
      time: false, auto: false, distr: axis.log ? 3 : 1, dir: axis.low > axis.high ? -1 : 1, range: () => this.shown(key) });
    const series = this.lines.map((line) => ({
      facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }],
      stroke: () => colour(line.colour), width: line.width, dash: dashOf(line).length > 0 ? dashOf(line) : undefined,
      paths: uPlot.paths.linear(), points: { show: false } }));
    const none = { facets: [{ scale: "x", auto: false }, { scale: "y", auto: false }], paths: () => null, points: { show: false } };
    return {
      mode: 2, width: this.width, height: this.height, padding: [10, 20, 0, 0], pxAlign: 0,
      scales: { x: scale(x, "x"), y: scale(y, "y") },
      axes: [this.axis(x, "x"), this.axis(y, "y")],
      series: [{}, ...series, none],
      legend: { show: false, live: false },
      cursor: {
        x: false, y: false, points: { show: false },
        drag: { x: true, y: dragY, uni: dragY ? 30 : null, setScale: false, dist: 4 },
        bind: {
          dblclick: () => () => { this.reset(); return null; },
          mousedown: (plot, target, start) => (event) => (event.shiftKey ? this.startPan(event) : start(event)) },
      },
      hooks: {
        drawAxes: [(plot) => this.paint(plot.ctx, (layer) => lowerLayers.has(layer.kind))],
        draw: [(plot) => this.paint(plot.ctx, (layer) => !lowerLayers.has(layer.kind), true)],
        setSelect: [(plot) => this.selected(plot.select)],
        setCursor: [(plot) => this.pointerMoved(plot.cursor)],
      },
    };
  }

  axis(axis, key) {
    const ticks = axis.log
      ? { splits: (plot, i, low, high) => decadeTicks(low, high),
          values: (plot, ticks) => decadeLabels(ticks, plot.scales[key].min, plot.scales[key].max,
            key === "x" ? Math.max(2, Math.min(12, Math.floor((this.width - Chart.leftAxis) / 44))) : 7),
          filter: (plot, ticks) => ticks }
      : axis.bare ? { splits: () => [], values: () => [] }
      : { incrs: tickSteps, values: (plot, ticks, i, space, step) => linearLabels(ticks, step) };
    const grid = { stroke: () => colour("var(--faint)"), width: 1, filter: (plot, ticks) => ticks };
    // Whole pixels: uPlot multiplies the last digits before "px" on finer screens.
    const font = (size) => `${size}px ${getComputedStyle(document.body).fontFamily}`;
    return {
      scale: key, side: key === "x" ? 2 : 3, label: axis.label, labelSize: 24, labelGap: 0, size: key === "x" ? 28 : Chart.leftAxis - 24,
      space: key === "x" ? 70 : 34, gap: 5, font: font(12), labelFont: font(13),
      stroke: () => colour("var(--soft)"), grid, 
      ticks: { ...grid, stroke: () => colour("var(--soft)"), size: 5 }, ...ticks };
  }

  get ratio() { return devicePixelRatio || 1; }
  get width() { return Math.max(240, Math.floor(this.host.clientWidth)); }

  /// The part of an axis in view.
  shown(key) {
    const axis = this.figure[key], whole = [Math.min(axis.low, axis.high), Math.max(axis.low, axis.high)];
    const range = this.link[key].range;
    if (range) return range;
    if (key === "y" && this.isSeries && this.link.x.range) {
      const levels = this.figure.layers.filter(({ kind }) => kind === "level").map(({ y }) => y);
      const curves = this.curves.filter((_, i) => !this.hidden.has(this.groups.of.get(this.lines[i])));
      return fittedRange(curves, levels, ...this.link.x.range) ?? whole;
    }
    return whole;
  }

  get box() { return this.plot.bbox; }
  px(x) { return this.plot.valToPos(x, "x", true); }
  py(y) { return this.plot.valToPos(y, "y", true); }

  paint(context, belongs, withOverlays = false) {
    const { left, top, width, height } = this.box;
    context.save();
    context.beginPath();
    context.rect(left, top, width, height);
    context.clip();
    for (const layer of this.figure.layers) {
      if (layer.kind === "line" || !belongs(layer) || this.hidden.has(this.groups.of.get(layer))) continue;
      const painter = this.special[layer.kind] ?? layerPainters[layer.kind];
      if (painter) painter(this, context, layer);
    }
    if (withOverlays) for (const overlay of this.overlays) overlay(this, context);
    context.restore();
    if (withOverlays) {
      strokeStyle(this, context, "var(--soft)", 1);
      context.strokeRect(left, top, width, height);
    }
  }

  listen() {
    const rescale = () => this.plot.batch(() => {
      for (const key of ["x", "y"]) {
        const [min, max] = this.shown(key);
        this.plot.setScale(key, { min, max });
      }
      this.placeCursor();
    });
    this.link.x.onRange.add(rescale);
    this.link.y.onRange.add(rescale);
    this.rescale = rescale;
    this.link.x.onPlace.add(() => this.placeCursor());
    this.link.y.onPlace.add(() => this.placeCursor());
    onTheme.add(() => this.redraw());
    new ResizeObserver(() => {
      if (this.host.clientWidth === 0 || this.width === this.plot.width) return;
      this.plot.setSize({ width: this.width, height: this.height });
      this.placeCursor();
    }).observe(this.host);
    this.plot.over.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  redraw() { this.plot.redraw(false, false); }

  toggle(group) {
    if (!this.hidden.delete(group)) this.hidden.add(group);
    this.lines.forEach((line, i) => this.plot.setSeries(i + 1, { show: !this.hidden.has(this.groups.of.get(line)) }, false));
    this.rescale();
    this.redraw();
  }

  addCursor() {
    this.cursor = ["x", "y"].map((key) => {
      const line = element("div", { className: `cursor-${key}` });
      this.plot.over.append(line);
      return [key, line];
    });
    this.placeCursor();
  }

  placeCursor() {
    for (const [key, line] of this.cursor) {
      const link = this.link[key], place = link.place, [low, high] = this.shown(key);
      line.hidden = place === null || place < low || place > high;
      if (line.hidden) continue;
      line.classList.toggle("pointed", link.pointed !== null);
      const at = this.plot.valToPos(place, key);
      line.style.transform = key === "x" ? `translateX(${at}px)` : `translateY(${at}px)`;
    }
  }

  pointerMoved({ left, top }) {
    const inside = left >= 0 && top >= 0;
    for (const [key, at] of [["x", left], ["y", top]])
      if (this.figure[key].link) this.link[key].point(inside ? this.plot.posToVal(at, key) : null);
    this.onPointer?.(inside ? { left, top } : null);
  }

  selected({ left, top, width, height }) {
    const { width: whole, height: tall } = this.plot.over.getBoundingClientRect();
    this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    const range = (key, from, to) => [this.plot.posToVal(from, key), this.plot.posToVal(to, key)].sort((a, b) => a - b);
    const x = width > 4 && width < whole - 1 ? range("x", left, left + width) : null;
    const y = height > 4 && height < tall - 1 ? range("y", top, top + height) : null;
    if (x) this.link.x.show(x);
    if (y) this.link.y.show(y);
  }

  reset() {
    this.link.x.show(null);
    this.link.y.show(null);
  }

  wheel(event) {
    const zooms = event.ctrlKey || event.metaKey, pans = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (!zooms && !(pans && this.link.x.range)) return;
    event.preventDefault();
    const { left, width } = this.plot.over.getBoundingClientRect();
    const step = event.shiftKey && !event.deltaX ? event.deltaY : event.deltaX;
    if (zooms) this.link.x.zoom(Math.exp(Math.sign(event.deltaY) * 0.2), this.plot.posToVal(event.clientX - left, "x"));
    else this.link.x.pan(step / width);
  }

  startPan(down) {
    const { width } = this.plot.over.getBoundingClientRect();
    let at = down.clientX;
    const move = (event) => {
      this.link.x.pan((at - event.clientX) / width);
      at = event.clientX;
    };
    const stop = () => {
      removeEventListener("mousemove", move);
      removeEventListener("mouseup", stop);
    };
    addEventListener("mousemove", move);
    addEventListener("mouseup", stop);
    down.preventDefault();
  }
}

/// What the legend switches on and off together: a labelled layer and those without label that follow in its colour.
function groupsOf(layers) {
  const labels = [], of = new Map(), ofColour = new Map();
  for (const layer of layers) {
    if (layer.label) {
      if (!labels.some(({ label }) => label === layer.label)) labels.push({ label: layer.label, layer });
      of.set(layer, layer.label);
      ofColour.set(layer.colour, layer.label);
    } else if (layer.kind !== "upright" && ofColour.has(layer.colour)) {
      of.set(layer, ofColour.get(layer.colour));
    }
  }
  return { labels, of };
}
