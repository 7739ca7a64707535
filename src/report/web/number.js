// Numbers for people, written as the still pictures write them (report/plot/axis.cpp), and ticks of logarithmic axes.

const superscripts = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const powerOfTen = (exponent) => "10" + [...String(exponent)].map((c) => (c === "-" ? "⁻" : superscripts[c])).join("");
const withTrueMinus = (text) => text.replace(/^-/, "−");

function readable(value, digits = 5) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1e-3 && size < 1e5)
    return withTrueMinus(String(Number(value.toPrecision(Math.max(digits, Math.floor(Math.log10(size)) + 1)))));
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const short = String(Number(mantissa)), power = powerOfTen(Number(exponent));
  return short === "1" ? power : withTrueMinus(short) + "\u202f×\u202f" + power;
}

/// Units that the scene of the page names, by quantity.
const units = {};
function withUnit(value, quantity, digits) {
  return units[quantity] ? `${readable(value, digits)}\u00a0${units[quantity]}` : readable(value, digits);
}

/// A heading with the unit of a quantity.
const headed = (words, quantity) => (units[quantity] ? `${words} [${units[quantity]}]` : words);

/// Steps between ticks: 1, 2 or 5 times a power of ten.
const tickSteps = Array.from({ length: 600 }, (_, i) => 10 ** (Math.floor(i / 3) - 100) * [1, 2, 5][i % 3]);

/// Labels of ticks a step apart, without the factor 10^exponent that they share.
function linearLabels(values, step, exponent) {
  const factor = 10 ** -exponent, decimals = Math.min(12, Math.max(0, Math.ceil(-Math.log10(step * factor) - 1e-9)));
  return values.map((value) => withTrueMinus((Math.abs(value) < 1e-9 * step ? 0 : value * factor).toFixed(decimals)));
}

/// Decades, and their multiples where at most `most` decades leave room.
function decadeTicks(low, high, most) {
  const first = Math.floor(Math.log10(low) - 1e-9), last = Math.ceil(Math.log10(high) + 1e-9);
  const ticks = [];
  for (let decade = first; decade <= last; ++decade)
    for (let multiple = 1; multiple < 10; ++multiple)
      if (multiple === 1 || last - first <= most) ticks.push(multiple * 10 ** decade);
  return ticks.filter((tick) => tick >= low * (1 - 1e-9) && tick <= high * (1 + 1e-9));
}

function decadeLabels(ticks, low, high, most) {
  const decades = Math.log10(high / low), stride = Math.max(1, Math.ceil(decades / most));
  return ticks.map((tick) => {
    const exponent = Math.round(Math.log10(tick)), multiple = Math.round(tick / 10 ** Math.floor(Math.log10(tick) + 1e-9));
    if (Math.abs(tick / 10 ** exponent - 1) < 1e-6) return exponent % stride === 0 ? powerOfTen(exponent) : "";
    return decades < 1.3 && (multiple === 2 || multiple === 5) ? readable(tick, 2) : "";
  });
}
