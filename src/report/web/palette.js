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
