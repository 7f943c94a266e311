// SPDX-License-Identifier: Apache-2.0
// What all charts share: colours of the page, intervals, points that can be picked by mouse and keys.
const charts = {};  // by the name of their canvas
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Intervals of bars: dataset.intervals holds [low, high] for each.
const intervalBars = {
  id: "intervalBars",
  afterDatasetsDraw(chart) {
    const {ctx} = chart;
    const across = chart.options.indexAxis === "y";
    const scale = chart.scales[across ? "x" : "y"];
    chart.data.datasets.forEach((dataset, at) => {
      if (!dataset.intervals || !chart.isDatasetVisible(at)) return;
      ctx.save();
      ctx.strokeStyle = color("ink");
      ctx.lineWidth = 1.5;
      chart.getDatasetMeta(at).data.forEach((bar, i) => {
        if (!dataset.intervals[i]) return;
        const [low, high] = dataset.intervals[i].map((value) => scale.getPixelForValue(value));
        ctx.beginPath();
        for (const [x0, y0, x1, y1] of [[low, 0, high, 0], [low, -4, low, 4], [high, -4, high, 4]]) {
          if (across) ctx.moveTo(x0, bar.y + y0), ctx.lineTo(x1, bar.y + y1);
          else ctx.moveTo(bar.x + y0, x0), ctx.lineTo(bar.x + y1, x1);
        }
        ctx.stroke();
      });
      ctx.restore();
    });
  },
};

// Upright lines at values of the x axis with the bands of their intervals: options.plugins.marks.lines of
// {at, low, high, label, dashed}.
const marks = {
  id: "marks",
  beforeDatasetsDraw(chart, _, options) { marks.draw(chart, options, true); },
  afterDatasetsDraw(chart, _, options) { marks.draw(chart, options, false); },
  draw(chart, options, bands) {
    const {ctx, chartArea: area, scales: {x}} = chart;
    let labelEnd = -Infinity;
    ctx.save();
    for (const line of options.lines ?? []) {
      const at = x.getPixelForValue(line.at);
      if (at < area.left - 1 || at > area.right + 1) continue;
      if (bands) {
        if (!hasNumber(line.low) || !hasNumber(line.high)) continue;
        const left = Math.max(area.left, x.getPixelForValue(line.low));
        const right = Math.min(area.right, x.getPixelForValue(line.high));
        ctx.fillStyle = color("band");
        ctx.fillRect(left, area.top, right - left, area.bottom - area.top);
        continue;
      }
      ctx.strokeStyle = color(line.dashed ? "bad" : "ink");
      ctx.setLineDash(line.dashed ? [5, 4] : []);
      ctx.lineWidth = line.dashed ? 1.6 : 1.2;
      ctx.beginPath();
      ctx.moveTo(at, area.top - 2);
      ctx.lineTo(at, area.bottom);
      ctx.stroke();
      ctx.font = "11px system-ui, sans-serif";
      ctx.fillStyle = color(line.dashed ? "bad" : "soft");
      ctx.textAlign = "center";
      const half = ctx.measureText(line.label).width / 2;
      const middle = Math.min(at, chart.width - half - 1);
      if (middle - half < labelEnd + 3) continue;  // lines stand closer than their names
      labelEnd = middle + half;
      ctx.fillText(line.label, middle, area.top - 5);
    }
    ctx.restore();
  },
};

// Text on a chart, legible over whatever lies under it.
const writeOver = (ctx, text, x, y, ink) => {
  ctx.font = "600 11px system-ui, sans-serif";
  ctx.textAlign = "center";
  ctx.setLineDash([]);
  ctx.lineWidth = 4;
  ctx.lineJoin = "round";
  ctx.strokeStyle = color("card");
  ctx.strokeText(text, x, y);
  ctx.fillStyle = color(ink);
  ctx.fillText(text, x, y);
};

// Circles around the origin: options.plugins.circles.radii of {at, label, ink, dashed}; those without a label
// are thin.
const circles = {
  id: "circles",
  beforeDatasetsDraw(chart, _, options) { circles.draw(chart, options, false); },
  afterDatasetsDraw(chart, _, options) { circles.draw(chart, options, true); },
  draw(chart, options, named) {
    const {ctx, scales: {x, y}, chartArea: area} = chart;
    if (!options.radii) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(area.left, area.top, area.width, area.height);
    ctx.clip();
    const at = [x.getPixelForValue(0), y.getPixelForValue(0)];
    ctx.strokeStyle = color("soft");
    ctx.beginPath();
    ctx.moveTo(at[0] - 7, at[1]), ctx.lineTo(at[0] + 7, at[1]);
    ctx.moveTo(at[0], at[1] - 7), ctx.lineTo(at[0], at[1] + 7);
    ctx.stroke();
    for (const circle of options.radii.filter(({label}) => Boolean(label) === named)) {
      const across = x.getPixelForValue(circle.at) - at[0], up = at[1] - y.getPixelForValue(circle.at);
      ctx.strokeStyle = color(circle.ink ?? "line");
      ctx.lineWidth = named ? 2 : 1;
      ctx.setLineDash(circle.dashed ? [6, 4] : []);
      ctx.beginPath();
      ctx.ellipse(...at, across, up, 0, 0, 2 * Math.PI);
      ctx.stroke();
      if (named) writeOver(ctx, circle.label, at[0], at[1] + up + 14, circle.ink);
    }
    ctx.restore();
  },
};

Chart.register(intervalBars, marks, circles);

const themeDefaults = () => {
  Chart.defaults.color = color("soft");
  Chart.defaults.borderColor = color("line");
  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
};
Chart.defaults.animation = false;
Chart.defaults.maintainAspectRatio = false;
Chart.defaults.interaction = {mode: "nearest", intersect: true};
Chart.defaults.plugins.legend.labels.usePointStyle = true;
Chart.defaults.plugins.legend.labels.boxHeight = 7;
Chart.defaults.plugins.legend.align = "start";
Chart.defaults.plugins.tooltip.displayColors = false;

// Each chart is described by a function, so that it can be drawn again in other colours.
const described = new Map();
const draw = (name, describe) => {
  described.set(name, describe);
  charts[name]?.destroy();
  themeDefaults();
  charts[name] = new Chart(byId(name), describe());
  return charts[name];
};
const drawAllAgain = () => described.forEach((describe, name) => draw(name, describe));

// Chart.js writes a step of 0.25 with one digit: 0.3, 0.5, 0.8.
const tickText = (value) => number(value, 10);
const axis = (title, more = {}) => ({
  type: "linear", title: {display: Boolean(title), text: title}, grid: {color: color("line")}, ...more,
  ticks: {...(more.type === "logarithmic" ? {} : {callback: tickText}), ...more.ticks},
});

// Two datasets of points that stand for runs, those that passed and the others; points are {x, y, run}.
const runPoints = (points, many = points.length) => [
  {label: "did not pass", data: points.filter(({run}) => !passed(run)), pointStyle: "crossRot", radius: 6,
   hoverRadius: 9, hitRadius: 5, borderWidth: 2.2, borderColor: color("bad"), backgroundColor: color("bad"), order: 1},
  {label: "passed", data: points.filter(({run}) => passed(run)), pointStyle: "circle",
   radius: many > 2000 ? 1.8 : 2.8, hoverRadius: 6, hitRadius: 4, borderWidth: 0, hoverBorderWidth: 2,
   hoverBorderColor: color("ink"), backgroundColor: color("point"), hoverBackgroundColor: color("accent"), order: 2},
];

// A click on a point shows its run; with the keys, left and right go from point to point, Enter shows.
const runPointOptions = {
  onClick(_, elements, chart) {
    const run = elements.length && chart.data.datasets[elements[0].datasetIndex].data[elements[0].index].run;
    if (run) showRun(run.row);
  },
  onHover(event, elements, chart) {
    const run = elements.length && chart.data.datasets[elements[0].datasetIndex].data[elements[0].index].run;
    event.native.target.style.cursor = run ? "pointer" : "default";
  },
};
const pickByKeys = (name) => {
  const canvas = byId(name);
  let at = -1;
  canvas.addEventListener("keydown", (event) => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key] ?? 0;
    if (!step && event.key !== "Enter") return;
    const chart = charts[name];
    const points = chart.data.datasets
        .flatMap((dataset, datasetIndex) =>
          dataset.data.map((point, index) => ({point, datasetIndex, index})))
        .filter(({point, datasetIndex}) => point.run && chart.isDatasetVisible(datasetIndex))
        .sort((a, b) => a.point.x - b.point.x);
    if (!points.length) return;
    event.preventDefault();
    if (step) at = Math.max(0, Math.min(points.length - 1, at + step));
    const chosen = points[Math.max(0, Math.min(at, points.length - 1))];
    if (!step) return showRun(chosen.point.run.row);
    const element = chart.getDatasetMeta(chosen.datasetIndex).data[chosen.index];
    chart.setActiveElements([chosen]);
    chart.tooltip.setActiveElements([chosen], {x: element.x, y: element.y});
    chart.update();
    announce(`run ${chosen.point.run.row}, ${chosen.point.run.status}`);
  });
};
