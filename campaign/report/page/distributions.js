// SPDX-License-Identifier: Apache-2.0
// Each metric as a histogram or as the share of runs up to a value, with its quantiles.
const limitLines = (name) => ["max", "min"].filter((end) => hasNumber(data.limits[name]?.[end]))
    .map((end) => ({at: data.limits[name][end], label: "limit", dashed: true}));
const quantileLines = (name) => (summaryOf.get(name)?.quantiles ?? [])
    .map(({q, value, low, high}) => ({at: value, low, high, label: `${number(100 * q)} %`}));

// What lies so far out that the rest would be squeezed is left out of the picture, and said.
const shownRange = (sorted) => {
  const [low, median, high] = [0.005, 0.5, 0.995].map((p) => quantileOfSorted(sorted, p));
  const least = sorted[0], most = sorted[sorted.length - 1];
  return [least < median - 3 * (median - low) ? low - (median - low) : least,
          most > median + 3 * (high - median) ? high + (high - median) : most];
};

const niceStep = (rough) => {
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 2.5, 5, 10].find((step) => step * power >= rough) ?? 10);
};

const histogramOf = (name) => {
  const of = metricOf(name);
  const runs = data.runs.filter((run) => hasNumber(of(run)));
  const sorted = ascending(runs.map(of));
  let [from, to] = shownRange(sorted);
  if (!(to > from)) [from, to] = [from - 0.5, to + 0.5];
  const step = niceStep((to - from) / Math.min(40, Math.max(8, Math.sqrt(sorted.length) * 1.2)));
  const first = Math.floor(from / step), bins = Math.max(1, Math.floor(to / step) - first + 1);
  const counts = {passed: Array(bins).fill(0), others: Array(bins).fill(0)};
  let outside = 0;
  for (const run of runs) {
    const at = Math.floor(of(run) / step) - first;
    if (at < 0 || at >= bins) ++outside;
    else ++counts[passed(run) ? "passed" : "others"][at];
  }
  const points = (each) => each.map((y, at) => ({x: (first + at + 0.5) * step, y}));
  return {step, from: first * step, to: (first + bins) * step, outside, most: sorted[sorted.length - 1],
          least: sorted[0], passed: points(counts.passed), others: points(counts.others)};
};

const plainOptions = (name, yTitle) => ({
  layout: {padding: {top: 16}},
  plugins: {legend: {display: false}, marks: {lines: [...quantileLines(name), ...limitLines(name)]}},
  scales: {x: axis(labelOf(name)), y: axis(yTitle, {beginAtZero: true})},
});

const describeHistogram = (name) => {
  const h = histogramOf(name);
  const options = plainOptions(name, "runs");
  Object.assign(options.scales.x, {min: h.from, max: h.to, stacked: true, offset: false});
  Object.assign(options.scales.y, {stacked: true, ticks: {precision: 0}});
  options.interaction = {mode: "x", intersect: false};
  options.plugins.tooltip = {callbacks: {
    title: (items) => (items.length
      ? `${number(items[0].parsed.x - h.step / 2)} to ${withUnit(items[0].parsed.x + h.step / 2, name)}` : ""),
    label: (item) => `${item.dataset.label}: ${item.parsed.y}`,
  }};
  const bars = {barPercentage: 1, categoryPercentage: 1, borderWidth: 0.5, borderColor: color("card")};
  return {type: "bar", options, data: {datasets: [
    {label: "passed", data: h.passed, backgroundColor: color("accent"), ...bars},
    {label: "did not pass", data: h.others, backgroundColor: color("bad"), ...bars}]}};
};

const describeEcdf = (name) => {
  const sorted = ascending(data.runs.map(metricOf(name)));
  const [from, to] = shownRange(sorted);
  const every = Math.max(1, Math.floor(sorted.length / 500));
  const points = sorted.map((x, at) => ({x, y: (at + 1) / sorted.length}))
      .filter((_, at) => at % every === 0 || at === sorted.length - 1);
  const options = plainOptions(name, "share of runs");
  Object.assign(options.scales.x, {min: from, max: to > from ? to : from + 1});
  Object.assign(options.scales.y, {max: 1});
  options.interaction = {mode: "index", axis: "x", intersect: false};
  options.plugins.tooltip = {callbacks: {
    title: () => "",
    label: ({parsed}) => `${percent(parsed.y)} of runs up to ${withUnit(parsed.x, name)}`,
  }};
  return {type: "line", options, data: {datasets: [
    {label: "runs", data: points, stepped: "before", pointRadius: 0, borderWidth: 2, borderColor: color("accent")}]}};
};

const distributionNote = (name) => {
  const of = metricOf(name);
  const without = data.runs.filter((run) => !hasNumber(of(run))).length;
  const notes = [];
  const h = histogramOf(name);
  if (h.outside) notes.push(`${plural(h.outside, "run")} beyond the picture: ${number(h.least)} to ${withUnit(h.most, name)} in all`);
  if (without) notes.push(`${plural(without, "run")} without it`);
  return notes.join("; ");
};

const quantileTable = (name) => {
  const s = summaryOf.get(name);
  const row = (what, {value, low, high}) => el("tr", {}, el("td", {}, what), el("td", {class: "number"}, number(value, 3)),
    el("td", {class: "number"}, intervalText(low, high, (value) => number(value, 3))));
  return el("table", {class: "quantiles"},
    el("thead", {}, el("tr", {}, el("th", {}, `of ${plural(s.runs, "run")}`),
      el("th", {class: "number"}, unitOf(name)[1] || "value"), el("th", {class: "number"}, `${confidence} interval`))),
    el("tbody", {}, row("mean", s.mean), s.quantiles.map((each) => row(`${number(100 * each.q)} % quantile`, each))));
};

const distributionCard = (name) => {
  const canvas = `distribution-${name}`;
  return el("article", {class: "card"},
    el("h3", {title: name}, plainName(name)),
    el("div", {class: "chart"}, el("canvas", {id: canvas, role: "img", "aria-label": `Distribution of ${name}`})),
    el("p", {class: "note"}, distributionNote(name)),
    quantileTable(name));
};

const distributionStyle = () => document.querySelector("input[name=distribution]:checked").value;
const drawDistribution = (name) =>
  draw(`distribution-${name}`, () => (distributionStyle() === "ecdf" ? describeEcdf(name) : describeHistogram(name)));

const setUpDistributions = () => {
  const names = data.metrics;
  const first = names.filter((name) => shownFirst.includes(name));
  const rest = names.filter((name) => !first.includes(name));
  let open = false;
  byId("distributions-first").append(...first.map(distributionCard));
  first.forEach(drawDistribution);
  const more = byId("distributions-more");
  more.hidden = rest.length === 0;
  more.querySelector("summary").textContent = `${plural(rest.length, "more metric")}`;
  more.addEventListener("toggle", () => {
    if (open || !more.open) return;
    open = true;  // what nobody looks at is not drawn
    byId("distributions-rest").append(...rest.map(distributionCard));
    rest.forEach(drawDistribution);
  });
  for (const radio of document.querySelectorAll("input[name=distribution]"))
    radio.addEventListener("change", () => [...first, ...(open ? rest : [])].forEach(drawDistribution));
  byId("distributions").hidden = names.length === 0;
};
