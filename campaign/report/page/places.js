// SPDX-License-Identifier: Apache-2.0
// Where runs touched down about the pad's centre, and where recorded ones flew.
const squareScales = (reach, step, names) => Object.fromEntries(["x", "y"].map((which, at) =>
  [which, axis(names[at], {min: -reach, max: reach, ticks: {stepSize: step}})]));

const touchdownPoints = () => {
  const north = metricOf("touchdown_north_m"), east = metricOf("touchdown_east_m");
  return data.runs.filter((run) => hasNumber(north(run)) && hasNumber(east(run)))
      .map((run) => ({x: east(run), y: north(run), run}));
};

const describeTouchdown = () => {
  const points = touchdownPoints();
  const distances = ascending(points.map(({x, y}) => Math.hypot(x, y)));
  const limit = data.limits.touchdown_error_m?.max;
  const p95 = quantileOfSorted(distances, 0.95);
  const farthest = Math.max(...distances.slice(-1), hasNumber(limit) ? limit : 0, 1e-3);
  const step = niceStep(farthest / 4), reach = step * Math.ceil(1.1 * farthest / step);
  const radii = Array.from({length: Math.floor(reach / step)}, (_, at) => ({at: (at + 1) * step}));
  radii.push({at: p95, label: `95 % within ${number(p95, 3)} m`, ink: "accent"});
  if (hasNumber(limit)) radii.push({at: limit, label: `limit ${number(limit)} m`, ink: "bad", dashed: true});
  return {type: "scatter", data: {datasets: runPoints(points)}, options: {
    ...runPointOptions,
    aspectRatio: 1, maintainAspectRatio: false,
    scales: squareScales(reach, step, ["east of the pad’s centre (m)", "north (m)"]),
    plugins: {circles: {radii}, tooltip: {callbacks: {label: ({raw: {x, y, run}}) =>
      [`run ${run.row}: ${run.status}`, `${number(y, 3)} m north, ${number(x, 3)} m east`]}}},
  }};
};

const setUpTouchdown = () => {
  const points = touchdownPoints();
  if (!points.length) return;
  byId("touchdown").hidden = false;
  const without = data.runs.length - points.length;
  const mean = (of) => points.reduce((sum, point) => sum + of(point), 0) / points.length;
  const north = mean(({y}) => y), east = mean(({x}) => x);
  const distances = ascending(points.map(({x, y}) => Math.hypot(x, y)));
  const deviation = (of, about) => Math.sqrt(mean((point) => (of(point) - about) ** 2));
  const row = (what, value) => el("tr", {}, el("td", {}, what), el("td", {class: "number"}, value));
  byId("touchdown-figures").append(
    el("h3", {}, "Of the first touch"),
    el("table", {}, el("tbody", {},
      row("runs that touched down", count(points.length)), row("runs that did not", count(without)),
      row("mean north", `${number(north, 3)} m`), row("mean east", `${number(east, 3)} m`),
      row("deviation north", `${number(deviation(({y}) => y, north), 3)} m`),
      row("deviation east", `${number(deviation(({x}) => x, east), 3)} m`),
      row("half within (CEP)", `${number(quantileOfSorted(distances, 0.5), 3)} m`),
      row("95 % within", `${number(quantileOfSorted(distances, 0.95), 3)} m`),
      row("farthest", `${number(distances[distances.length - 1], 3)} m`))),
    el("p", {class: "note"}, "Dots are touch-downs of runs that passed, crosses of those that did not. A click shows the run. " +
      "Figures here are of these runs; those with intervals are under Distributions."));
  byId("touchdown-chart").setAttribute("aria-label", "Touch-downs north and east of the pad’s centre. " +
    "Left and right go from point to point, Enter shows the run.");
  pickByKeys("touchdown-chart");
  draw("touchdown-chart", describeTouchdown);
};

const trajectoryLines = (of) => data.trajectories.map((each) => {
  const run = runOfRow.get(each.row);
  return {label: `run ${each.row}`, data: each.t_s.map((_, at) => ({...of(each, at), run})), showLine: true,
          borderColor: color(passed(run) ? "point" : "bad"), borderWidth: passed(run) ? 1.3 : 2,
          pointRadius: 0, pointHitRadius: 5, pointHoverRadius: 5, order: passed(run) ? 2 : 1};
});

const describeTrajectories = (of, scales) => ({type: "scatter", data: {datasets: trajectoryLines(of)}, options: {
  ...runPointOptions, scales,
  plugins: {legend: {display: false}, tooltip: {callbacks: {label: ({raw: {run}}) =>
    `run ${run.row}: ${run.status}${run.outcome ? `, ${run.outcome}` : ""}`}}},
}});

const setUpTrajectories = () => {
  if (!data.trajectories.length) return;
  byId("trajectories").hidden = false;
  const shown = data.trajectories.length, recorded = data.runs.filter((run) => run.recording).length;
  byId("trajectory-note").textContent = `True position of ${shown < recorded ? `${shown} of ` : ""}${plural(recorded, "recorded run")}; ` +
    "thick lines did not pass. A click shows the run.";
  // North and east on one scale.
  const all = data.trajectories;
  const [norths, easts] = ["north_m", "east_m"].map((name) => ascending(all.flatMap((each) => each[name])));
  const middle = [easts, norths].map((values) => (values[0] + values[values.length - 1]) / 2);
  const span = Math.max(0.1, ...[easts, norths].map((values) => values[values.length - 1] - values[0]));
  const step = niceStep(span / 6), steps = Math.ceil(span / step) + 1;
  const about = (centre) => {
    const first = Math.round(centre / step - steps / 2);
    return {min: first * step, max: (first + steps) * step, ticks: {stepSize: step}};
  };
  const top = {x: axis("east (m)", about(middle[0])), y: axis("north (m)", about(middle[1]))};
  draw("trajectory-top", () => describeTrajectories((t, at) => ({x: t.east_m[at], y: t.north_m[at]}), top));
  draw("trajectory-height", () => describeTrajectories((t, at) => ({x: t.t_s[at], y: t.height_m[at]}),
    {x: axis("time (s)"), y: axis("height (m)")}));
  for (const name of ["trajectory-top", "trajectory-height"]) {
    byId(name).setAttribute("aria-label", "Trajectories of recorded runs");
    pickByKeys(name);
  }
};
