// The page of a sweep: any column over one or two of the varied keys, as lines or as a map, and the run behind a point.

/// The range of an axis for values, with room around them.
function spreadOf(values, log) {
  const finite = values.filter((value) => value !== null && Number.isFinite(value) && (!log || value > 0));
  const [low, high] = finite.length > 0 ? [Math.min(...finite), Math.max(...finite)] : log ? [0.1, 1] : [0, 1];
  const factor = high / low < 1.5 ? 1.5 : (high / low) ** 0.04;
  if (log) return { low: low / factor, high: high * factor, log };
  const room = high > low ? 0.05 * (high - low) : Math.abs(high) * 0.1 || 1;
  return { low: low - room, high: high + room };
}

/// True of values that ask for a logarithmic axis: positive, over more than a decade and a half.
const isGeometric = (values) => {
  const numbers = values.filter((value) => typeof value === "number");
  return numbers.length > 2 && Math.min(...numbers) > 0 && Math.max(...numbers) / Math.min(...numbers) > 30;
};

class SweepPage {
  static height = 430;
  static mostNamed = 18; // lines that the legend names; more of them are a map at first
  get width() { return Math.max(320, Math.min(960, this.host.clientWidth)); }

  /// @param data what src/sweep/sweep_page.cpp writes
  constructor(data, host) {
    Object.assign(this, { data, host });
    this.keys = data.keys.map((key, place) => ({ ...key, place, numeric: key.values.every((value) => typeof value === "number") }));
    const varying = this.keys.filter(({ values }) => values.length > 1);
    const x = varying.filter(({ numeric }) => numeric).sort((a, b) => b.values.length - a.values.length)[0] ?? varying[0] ?? this.keys[0];
    const second = data.zip ? null : varying.find((key) => key !== x) ?? null;
    this.state = { column: Math.max(0, data.columns.findIndex(({ name }) => name === data.first)), x: x.place, second: second?.place ?? null,
      map: (second?.values.length ?? 0) > SweepPage.mostNamed, log: false,
      filters: this.keys.map(() => 0), chosen: null };
    this.build();
    this.draw();
    let width = this.width;
    new ResizeObserver(() => {
      if (this.width === width) return;
      width = this.width;
      this.draw();
    }).observe(host);
  }

  select(label, options, value, action) {
    const node = element("select", { ariaLabel: label }, ...options.map(([option, text]) =>
      element("option", { value: option, textContent: text, selected: String(option) === String(value) })));
    node.addEventListener("change", () => { action(node.value); this.build(); this.draw(); });
    return element("label", { className: "choice" }, element("span", { textContent: label }), node);
  }

  build() {
    const { data, state, keys } = this, number = (text) => (text === "" ? null : Number(text));
    const names = keys.map(({ name, place }) => [place, name]);
    const controls = [
      this.select("Column", data.columns.map(({ name }, i) => [i, name]), state.column, (value) => { state.column = Number(value); }),
      this.select("over", names, state.x, (value) => {
        state.x = Number(value);
        if (state.second === state.x) state.second = null;
      })];
    if (!data.zip && keys.length > 1) {
      controls.push(this.select("for each", [["", "–"], ...names.filter(([place]) => place !== state.x)], state.second ?? "",
        (value) => { state.second = number(value); }));
      if (state.second !== null)
        controls.push(this.select("as", [["", "lines"], ["1", "map"]], state.map ? "1" : "", (value) => { state.map = value === "1"; }));
      else state.map = false;
      for (const { name, values, place } of keys)
        if (place !== state.x && place !== state.second && values.length > 1)
          controls.push(this.select(name, values.map((value, i) => [i, this.valueText(value)]), state.filters[place],
            (value) => { state.filters[place] = Number(value); }));
    }
    controls.push(this.select("scale", [["", "linear"], ["1", "logarithmic"]], state.log ? "1" : "", (value) => { state.log = value === "1"; }),
      element("span", { className: "space" }), themeButton());
    this.picture = element("div", { className: "sweep" });
    this.meaning = element("p", { className: "note" });
    this.detail = element("div", { className: "case", ariaLive: "polite" });
    this.list = element("div", { className: "tables scroller" });
    this.host.replaceChildren(element("div", { className: "controls" }, ...controls), this.picture, this.meaning, this.detail, this.list);
  }

  valueText(value, digits = 6) { return typeof value === "number" ? readable(value, digits) : value; }

  /// Cases that the filters leave: their place in the data, x, second key and value.
  points() {
    const { data, state, keys } = this, values = data.columns[state.column].values;
    const free = data.zip ? keys.map(({ place }) => place) : [state.x, state.second];
    return data.choice.map((choice, row) => ({ row, choice, x: choice[state.x], second: state.second === null ? 0 : choice[state.second], value: values[row] }))
      .filter(({ choice }) => choice.every((chosen, place) => free.includes(place) || chosen === state.filters[place]));
  }

  draw() {
    const { data, state } = this, column = data.columns[state.column], points = this.points();
    const unit = column.unit === "1" ? "" : ` (${column.unit})`;
    this.meaning.textContent = `${column.name}: ${column.meaning}${unit}. Point at a mark for its numbers, click on it for its run.`;
    const svg = svgElement("svg", { viewBox: `0 0 ${this.width} ${SweepPage.height}`, role: "img", "aria-label": `${column.name} over ${this.keys[state.x].name}` });
    this.picture.replaceChildren(svg);
    state.map && state.second !== null ? this.drawMap(svg, points, column) : this.drawLines(svg, points, column);
    this.showList(points, column);
    this.showCase();
  }

  axisOf(key, from, to) {
    return key.numeric ? new Scale(spreadOf(key.values, isGeometric(key.values)), from, to) : this.wordsOf(key, from, to);
  }
  wordsOf(key, from, to) { return new WordScale(key.values.map((value) => this.valueText(value, 3)), from, to); }
  placeOn(axis, key, index) { return axis.at(key.numeric ? key.values[index] : index); }

  frame(svg, x, y, xLabel, yLabel) {
    const { grid, edge } = axesOf({ left: x.from, top: y.to, width: x.to - x.from, height: y.from - y.to }, x, y, xLabel, yLabel);
    svg.append(grid, edge);
  }

  drawLines(svg, points, column) {
    const { data, state, keys } = this, key = keys[state.x], second = state.second === null ? null : keys[state.second];
    const letters = second ? Math.max(second.label.length - 5, ...second.values.map((value) => this.valueText(value).length)) : 0;
    const right = this.width - (second ? Math.min(0.6 * this.width, Math.max(0.1 * this.width + 84, 54 + 7.3 * letters)) : 20);
    const y = new Scale(spreadOf(points.map(({ value }) => value), state.log), SweepPage.height - 56, 14);
    const x = this.axisOf(key, Math.max(72, roomBeside(y)), right);
    this.frame(svg, x, y, key.label, column.label);
    const of = (index) => points.filter((point) => point.second === index);
    const count = second ? second.values.length : 1;
    for (let k = 0; k < count; ++k) {
      const own = of(k).filter(({ value }) => value !== null && (!state.log || value > 0))
        .sort((a, b) => this.placeOn(x, key, a.x) - this.placeOn(x, key, b.x));
      const css = `var(--series-${k % 10})`, dash = data.dashes[k % data.dashes.length], marker = data.markers[k % data.markers.length];
      const places = own.map((point) => [this.placeOn(x, key, point.x), y.at(point.value)]);
      if (key.numeric && places.length > 1)
        svg.append(svgElement("path", { class: "line", style: `stroke:${css};stroke-width:1.6;stroke-dasharray:${dash || "none"}`, d: `M${places.map((place) => place.map((v) => v.toFixed(1)).join(" ")).join("L")}` }));
      own.forEach((point, i) => svg.append(this.shape(point, column, "path", "mark",
        { style: `fill:${css};stroke:${css}`, d: marker, transform: `translate(${places[i].join(" ")}) scale(${own.length > 120 ? 0.5 : 1})` })));
      if (!second || k > SweepPage.mostNamed) continue;
      const height = 24 + 19 * k;
      svg.append(svgElement("path", { class: "line", style: `stroke:${css};stroke-width:1.6;stroke-dasharray:${dash || "none"}`, d: `M${right + 12} ${height}h26` }),
        svgElement("path", { style: `fill:${css};stroke:${css}`, d: marker, transform: `translate(${right + 25} ${height})` }),
        svgElement("text", { x: right + 46, y: height, dy: ".35em" }, k === SweepPage.mostNamed ? "…" : this.valueText(second.values[k])));
    }
    if (second) svg.append(svgElement("text", { class: "note", x: right + 12, y: 10 }, second.label));
  }

  /// The mark of a case: a click on it shows its run.
  shape(point, column, name, kind, attributes) {
    const node = svgElement(name, { class: `${kind}${point.row === this.state.chosen ? " chosen" : ""}`, ...attributes },
      svgElement("title", {}, `${this.words(point)}: ${column.name} = ${readable(point.value, 6)}`));
    node.addEventListener("click", () => this.choose(point.row));
    return node;
  }

  words({ choice, row }) {
    return `case ${this.data.index[row]}, ${this.keys.map(({ name, values }, k) => `${name} = ${this.valueText(values[choice[k]])}`).join(", ")}`;
  }

  drawMap(svg, points, column) {
    const { state, keys, data } = this, key = keys[state.x], second = keys[state.second];
    const [top, bottom] = [14, SweepPage.height - 56];
    const y = this.wordsOf(second, bottom, top), x = this.wordsOf(key, Math.max(72, roomBeside(y)), this.width - 110);
    const scale = new Scale(spreadOf(points.map(({ value }) => value), state.log), 0, 1);
    const shade = (part) => `rgb(${mixed(data.anchors, Math.min(1, Math.max(0, part)))})`;
    const width = Math.abs(x.at(1) - x.at(0)), height = Math.abs(y.at(1) - y.at(0));
    this.frame(svg, x, y, key.label, second.label);
    for (const point of points) {
      const known = point.value !== null && (!state.log || point.value > 0);
      svg.append(this.shape(point, column, "rect", "cell", { x: x.at(point.x) - width / 2, y: y.at(point.second) - height / 2,
        width, height, style: `fill:${known ? shade(scale.at(point.value)) : "var(--faint)"}` }));
    }
    const steps = 60;
    for (let k = 0; k < steps; ++k)
      svg.append(svgElement("rect", { x: this.width - 96, width: 16, y: top + ((bottom - top) * k) / steps, height: (bottom - top) / steps + 0.5, style: `fill:${shade(1 - (k + 0.5) / steps)}` }));
    const values = new Scale(scale, bottom, top);
    for (const [at, label] of values.ticks(upwardSpace)) svg.append(svgElement("text", { x: this.width - 74, y: at, dy: ".35em" }, label));
    if (values.exponent) svg.append(svgElement("text", { class: "note", x: this.width - 96, y: bottom + 18 }, `/ ${powerOfTen(values.exponent)}`));
  }

  choose(row) {
    this.state.chosen = row;
    this.draw();
    this.detail.scrollIntoView({ block: "nearest" });
  }

  /// The run behind the chosen point.
  showCase() {
    const { chosen } = this.state, { data, keys } = this;
    this.detail.replaceChildren();
    if (chosen === null) return;
    const entries = [...keys.map(({ label, values }, k) => [label, this.valueText(values[data.choice[chosen][k]])]),
      ...data.columns.filter(({ values }) => values[chosen] !== null).map(({ label, values }) => [label, readable(values[chosen], 8)])];
    const settings = keys.map(({ name, values }, k) => `--set '${name}=${values[data.choice[chosen][k]]}'`).join(" ");
    const error = data.errors[chosen];
    this.detail.append(element("h3", { textContent: `Case ${data.index[chosen]}` }),
      ...(error ? [element("p", { className: "failed", textContent: error })] : []),
      element("dl", {}, ...entries.map(([name, value]) => element("div", {}, element("dt", { textContent: name }), element("dd", { textContent: value })))),
      element("p", { className: "note", textContent: "To see this run:" }),
      element("pre", { textContent: `${data.command} ${settings} -o case-${data.index[chosen]}` }));
  }

  showList(points, column) {
    const most = 200, { keys, data } = this;
    const shown = points.slice(0, most);
    const table = tableOf(["case", ...keys.map(({ label }) => label), column.label], shown.map(({ row, choice, value }) => ({
      texts: [data.index[row], ...keys.map(({ values }, k) => this.valueText(values[choice[k]])),
        data.errors[row] ? "failed" : readable(value, 6)],
      action: () => this.choose(row) })));
    shown.forEach(({ row }, i) => { table.tBodies[0].rows[i].ariaSelected = String(row === this.state.chosen); });
    this.list.replaceChildren(table,
      ...(points.length > most ? [element("p", { className: "note", textContent: `and ${points.length - most} more, in sweep.csv` })] : []));
  }
}
