// SPDX-License-Identifier: Apache-2.0
// Plots over time. What moves with the time, the cursor and the numbers beside the names, lies over them: a plot is
// drawn once, and not again while the time goes on.
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const plots = new Map();  // by the key of their quantity

Chart.defaults.animation = false;
Chart.defaults.maintainAspectRatio = false;
Chart.defaults.plugins.legend.display = false;
Chart.defaults.plugins.tooltip.enabled = false;

const styles = {
  truth: {borderWidth: 1.8}, estimate: {borderWidth: 1.6, borderDash: [6, 4]},
  own: {borderWidth: 1.4, borderDash: [2, 3], ink: "estimate"}, setpoint: {borderWidth: 1.4},
  fix: {showLine: false, dotted: true}, target: {borderWidth: 1.4, borderDash: [8, 3, 2, 3], ink: "soft"},
  second: {borderWidth: 1.8}, plain: {borderWidth: 1.6, ink: "accent"},
};
const inkOf = (kind) => color(styles[kind].ink ?? kind);
// Later ones lie over those before.
const drawnLast = ["target", "truth", "plain", "second", "setpoint", "own", "estimate", "fix"];

const leftOfPlot = 58, rightOfPlot = 18;  // pixels, of every plot: the same instant lies below itself
const followed_s = 60;                    // of a flight that is still flown, so much is in view

// The turns of an angle that leave no leap, near to the first series of its plot.
const withoutLeaps = (value, near) => (near === null || value === null ? value : value - 360 * Math.round((value - near) / 360));

class Plot {
  constructor(quantity) {
    this.quantity = quantity;
    this.element = el("article", {class: "plot", "data-quantity": quantity.key});
    this.build();
  }

  build() {
    this.chart?.destroy();
    this.chart = null;
    const {quantity} = this;
    const name = quantity.unit ? `${quantity.title} (${quantity.unit})` : quantity.title;
    this.series = allSeries(quantity).map((series) => ({...series, points: [], last: null, hidden: this.isHidden(series)}));
    this.canvas = el("canvas", {role: "img", "aria-label": `${name} over time: ${this.series.map(({label}) => label).join(", ")}`});
    this.cursor = el("div", {class: "cursor"});
    this.area = el("div", {class: "area"}, this.canvas, this.cursor);
    this.values = this.series.map(() => document.createTextNode("–"));
    const legend = this.series.map((series, i) => el("button", {type: "button", class: "series", "aria-pressed": String(!series.hidden),
      onclick: (event) => this.toggle(series, event.currentTarget)},
    el("i", {class: `swatch ${series.kind}`}), series.label, el("b", {}, this.values[i])));
    this.element.replaceChildren(
      el("header", {}, el("h3", {}, name), el("button", {type: "button", class: "away", "aria-label": `Put ${quantity.title} away`,
        onclick: () => choosePlot(quantity.key, false)}, "✕")),
      el("div", {class: "legend"}, legend), this.area);
    this.area.addEventListener("pointerdown", (event) => this.scrub(event));
    this.area.addEventListener("pointermove", (event) => { if (event.buttons & 1) this.scrub(event); });
    seen.observe(this.element);
  }

  isHidden({kind, label}) {
    return this.series?.some((series) => series.kind === kind && series.label === label && series.hidden) ?? false;
  }
  toggle(series, button) {
    series.hidden = !series.hidden;
    button.setAttribute("aria-pressed", String(!series.hidden));
    this.draw();
    this.show(clock.t_s);
  }

  // The time under the pointer.
  scrub(event) {
    if (!this.chart || event.button > 0) return;
    const {chartArea: area, scales: {x}} = this.chart;
    if (event.type === "pointerdown") this.area.setPointerCapture(event.pointerId);
    const at = event.clientX - this.area.getBoundingClientRect().left;
    clock.seek(x.getValueForPixel(Math.min(Math.max(at, area.left), area.right)));
  }

  // Points of the rows that came since.
  extend() {
    for (const series of this.series) {
      for (let row = series.points.length; row < series.flight.rows; ++row) {
        let y = series.of(row);
        if (this.quantity.angle) {
          const first = this.series[0] === series ? series.last : this.series[0].points[row]?.y;
          y = withoutLeaps(y, Number.isFinite(first) ? first : series.last);
          if (y !== null) series.last = y;
        }
        series.points.push({x: series.at(row), y: y ?? NaN});
      }
    }
  }

  // null: the time of no row.
  valueAt(series, t_s) {
    const {flight} = series;
    if (!series.points.length || t_s < flight.begin_s - flight.step_s || t_s > flight.end_s + flight.step_s) return null;
    const {y} = series.points[flight.rowAt(t_s)] ?? {y: NaN};
    return Number.isFinite(y) ? y : null;
  }

  draw() {
    this.extend();
    this.chart?.destroy();
    this.chart = new Chart(this.canvas, this.description());
  }
  datasets() {
    return this.series.filter(({hidden}) => !hidden)
      .sort((a, b) => drawnLast.indexOf(b.kind) - drawnLast.indexOf(a.kind))
      .map(({kind, points}) => ({
        data: points, pointRadius: 0, pointHitRadius: 0, borderColor: inkOf(kind), backgroundColor: inkOf(kind),
        pointBorderWidth: 0, pointBackgroundColor: inkOf(kind), borderJoinStyle: "round", ...styles[kind],
      }));
  }
  span() {
    const end_s = Math.max(clock.end_s, clock.begin_s + 0.5);
    return {min: isLive && clock.following ? Math.max(clock.begin_s, end_s - followed_s) : clock.begin_s, max: end_s};
  }
  description() {
    const line = color("line"), least = {"°": 1, "px": 2, "m": 0.1, "m/s": 0.1, "°/s": 1}[this.quantity.unit] ?? 1e-3;
    const ticks = {color: color("soft"), font: {size: 11, family: getComputedStyle(document.body).fontFamily}};
    return {
      type: "line", data: {datasets: this.datasets()}, plugins: [{id: "place", afterLayout: (chart) => this.place(chart)}],
      options: {
        parsing: false, normalized: true, events: [], spanGaps: false,
        layout: {padding: {top: 6, right: rightOfPlot}},
        plugins: {decimation: {enabled: true, algorithm: "min-max", threshold: 6000}, phases: {}},
        scales: {
          x: {type: "linear", ...this.span(), grid: {color: line}, afterFit(scale) { scale.paddingRight = 0; },
            ticks: {...ticks, maxRotation: 0, autoSkipPadding: 24, includeBounds: false, callback: (value) => `${number(value)} s`}},
          y: {grid: {color: line}, ticks: {...ticks, maxTicksLimit: 6, callback: (value) => number(value)},
            afterFit(scale) { scale.width = leftOfPlot; },
            afterDataLimits(scale) {
              const spare = Math.max((scale.max - scale.min) * 0.06, (least - (scale.max - scale.min)) / 2);
              scale.max += spare, scale.min -= spare;
            }},
        },
      },
    };
  }
  update() {
    if (!this.chart) return;
    this.extend();
    Object.assign(this.chart.options.scales.x, this.span());
    this.chart.update("none");
  }

  // Where the cursor runs; without asking the page for sizes while the time goes on.
  place({chartArea: area, scales: {x}}) {
    this.cursor.style.top = `${area.top}px`;
    this.cursor.style.height = `${area.bottom - area.top}px`;
    this.pixelAt = (t_s) => area.left + (area.right - area.left) * (t_s - x.min) / (x.max - x.min || 1);
    this.show(clock.t_s);
  }
  show(t_s) {
    if (!this.pixelAt) return;
    if (flight.data.live) this.extend();
    this.cursor.style.transform = `translateX(${this.pixelAt(t_s)}px)`;
    this.series.forEach((series, i) => {
      const value = this.valueAt(series, t_s);
      const text = value === null ? "–" : fixedNumber(value, this.quantity.unit);
      if (this.values[i].data !== text) this.values[i].data = text;
    });
  }
}

// As many digits as do not dance.
const fixedNumber = (value, unit) =>
  minus(value.toFixed(unit === "m" || unit === "m/s" ? 3 : Math.abs(value) >= 1000 ? 0 : 2));

// A plot is drawn when it comes into view.
const seen = new IntersectionObserver((entries) => {
  for (const {target, isIntersecting} of entries) {
    const plot = plots.get(target.dataset.quantity);
    if (!plot) continue;
    plot.inView = isIntersecting;
    if (!isIntersecting) continue;
    if (plot.chart) plot.update();
    else plot.draw();
  }
}, {rootMargin: "120px"});

const drawPlotsAgain = () => plots.forEach((plot) => {
  if (plot.chart) plot.draw();
});

const chosenPlots = new Set();
const choosePlot = (key, wanted) => {
  if (wanted) chosenPlots.add(key);
  else chosenPlots.delete(key);
  arrangePlots();
};
const arrangePlots = () => {
  const all = quantities();
  for (const [key, plot] of plots) {
    if (chosenPlots.has(key)) continue;
    seen.unobserve(plot.element);
    plot.chart?.destroy();
    plot.element.remove();
    plots.delete(key);
  }
  for (const each of all) {
    if (!chosenPlots.has(each.key) || plots.has(each.key)) continue;
    const plot = new Plot(each);
    plots.set(each.key, plot);
    byId("plots").append(plot.element);
  }
  byId("no-plots").hidden = plots.size > 0 || !flight.rows;
  fillPicker(all);
};

// Which there are to choose; it stays as it is, with what is chosen in it, while there are the same.
const fillPicker = (all) => {
  const keys = all.map(({key}) => key).join();
  if (byId("picker").dataset.keys !== keys) {
    byId("picker").dataset.keys = keys;
    const groups = [...new Set(all.map(({group}) => group))];
    byId("picker").replaceChildren(...groups.map((group) => el("fieldset", {}, el("legend", {}, group),
      all.filter((each) => each.group === group).map(({key, title, unit}) => el("label", {},
        el("input", {type: "checkbox", value: key, onchange: (event) => choosePlot(key, event.target.checked)}),
        ` ${title}${unit ? ` (${unit})` : ""}`)))));
  }
  for (const box of byId("picker").querySelectorAll("input")) box.checked = chosenPlots.has(box.value);
};

// What a flight that is still flown brings: some times a second, in a fifth of the time at most, and what there is of it anew when
// columns fill.
const update_ms = 100;
let updateDue = false, columnsDue = false, firstChoice = true, updateTook_ms = 0;
const updatePlots = () => {
  updateDue = false;
  const began_ms = performance.now();
  drawNews();
  updateTook_ms = performance.now() - began_ms;
};
const drawNews = () => {
  if (columnsDue) {
    columnsDue = false;
    if (firstChoice) shownAtFirst(quantities().map(({key}) => key)).forEach((key) => chosenPlots.add(key));
    const before = [...plots.values()];
    arrangePlots();
    before.forEach((plot) => plot.build());
    before.forEach((plot) => { if (plot.inView) plot.draw(); });
    return;
  }
  plots.forEach((plot) => { if (plot.inView) plot.update(); });
};

const setUpPlots = () => {
  shownAtFirst(quantities().map(({key}) => key)).forEach((key) => chosenPlots.add(key));
  arrangePlots();
  byId("picker").addEventListener("change", () => { firstChoice = false; });
  clock.onTime((t_s) => plots.forEach((plot) => { if (plot.inView) plot.show(t_s); }));
  flights.forEach((each) => each.onChange((what) => {
    if (what === "columns") columnsDue = true;
    if (updateDue || (what !== "columns" && what !== "row")) return;
    updateDue = true;
    setTimeout(updatePlots, Math.max(update_ms, 4 * updateTook_ms));
  }));
};
