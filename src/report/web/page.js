// Puts the pictures of the page together: reads its data and draws each picture anew in place of the still one.

const charts = new Map();
const resetAll = () => charts.forEach((chart) => chart.reset());

function startPage() {
  const { figures, sweep, field: fieldData, stress: stressData, magnification, events: eventData, supports } =
    JSON.parse(document.getElementById("data").textContent);
  if (sweep) {
    window.viscobar = { sweep: new SweepPage(sweep, document.getElementById("sweep")) };
    return;
  }
  const links = { t: new Link(), x: new Link(), epsilon: new Link(true) };
  const reference = { links, charts, figures };
  root.style.setProperty("--touching", fieldData?.colours.touching ?? "#e0218a");
  const shownTime = () => links.t.place;

  const special = {};
  if (fieldData) {
    const field = new Field(fieldData), colours = new FieldColours(fieldData.colours, field);
    const stress = new Field(stressData), ofStress = new FieldColours(stressData.colours, stress);
    const bar = new BarPicture(field, colours, supports, reactionsOf(figures));
    const axial = new AxialPicture(field, stress, ofStress, supports, magnification);
    const map = new FieldMap(field, colours), stressMap = new FieldMap(stress, ofStress);
    figures.bar.layers.unshift({ kind: "envelope" });
    Object.assign(special, {
      map: (chart, context) => map.draw(chart, context),
      "stress-map": (chart, context) => stressMap.draw(chart, context),
      envelope: (chart, context) => bar.drawEnvelope(chart, context),
      bar: (chart, context) => bar.draw(chart, context, shownTime() ?? field.t[0]),
      axial: (chart, context) => axial.draw(chart, context, shownTime() ?? field.t[0]),
    });
    Object.assign(reference, { field, colours, bar, stress, ofStress, axial });
    links.t.rest = field.t[0];
  }

  for (const panel of document.querySelectorAll(".panel")) {
    const name = panel.dataset.picture, figure = figures[name];
    const overTime = figure.x.link === "t";
    const host = element("div", { className: "chart", tabIndex: 0, role: "group",
      ariaLabel: figure.title + (fieldData || overTime ? ". Arrow keys move in time" : ". Arrow keys read points") });
    const live = element("div", { className: "live" }, host);
    panel.append(live);
    const chart = new Chart(host, name, figure, links, { special, dragY: Boolean(figure.y.log) || name === "displacement" || name === "stress" });
    charts.set(name, chart);
    live.prepend(new Legend(chart, { values: overTime }).node);
    if (!overTime && name !== "bar" && name !== "axial") new PointReader(chart);
  }
  if (fieldData) startRun(reference, eventData);
  else startStudy(links);
  window.viscobar = reference;
}

/// A run: slider, events, the bar that follows them.
function startRun(reference, eventData) {
  const { links, field, colours, stress, ofStress } = reference, events = new Events(eventData);
  const player = new Player(links.t, field.t, events, resetAll);
  Object.assign(reference, { events, player });
  document.querySelector("figure").before(player.node);

  const belongs = { "left-end": (e) => Events.side(e) !== "right", "right-end": (e) => Events.side(e) !== "left" };
  for (const [name, chart] of charts) {
    chart.host.addEventListener("keydown", (event) => player.key(event));
    if (chart.figure.x.link !== "t") continue;
    const own = belongs[name] ?? (() => true);
    chart.overlays.push(events.marksOn(own));
    chart.plot.over.addEventListener("click", (event) => {
      const { left, width } = chart.plot.over.getBoundingClientRect(), [from, to] = chart.shown("x");
      const time = chart.plot.posToVal(event.clientX - left, "x"), mark = events.nearest(time, (6 * (to - from)) / width, own);
      player.stop();
      if (mark) player.jump(mark);
      else player.go(time);
    });
    events.onChosen.add(() => chart.redraw());
  }
  const bar = charts.get("bar"), axial = charts.get("axial");
  links.t.onPlace.add(() => { bar.redraw(); axial.redraw(); });
  addReadout(addColourScale(charts.get("displacement"), "u", colours), "u", field, links);
  addReadout(addColourScale(charts.get("stress"), "s", ofStress), "s", stress, links);
  addColourScale(axial, "s", ofStress);
  addReadout(bar.host.previousElementSibling, "u", field, links);
  const section = document.getElementById("events");
  if (section) events.table(section, (event) => player.jump(event));
  document.querySelector("footer").before(element("p", { className: "live note", textContent:
    "Keys, on the slider or a picture: arrows and page keys move in time, Home and End go to its ends, space plays, N and P go " +
    "to contact changes, + − 0 zoom. Drag to zoom, shift and drag to move the view, double click to see it all. Bar and maps are " +
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
  const { x } = chart.link, [low, high] = chart.shown("x");
  const move = (part) => x.stand(Math.min(high, Math.max(low, (x.rest ?? low) + part * (high - low))));
  const overTime = chart.figure.x.link === "t";
  const action = {
    "+": () => x.zoom(0.5, x.place), "-": () => x.zoom(2, x.place), 0: resetAll,
    ...(overTime ? { ArrowRight: () => move(0.01), ArrowLeft: () => move(-0.01), Home: () => x.stand(low), End: () => x.stand(high) } : {}),
  }[event.key];
  if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
  event.preventDefault();
  action();
}

function reactionsOf(figures) {
  const find = (label) => {
    const line = figures.reactions?.layers.find((layer) => layer.kind === "line" && layer.label === label);
    return line ? new Curve(line) : null;
  };
  return { left: find("left end"), right: find("right end") };
}

/// The scale of a map.
function addColourScale(chart, name, colours) {
  const shades = Array.from({ length: 17 }, (_, i) => `rgb(${colours.palette[Math.round((i * 254) / 16)]})`);
  const ramp = element("span", { className: "ramp", ariaHidden: "true" });
  ramp.style.background = `linear-gradient(to right, ${shades.join(", ")})`;
  const scale = element("div", { className: "legend scale" }, element("span", { textContent: `${name} from ${readable(colours.low, 3)}` }), ramp,
    element("span", { textContent: `to ${readable(colours.high, 3)}` }));
  if (colours.touched) {
    const box = element("span", { className: "swatch bars" });
    box.style.setProperty("--colour", colours.touching);
    scale.append(box, element("span", { textContent: "in contact" }));
  }
  chart.host.before(scale);
  return scale;
}

/// The value of a field where the pointer is.
function addReadout(node, name, field, links) {
  const value = element("span", { className: "value" }), [begin, end] = links.x.bounds;
  node.append(value);
  const read = () => {
    const t = links.t.place, x = links.x.pointed;
    value.textContent = x === null || x < begin || x > end ? "\u00a0" :
      `${name}(${readable(x, 4)}, ${readable(t, 4)}) = ${readable(field.value(t, x), 4)}`;
  };
  links.t.onPlace.add(read);
  links.x.onPlace.add(read);
  read();
}

if (document.getElementById("data")) {
  root.classList.add("scripted");
  try {
    startPage();
  } catch (error) {
    root.classList.remove("scripted");  // the still pictures are there
    throw error;
  }
}
