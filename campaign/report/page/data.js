// SPDX-License-Identifier: Apache-2.0
// The campaign's data, as page_data.h describes them, and what each part of the page asks of them.
const data = JSON.parse(document.getElementById("data").textContent);
const summary = data.summary;
const summaryOf = new Map(summary.metrics.map((metric) => [metric.name, metric]));
const confidence = "95 %";  // of every interval of the summary

// What is shown without being asked for.
const listed = summary.metrics.filter((metric) => metric.listed).map(({name}) => name);
const shownFirst = listed.length ? listed : data.metrics.slice(0, 6);
const runOfRow = new Map(data.runs.map((run) => [run.row, run]));
const statuses = ["passed", "failed", "broke off", "refused", "crashed", "timed out"];

const passed = (run) => run.status === "passed";
const metricOf = (name) => {
  const at = data.metrics.indexOf(name);
  return (run) => run.metrics[at];
};

// A parameter's values: numbers where all of them are, or places on an axis of its different texts.
const parameterOf = (key) => {
  const at = data.keys.indexOf(key);
  const texts = data.runs.map((run) => run.values[at]);
  const numeric = texts.every((text) => text.trim() !== "" && Number.isFinite(Number(text)));
  if (numeric) return {key, numeric, of: (run) => Number(run.values[at])};
  const choices = [...new Set(texts)].sort();
  return {key, numeric, choices, of: (run) => choices.indexOf(run.values[at])};
};
const variesIn = (key) => new Set(data.runs.map((run) => run.values[data.keys.indexOf(key)])).size > 1;

// Where a number lies, by the ends that are known.
const intervalText = (low, high, shown) =>
  (hasNumber(low) && hasNumber(high) ? `${shown(low)} to ${shown(high)}`
    : hasNumber(low) ? `from ${shown(low)}` : hasNumber(high) ? `up to ${shown(high)}` : "too few runs to say");

const ascending = (values) => values.filter(hasNumber).sort((a, b) => a - b);
const quantileOfSorted = (sorted, p) => {
  const at = p * (sorted.length - 1), below = Math.floor(at), above = Math.ceil(at);
  return sorted[below] + (at - below) * (sorted[above] - sorted[below]);
};

// Criteria of the scenario that a run did not keep to; what it did not come to, it did not keep to either.
const missedCriteria = (run) => Object.entries(data.limits).filter(([name, {max, min}]) => {
  const value = data.metrics.includes(name) ? metricOf(name)(run) : null;
  return !hasNumber(value) || value > (max ?? Infinity) || value < (min ?? -Infinity);
}).map(([name]) => name);

const shellWord = (text) => (/^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`);
const replayCommand = (row) => (data.replay ? `${data.replay} ${row}`
  : [data.run, ...data.keys.map((key, i) => `--set ${shellWord(`${key}=${runOfRow.get(row).values[i]}`)}`)].join(" "));
