// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them.
const hasNumber = (value) => typeof value === "number" && Number.isFinite(value);

// Names carry their units at their end.
const units = [
  ["_m_s2", "m/s²"], ["_deg_s", "°/s"], ["_rad_s", "rad/s"], ["_m_s", "m/s"], ["_per_min", "1/min"],
  ["_per_s", "1/s"], ["_deg", "°"], ["_rad", "rad"], ["_hz", "Hz"], ["_px", "px"], ["_mm", "mm"],
  ["_ms", "ms"], ["_kg", "kg"], ["_grey", "grey levels"], ["_n", "N"], ["_m", "m"], ["_s", "s"],
];
const unitOf = (name) => units.find(([ending]) => name.endsWith(ending)) ?? ["", ""];
const plainName = (name) => name.slice(0, name.length - unitOf(name)[0].length).replaceAll("_", " ");
const labelOf = (name) => (unitOf(name)[1] ? `${plainName(name)} (${unitOf(name)[1]})` : plainName(name));

const minus = (text) => text.replace(/^-/, "−");
const number = (value, digits = 4) => {
  if (!hasNumber(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return minus(value.toExponential(2));
  return minus(String(Number(value.toPrecision(digits))));
};
const withUnit = (value, name) => {
  const unit = unitOf(name)[1];
  return hasNumber(value) ? number(value) + (unit && unit !== "°" ? " " : "") + unit : "–";
};
const count = (value) => value.toLocaleString("en-GB");
const percent = (share, digits = 1) => `${(100 * share).toFixed(digits)} %`;
const plural = (n, one, many = `${one}s`) => `${count(n)} ${n === 1 ? one : many}`;
