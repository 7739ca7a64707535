// A picture of the page, as the program drew it, to zoom and to point at together with those that share its axes. The
// frame of the SVG is a view into what is drawn, so zooming is another view; axes are drawn anew for it.

class Chart {
  static margin = { left: 80, right: 22, top: 12, bottom: 46 };
  static narrow = { left: 64, right: 20 };

  /// @param panel holds the SVG, which stays as it is for print @param links Link by name @param dragY whether dragging upwards
  /// zooms, too
  constructor(panel, links, dragY) {
    const still = panel.querySelector("svg"), svg = still.cloneNode(true), json = (name) => JSON.parse(still.dataset[name]);
    Object.assign(this, { svg, dragY, name: panel.dataset.picture, title: still.ariaLabel, x: json("x"), y: json("y") });
    svg.querySelectorAll(".still").forEach((node) => node.remove());
    [this.inner, this.legend] = [svg.querySelector("svg"), svg.querySelector(".legend")];
    this.overlay = svgElement("svg");
    this.axes = { grid: svgElement("g"), edge: svgElement("g") };
    svg.replaceChildren(this.axes.grid, this.inner, this.axes.edge, this.overlay);
    const [left, top, width, height] = this.inner.getAttribute("viewBox").split(" ").map(Number);
    this.height = Number(still.dataset.height ?? still.viewBox.baseVal.height);
    this.tall = this.height - Chart.margin.top - Chart.margin.bottom;
    this.drawn = { left, top, width, height, x: new Scale(this.x, left, left + width), y: new Scale(this.y, top + height, top) };
    if (this.y.rows) this.space = this.tall / (this.y.rows.length + 1);  // each of them has its name
    // One that is lower than it was drawn shows the top of it.
    if (this.y.bare) this.y.low = this.drawn.y.value(top + this.tall);
    this.link = { x: this.linkOf(this.x, links), y: this.linkOf(this.y, links) };
    this.overTime = this.x.link === "t";
    this.fixed = [...this.inner.querySelectorAll(".fixed")].map((node) => [node, ...node.getAttribute("transform").match(/[\d.-]+/g)]);
    this.curves = [...this.inner.querySelectorAll("path.line[d^=M]")].map((node) => new Curve(node));
    this.hidden = new Set();
    this.painters = [];  // functions of the chart, called whenever the view is another
    this.over = element("div", { className: "over" });
    this.select = element("div", { className: "select", hidden: true });
    this.cursor = { x: element("div", { className: "cursor-x" }), y: element("div", { className: "cursor-y" }) };
    this.over.append(this.select, this.cursor.x, this.cursor.y);
    this.host = element("div", { className: "chart", tabIndex: 0, role: "group" }, svg, this.over);
    panel.append(element("div", { className: "live" }, this.host));
    this.layout();
    this.listen();
  }

  linkOf(axis, links) {
    const link = links[axis.link] ?? new Link(Boolean(axis.log));
    link.include(Math.min(axis.low, axis.high), Math.max(axis.low, axis.high));
    return link;
  }

  /// Takes the width that there is.
  layout() {
    this.width = Math.max(240, Math.floor(this.host.clientWidth));
    setAttributes(this.svg, { viewBox: `0 0 ${this.width} ${this.height}`, width: this.width, height: this.height });
    setAttributes(this.inner, { preserveAspectRatio: "none" });
    this.show();
  }

  /// Where the frame is, with room for the labels of an axis upwards.
  place(upwards) {
    const margin = { ...Chart.margin, ...(this.width < 560 && Chart.narrow) }, { right, top } = margin;
    const left = upwards ? Math.max(margin.left, roomBeside(upwards, this.space)) : margin.left;
    const frame = (this.frame = { left, top, width: this.width - left - right, height: this.tall });
    for (const part of [this.inner, this.overlay]) setAttributes(part, { x: left, y: top, width: frame.width, height: frame.height });
    setAttributes(this.overlay, { viewBox: `${left} ${top} ${frame.width} ${frame.height}` });
    for (const key of ["left", "top", "width", "height"]) this.over.style[key] = `${frame[key]}px`;
  }

  /// Draws the part of the axes that is in view.
  show() {
    const { drawn, x, y } = this, [low, high] = this.seen("x"), [down, up] = this.seen("y"), { top } = Chart.margin;
    const upwards = new Scale({ ...y, low: down, high: up }, top + this.tall, top);
    const labelled = y.rows ? new WordScale(y.rows, top, top + this.tall) : y.bare ? null : upwards;
    this.place(labelled);
    const { frame } = this;
    this.view = { x: new Scale({ ...x, low, high }, frame.left, frame.left + frame.width), y: upwards };
    const [left, right, upper, lower] = [drawn.x.at(low), drawn.x.at(high), drawn.y.at(up), drawn.y.at(down)];
    setAttributes(this.inner, { viewBox: `${left} ${upper} ${right - left} ${lower - upper}` });
    const across = (right - left) / frame.width, along = (lower - upper) / frame.height;
    for (const [node, at, level] of this.fixed) setAttributes(node, { transform: `translate(${at} ${level}) scale(${across} ${along})` });
    const axes = axesOf(frame, x.bare ? null : this.view.x, labelled, x.label, y.label, this.space);
    this.axes.grid.replaceWith(axes.grid);
    this.axes.edge.replaceWith(axes.edge);
    this.axes = axes;
    this.paint();
    this.placeCursor();
  }
  paint() { this.overlay.replaceChildren(...this.painters.flatMap((painter) => painter(this))); }

  px(x) { return this.view.x.at(x); }
  py(y) { return this.view.y.at(y); }
  /// The part of an axis in view: zoomed over time, lines have a range that fits them.
  seen(key) {
    const fits = key === "y" && this.overTime && !this.y.log && this.link.x.range;
    return this.link[key].range ?? (fits ? this.fittedRange() : null) ?? [this[key].low, this[key].high];
  }
  fittedRange() {
    const [from, to] = this.link.x.range.map((value) => this.drawn.x.at(value));
    const values = this.curves.filter((curve) => !this.hidden.has(curve.key)).flatMap((curve) => curve.values(from, to));
    const levels = [...this.inner.querySelectorAll("[data-level]")].map((node) => Number(node.dataset.level));
    return rangeAround(values.map((at) => this.drawn.y.value(at)), levels);
  }
  /// The value of a curve at a place of the axis along, to the digits with which it is drawn.
  valueOf(curve, at) {
    const { x, y, height } = this.drawn, unit = 10 ** Math.ceil(Math.log10((y.high - y.low) / height / 1000));
    return Number((Math.round(y.value(curve.at(x.at(at))) / unit) * unit).toPrecision(12));
  }

  listen() {
    const { over, link, host } = this;
    for (const key of ["x", "y"]) {
      link[key].onRange.add(() => this.show());
      link[key].onPlace.add(() => this.placeCursor());
    }
    new ResizeObserver(() => host.clientWidth > 0 && this.width !== Math.max(240, host.clientWidth) && this.layout()).observe(host);
    over.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    over.addEventListener("dblclick", () => this.reset());
    over.addEventListener("mousedown", (event) => event.button === 0 && (event.shiftKey ? this.pan(event) : this.drag(event)));
    over.addEventListener("mousemove", (event) => this.point(event));
    over.addEventListener("mouseleave", () => this.point(null));
  }

  /// Hides or shows what belongs to a line of the legend.
  toggle(key) {
    if (!this.hidden.delete(key)) this.hidden.add(key);
    for (const node of this.inner.querySelectorAll("[data-key]")) node.style.display = this.hidden.has(node.dataset.key) ? "none" : "";
    this.show();
  }

  placeCursor() {
    for (const key of ["x", "y"]) {
      const { place, pointed } = this.link[key], line = this.cursor[key], [low, high] = this.seen(key);
      line.hidden = place === null || place < low || place > high;
      line.classList.toggle("pointed", pointed !== null);
      const at = this.view[key].at(place) - this.frame[key === "x" ? "left" : "top"];
      if (!line.hidden) line.style.transform = key === "x" ? `translateX(${at}px)` : `translateY(${at}px)`;
    }
  }

  /// Where the mouse is, in pixels of the SVG, not beyond the frame.
  placeOf({ clientX, clientY }) {
    const { left, top } = this.over.getBoundingClientRect(), { frame } = this;
    const within = (at, from, size) => Math.min(from + size, Math.max(from, at));
    return [within(clientX - left + frame.left, frame.left, frame.width), within(clientY - top + frame.top, frame.top, frame.height)];
  }
  point(event) {
    const [x, y] = event ? this.placeOf(event) : [];
    if (this.x.link) this.link.x.point(event ? this.view.x.value(x) : null);
    if (this.y.link) this.link.y.point(event ? this.view.y.value(y) : null);
    this.onPointer?.(event ? [x, y] : null);
  }

  /// Calls back while the mouse moves with its button down, and when it is up.
  follow(down, moved, done = () => {}) {
    const stop = (event) => {
      removeEventListener("mousemove", moved);
      removeEventListener("mouseup", stop);
      done(event);
    };
    addEventListener("mousemove", moved);
    addEventListener("mouseup", stop);
    down.preventDefault();
    this.host.focus({ preventScroll: true });
  }
  /// Zooms to what is dragged over: along, or upwards, or both where that is meant. Without a way it is a click.
  drag(down) {
    const [x0, y0] = this.placeOf(down), { frame, select } = this, least = 4, meant = 30;
    const boxTo = (event) => {
      const [x, y] = this.placeOf(event), along = Math.abs(x - x0), up = this.dragY ? Math.abs(y - y0) : 0;
      return { x: along > least && !(up > meant && along < meant) && [x0, x].sort((a, b) => a - b),
        y: up > least && (along <= least || up > meant) && [y, y0].sort((a, b) => b - a) };
    };
    this.follow(down, (event) => {
      const { x, y } = boxTo(event), [left, right] = x || [frame.left, frame.left + frame.width], [bottom, top] = y || [frame.top + frame.height, frame.top];
      select.hidden = !x && !y;
      Object.assign(select.style, { left: `${left - frame.left}px`, width: `${right - left}px`, top: `${top - frame.top}px`, height: `${bottom - top}px` });
    }, (event) => {
      select.hidden = true;
      const { x, y } = boxTo(event), { view } = this;
      const values = (scale, ends) => ends.map((at) => scale.value(at));
      if (!x && !y) return this.onClick?.(view.x.value(x0));
      const [along, up] = [x && values(view.x, x), y && values(view.y, y)];
      if (along) this.link.x.show(along);
      if (up) this.link.y.show(up);
    });
  }
  pan(down) {
    let at = down.clientX;
    this.follow(down, (event) => {
      this.link.x.pan((at - event.clientX) / this.frame.width);
      at = event.clientX;
    });
  }
  wheel(event) {
    const zooms = event.ctrlKey || event.metaKey, pans = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
    if (!zooms && !(pans && this.link.x.range)) return;
    event.preventDefault();
    const step = event.shiftKey && !event.deltaX ? event.deltaY : event.deltaX;
    if (zooms) this.link.x.zoom(Math.exp(Math.sign(event.deltaY) * 0.2), this.view.x.value(this.placeOf(event)[0]));
    else this.link.x.pan(step / this.frame.width);
  }
  reset() {
    this.link.x.show(null);
    this.link.y.show(null);
  }
}

/// A line of a picture, in the coordinates of its SVG.
class Curve {
  constructor(node) {
    this.key = node.dataset.key;
    const points = node.getAttribute("d").slice(1).split("L").map((point) => point.split(" ").map(Number));
    [this.x, this.y] = [0, 1].map((k) => points.map((point) => point[k]));
  }
  at(place) {
    const { x, y } = this;
    return place < x[0] || place > x.at(-1) ? NaN : Field.interpolated(x, y, place);
  }
  /// The values over a part, at its ends too.
  values(from, to) {
    const inside = this.y.filter((_, i) => this.x[i] >= from && this.x[i] <= to);
    return [this.at(from), ...inside, this.at(to)].filter(Number.isFinite);
  }
}

/// A range for values, with room around them and the levels that lie near; null where they are all the same.
function rangeAround(values, levels) {
  let low = Math.min(...values), high = Math.max(...values);
  const size = Math.max(high - low, 1e-9 * Math.max(Math.abs(low), Math.abs(high)));
  if (!(low <= high) || size === 0) return null;
  const near = levels.filter((level) => level > low - size && level < high + size);
  [low, high] = [Math.min(low, ...near), Math.max(high, ...near)];
  const margin = 0.06 * Math.max(high - low, size);
  return [low - margin, high + margin];
}
