// Colours are variables of the page, so that they follow light and dark; a canvas needs their values.

const root = document.documentElement;
const onTheme = new Set();
const known = new Map();

/// The value of "var(--name)"; any other colour is itself.
function colour(css) {
  const variable = /^var\((--[\w-]+)\)$/.exec(css);
  if (!variable) return css;
  if (!known.has(css)) known.set(css, getComputedStyle(root).getPropertyValue(variable[1]).trim());
  return known.get(css);
}

/// Red, green and blue at a part of a colour scale, whose anchors "#rrggbb" are at equal distances; linear in between.
const channels = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16));
function mixed(anchors, part) {
  const scaled = part * (anchors.length - 1), at = Math.min(Math.floor(scaled), anchors.length - 2);
  const to = channels(anchors[at + 1]);
  return channels(anchors[at]).map((from, k) => Math.round(from + (scaled - at) * (to[k] - from)));
}

const systemIsDark = matchMedia("(prefers-color-scheme: dark)");
const isDark = () => (root.dataset.theme ? root.dataset.theme === "dark" : systemIsDark.matches);

function themeChanged() {
  known.clear();
  for (const listener of onTheme) listener();
}
systemIsDark.addEventListener("change", themeChanged);

function toggleTheme() {
  root.dataset.theme = isDark() ? "light" : "dark";
  themeChanged();
}
