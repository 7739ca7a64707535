// Puts the page together: its pictures become charts, and a run has a slider of time.

const charts = new Map();
const resetAll = () => charts.forEach((chart) => chart.reset());

function startPage() {
  const data = JSON.parse(document.getElementById("data")?.textContent ?? "{}");
  Object.assign(units, data.units);
  if (data.sweep) {
    window.viscobar = { sweep: new SweepPage(data.sweep, document.getElementById("sweep")) };
    return;
  }
  const links = { t: new Link(), x: new Link(), epsilon: new Link(true) };
  const isMap = (panel) => ["displacement", "stress"].includes(panel.dataset.picture);
  for (const panel of document.querySelectorAll(".panel")) {
    const chart = new Chart(panel, links, isMap(panel) || Boolean(JSON.parse(panel.querySelector("svg").dataset.y).log));
    charts.set(chart.name, chart);
    const drawnLive = chart.name === "bar" || chart.name === "axial";
    chart.host.ariaLabel = chart.title + (drawnLive || chart.overTime ? ". Arrow keys move in time" : ". Arrow keys read points");
    chart.host.before(new Legend(chart).node);
    if (!chart.overTime && !drawnLive) new PointReader(chart);
  }
  window.viscobar = { links, charts };
  if (data.field) startRun(Object.assign(window.viscobar, { field: new Field(data.field), stress: new Field(data.stress) }), data);
  else startStudy(links);
  charts.forEach((chart) => chart.paint());
}

/// A run: slider, events, the bar that follows them.
function startRun(page, data) {
  const { links, field, stress } = page, events = new Events(data.events);
  links.t.rest = field.t[0];
  const bar = new BarPicture(field, data.axial.members, data.supports, { left: reactionOf("left end"), right: reactionOf("right end") });
  const axial = new AxialPicture(field, stress, data.supports, data.axial);
  for (const [name, moving] of [["bar", bar], ["axial", axial]]) {
    const chart = charts.get(name);
    chart.painters.push(() => moving.draw(chart, links.t.place));
    links.t.onPlace.add(() => chart.paint());
  }
  const player = new Player(links.t, field.t, events, resetAll);
  Object.assign(page, { events, player, axial });
  document.querySelector("figure").before(player.node);

  const belongs = { "left-end": (e) => Events.side(e) !== "right", "right-end": (e) => Events.side(e) !== "left" };
  for (const [name, chart] of charts) {
    chart.host.addEventListener("keydown", (event) => player.key(event));
    if (!chart.overTime) continue;
    const own = belongs[name] ?? (() => true);
    chart.painters.push(events.marksOn(own));
    events.onChosen.add(() => chart.paint());
    chart.onClick = (time) => {
      const { low, high } = chart.view.x, mark = events.nearest(time, (6 * (high - low)) / chart.frame.width, own);
      player.stop();
      if (mark) player.jump(mark);
      else player.go(time);
    };
  }
  const legendOf = (name) => charts.get(name).host.previousElementSibling;
  legendOf("axial").append(...scaleOf(charts.get("stress").legend.querySelector(".scale")));
  addReadout(legendOf("displacement"), "u", "length", field, links);
  addReadout(legendOf("stress"), "s", "stress", stress, links);
  addReadout(legendOf("bar"), "u", "length", field, links);
  const section = document.getElementById("events");
  if (section) events.table(section, (event) => player.jump(event));
  document.querySelector("footer").before(element("p", { className: "live note", textContent:
    "Keys, on the slider or a picture: arrows and page keys move in time, Home and End go to its ends, space plays, N and P go " +
    "to contact changes, + − 0 zoom. Drag to zoom, shift and drag to move the view, double click to see it all. The bar is " +
    "drawn with values rounded to 1/65535 of their range, lines with the least and greatest value of neighbouring output " +
    "times where there are many; ends.csv, events.csv and field.h5 have everything." }));
}

function startStudy(links) {
  for (const chart of charts.values()) chart.host.addEventListener("keydown", (event) => studyKey(chart, event));
  const shared = Object.values(links).filter((link) => link.bounds);
  document.querySelector("figure").before(
    element("section", { className: "player live", ariaLabel: "View" }, element("div", { className: "controls" },
      element("span", { className: "hint", textContent:
        "Point at a picture for its numbers, drag to zoom, shift and drag to move, double click to see it all; the legend hides and shows." }),
      element("span", { className: "space" }), ...viewButtons(shared, resetAll))));
}

function studyKey(chart, event) {
  const { x } = chart.link, [low, high] = chart.seen("x");
  const move = (part) => x.stand(Math.min(high, Math.max(low, (x.rest ?? low) + part * (high - low))));
  const action = {
    "+": () => x.zoom(0.5, x.place), "-": () => x.zoom(2, x.place), 0: resetAll,
    ...(chart.overTime ? { ArrowRight: () => move(0.01), ArrowLeft: () => move(-0.01), Home: () => x.stand(low), End: () => x.stand(high) } : {}),
  }[event.key];
  if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  action();
}

/// A line of the reactions as a function of time.
function reactionOf(key) {
  const chart = charts.get("reactions"), curve = chart?.curves.find((one) => one.key === key);
  if (!curve) return null;
  return { at: (time) => chart.valueOf(curve, time), most: Math.max(...curve.y.map((at) => Math.abs(chart.drawn.y.value(at)))) };
}

/// The value of a field where the pointer is.
function addReadout(node, name, quantity, field, links) {
  const value = element("span", { className: "value" }), [begin, end] = links.x.bounds;
  node.append(value);
  const read = () => {
    const t = links.t.place, x = links.x.pointed;
    value.textContent = x === null || x < begin || x > end ? "\u00a0" :
      `${name}(${readable(x, 4)}, ${readable(t, 4)}) = ${withUnit(field.known(field.value(t, x)), quantity, 4)}`;
  };
  links.t.onPlace.add(read);
  links.x.onPlace.add(read);
  read();
}

document.documentElement.classList.add("scripted");
try {
  startPage();
} catch (error) {
  document.documentElement.classList.remove("scripted");  // the pictures as they were printed are there
  throw error;
}
