// Contact changes: marks on the pictures over time, and the table's rows.

class Events {
  constructor({ happened, every, places, place, t, closes, velocity }) {
    Object.assign(this, { happened, every });
    this.list = t.map((time, i) => ({ time, place: places[place[i]], closes: closes[i] === 1, velocity: velocity[i] }));
    this.rounding = 1e-12 * Math.max(1, Math.abs(t.at(-1) ?? 1));
    this.onChosen = new Set();
    this.chosen = null;
  }

  choose(event) {
    if (event === this.chosen) return;
    this.chosen = event;
    for (const listener of this.onChosen) listener(event);
  }
  static side({ place }) { return place === "left" || place === "right" ? place : "span"; }
  static name({ place }) {
    if (place === "left" || place === "right") return `${place} end`;
    const [where, number] = place.split(":");
    return where === "joint" ? `joint ${number}` : `node ${number} of the span`;
  }
  static words(event) {
    return `t = ${withUnit(event.time, "time", 8)}: ${Events.name(event)} ${event.closes ? "closes" : "opens"}, ` +
      `velocity ${withUnit(event.velocity, "velocity")}`;
  }

  /// The first one after, or the last one before, a time.
  next(time) { return this.list.find((event) => event.time > time + this.rounding) ?? null; }
  previous(time) { return this.list.findLast((event) => event.time < time - this.rounding) ?? null; }

  /// The nearest within a distance, of those that `belongs` lets pass.
  nearest(time, distance, belongs = () => true) {
    let best = null;
    for (const event of this.list) {
      const away = Math.abs(event.time - time);
      if (away <= distance && belongs(event)) [best, distance] = [event, away];
    }
    return best;
  }

  /// Marks along the upper edge of a picture, pointing down where a contact closes and up where it opens. Of
  /// marks that would lie on each other one is drawn; zooming in shows the others.
  marksOn(belongs) {
    const mark = (at, top, size, { closes }) => {
      const [base, tip] = closes ? [top, top + 1.6 * size] : [top + 1.6 * size, top];
      return `M${(at - size).toFixed(1)} ${base}h${2 * size}L${at.toFixed(1)} ${tip}z`;
    };
    return (chart) => {
      const { low, high } = chart.view.x, top = chart.frame.top + 1.5, size = 4;
      let d = "", last = -Infinity;
      for (const event of this.list) {
        if (event.time < low || event.time > high || !belongs(event)) continue;
        const at = chart.px(event.time);
        if (at - last < size) continue;
        last = at;
        d += mark(at, top, size, event);
      }
      const { chosen } = this, shown = chosen && belongs(chosen) && chosen.time >= low && chosen.time <= high;
      return [svgElement("path", { class: "change", d }),
        ...(shown ? [svgElement("path", { class: "change chosen", d: mark(chart.px(chosen.time), top, 6, chosen) })] : [])];
    };
  }

  /// A table of all of them in place of the page's own; arrow keys move, Enter and a click jump there.
  table(section, jump) {
    const table = tableOf([headed("time", "time"), "where", "change", headed("velocity", "velocity")], this.list.map((event) => ({
      texts: [readable(event.time, 8), Events.name(event), event.closes ? "closes" : "opens", readable(event.velocity)],
      action: () => jump(event) })), ["", "word", "word", ""]);
    table.ariaLabel = "Contact changes";
    const scroller = element("div", { className: "live tables scroller" }, table), body = table.tBodies[0], rows = [...body.rows];
    rows.forEach((row, i) => { row.tabIndex = i === 0 ? 0 : -1; });
    body.addEventListener("keydown", (event) => {
      const at = rows.indexOf(event.target);
      const goal = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: rows.length - 1 }[event.key];
      if (goal === undefined && event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      if (goal === undefined) jump(this.list[at]);
      else rows[goal]?.focus();
    });
    body.addEventListener("focusin", (event) => {
      for (const row of rows) row.tabIndex = row === event.target ? 0 : -1;
    });
    this.onChosen.add((event) => {
      const at = this.list.indexOf(event);
      rows.forEach((row, i) => row.setAttribute("aria-selected", String(i === at)));
      if (at >= 0) keepInView(scroller, rows[at]);
    });
    const left = this.every === 1 ? "" :
      ` Of ${this.happened} changes the fastest of every ${this.every} in a row is marked and listed; events.csv has all.`;
    section.append(scroller, element("p", { className: "live note", textContent: `A click on a row or a mark goes there.${left}` }));
  }
}

/// Scrolls a box, not the page.
function keepInView(box, row) {
  const above = row.offsetTop - box.scrollTop, below = above + row.offsetHeight - box.clientHeight;
  if (above < 32) box.scrollTop = row.offsetTop - 32;
  else if (below > 0) box.scrollTop += below;
}
