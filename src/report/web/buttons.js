// Elements of the page, and buttons with drawn signs: fonts differ in those they have.

const element = (tag, attributes = {}, ...children) => {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node[name] = value;
  node.append(...children);
  return node;
};

/// The same of a picture.
function svgElement(name, attributes = {}, ...children) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  setAttributes(node, attributes);
  node.append(...children);
  return node;
}
function setAttributes(node, attributes) {
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
}

/// A table: names of the columns, and for each row its cells and what a click on it does. `kinds` are classes of the cells.
function tableOf(heads, rows, kinds = []) {
  const cells = (tag, texts) => texts.map((text, i) => element(tag, { textContent: text, className: kinds[i] ?? "", ...(tag === "th" && { scope: "col" }) }));
  const body = element("tbody", {}, ...rows.map(({ texts, action }) => {
    const row = element("tr", {}, ...cells("td", texts));
    row.addEventListener("click", action);
    return row;
  }));
  return element("table", {}, element("thead", {}, element("tr", {}, ...cells("th", heads))), body);
}

/// Paths in a square of 16.
const icons = {
  play: "M4 2.5v11l9.5-5.5z",
  pause: "M4 2.5h3v11h-3zM9 2.5h3v11h-3z",
  previous: "M3 3h2v10h-2zM13 3v10l-7.5-5z",
  next: "M11 3h2v10h-2zM3 3v10l7.5-5z",
  out: "M3 7h10v2h-10z",
  in: "M3 7h4v-4h2v4h4v2h-4v4h-2v-4h-4z",
  left: "M10.5 3v10l-6.5-5z",
  right: "M5.5 3v10l6.5-5z",
  theme: "M8 1.5a6.5 6.5 0 1 0 0 13a6.5 6.5 0 1 0 0-13zM8 3v10a5 5 0 0 1 0-10z",
};

function icon(name) {
  return svgElement("svg", { viewBox: "0 0 16 16", "aria-hidden": "true", class: "icon" },
    svgElement("path", { d: icons[name], "fill-rule": "evenodd" }));
}

function iconButton(name, label, action) {
  const button = element("button", { type: "button", ariaLabel: label, title: label }, icon(name));
  button.addEventListener("click", action);
  return button;
}

function toggleTheme() {
  const { dataset } = document.documentElement, dark = dataset.theme ? dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  dataset.theme = dark ? "light" : "dark";
}

const themeButton = () => iconButton("theme", "Light or dark", toggleTheme);

/// Buttons that zoom shared axes, show the whole again, and turn light to dark.
function viewButtons(links, showAll) {
  const reset = element("button", { type: "button", textContent: "Reset", title: "Show the whole of every picture" });
  reset.addEventListener("click", showAll);
  const zoom = links.length === 0 ? [] : [
    iconButton("out", "Zoom out (−)", () => links.forEach((link) => link.zoom(2, link.place))),
    iconButton("in", "Zoom in (+)", () => links.forEach((link) => link.zoom(0.5, link.place))),
    iconButton("left", "Move the view to the left", () => links.forEach((link) => link.pan(-0.25))),
    iconButton("right", "Move the view to the right", () => links.forEach((link) => link.pan(0.25)))];
  return [...zoom, reset, themeButton()];
}
