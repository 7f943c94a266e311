// SPDX-License-Identifier: Apache-2.0
// Any parameter against any metric, a point for each run.
const scattered = () => {
  const parameter = parameterOf(byId("scatter-x").value);
  const name = byId("scatter-y").value;
  return {parameter, name, of: metricOf(name), logarithmic: byId("scatter-log").checked};
};

// Places on an axis of choices, spread a little, always alike, so that points do not hide each other.
const spread = (run) => (((run.row * 2654435761) % 4294967296) / 4294967296 - 0.5) * 0.5;

const medianLine = (points) => {
  const sorted = [...points].sort((a, b) => a.x - b.x), parts = Math.min(12, Math.floor(sorted.length / 15));
  if (parts < 3) return [];
  return Array.from({length: parts}, (_, at) => {
    const part = sorted.slice(Math.floor(at * sorted.length / parts), Math.floor((at + 1) * sorted.length / parts));
    return {x: quantileOfSorted(ascending(part.map(({x}) => x)), 0.5), y: quantileOfSorted(ascending(part.map(({y}) => y)), 0.5)};
  });
};

const describeScatter = () => {
  const {parameter, name, of, logarithmic} = scattered();
  const x = (run) => parameter.of(run) + (parameter.numeric ? 0 : spread(run));
  const drawable = (run) => hasNumber(of(run)) && (!logarithmic || of(run) > 0);
  const points = data.runs.filter(drawable).map((run) => ({x: x(run), y: of(run), run}));
  const xs = ascending(data.runs.map(parameter.of));
  const logX = parameter.numeric && xs[0] > 0 && xs[xs.length - 1] / xs[0] > 50;
  const datasets = runPoints(points);
  const median = parameter.numeric ? medianLine(points) : [];
  if (median.length)
    datasets.push({type: "line", label: "median of neighbours", data: median, pointRadius: 0, pointHitRadius: 0,
                   pointStyle: "line", borderWidth: 2.5, borderColor: color("ink"), order: 0});
  // Runs without the metric stand at the upper edge, for they are often the ones to look at.
  const without = data.runs.filter((run) => !drawable(run));
  const ys = ascending(points.map(({y}) => y));
  if (without.length && ys.length) {
    const least = ys[0], most = ys[ys.length - 1];
    const edge = logarithmic ? most * (most / least) ** 0.08 : most + 0.08 * (most - least || 1);
    datasets.push({label: `without ${name}`, data: without.map((run) => ({x: x(run), y: edge, run, without: true})),
                   pointStyle: "triangle", rotation: 180, radius: 5, hoverRadius: 8, borderWidth: 1.5,
                   borderColor: color("bad"), backgroundColor: "transparent", order: 1});
  }
  const choices = parameter.numeric ? {} : {
    min: -0.6, max: parameter.choices.length - 0.4,
    ticks: {stepSize: 1, autoSkip: false, callback: (value) => parameter.choices[value] ?? ""},
  };
  return {type: "scatter", data: {datasets}, options: {
    ...runPointOptions,
    scales: {x: axis(parameter.numeric ? labelOf(parameter.key) : parameter.key, {...choices, ...(logX ? {type: "logarithmic"} : {})}),
             y: axis(labelOf(name), logarithmic ? {type: "logarithmic"} : {})},
    plugins: {tooltip: {filter: ({raw}) => raw.run, callbacks: {label: ({raw: {run}}) => [
      `run ${run.row}: ${run.status}`, `${parameter.key} ${run.values[data.keys.indexOf(parameter.key)]}`,
      `${name} ${withUnit(of(run), name)}`]}}},
  }};
};

const drawScatter = () => {
  draw("scatter-chart", describeScatter);
  const {parameter, name, of, logarithmic} = scattered();
  byId("scatter-chart").setAttribute("aria-label", `${name} against ${parameter.key}, a point for each run. ` +
    "Left and right go from point to point, Enter shows the run.");
  const without = data.runs.filter((run) => !hasNumber(of(run))).length;
  const below = logarithmic ? data.runs.filter((run) => hasNumber(of(run)) && of(run) <= 0).length : 0;
  byId("scatter-note").textContent = "A click on a point shows its run." +
    (without ? ` ${plural(without, "run")} without ${name}, at the upper edge.` : "") +
    (below ? ` ${plural(below, "run")} at or below zero, at the upper edge too: there is no logarithm.` : "");
};

const setUpScatter = () => {
  const keys = data.keys.filter(variesIn);
  if (!keys.length || !data.metrics.length) return void (byId("scatter").hidden = true);
  fillSelect(byId("scatter-x"), keys, keys.find((key) => key !== "seed"));
  fillSelect(byId("scatter-y"), data.metrics, data.metrics[0]);
  for (const id of ["scatter-x", "scatter-y", "scatter-log"]) byId(id).addEventListener("change", drawScatter);
  pickByKeys("scatter-chart");
  drawScatter();
};
