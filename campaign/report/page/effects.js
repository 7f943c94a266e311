// SPDX-License-Identifier: Apache-2.0
// What each parameter does to a metric: rank correlation and Sobol indices, with their intervals.
const effectKinds = [
  {field: "rank_correlation", title: "Rank correlation (Spearman)", from: -1, to: 1,
   sure: ({low, high}) => low > 0 || high < 0, note: ""},
  {field: "first_order", title: "First-order Sobol index", from: 0, to: 1, sure: ({low}) => low > 0.01,
   note: " The Sobol index is the share of the metric’s variance that goes with this parameter alone; what is left goes with several " +
     "together, and with the seed."},
];

const effectsOf = (metric, field) => summary.effects.filter((each) => each.of === metric && each[field])
    .map((each) => ({key: each.key, ...each[field]}))
    .sort((a, b) => Math.abs(b.value) - Math.abs(a.value));

const describeEffects = (metric, kind) => {
  const effects = effectsOf(metric, kind.field);
  const ends = effects.flatMap(({low, high, value}) => [low, high, value].filter(hasNumber));
  const most = Math.min(1, Math.ceil(10 * Math.max(0.1, ...ends.map(Math.abs))) / 10);
  return {
    type: "bar",
    data: {labels: effects.map(({key}) => key), datasets: [{
      label: kind.title, data: effects.map(({value}) => value),
      intervals: effects.map(({low, high}) => (hasNumber(low) && hasNumber(high) ? [low, high] : null)),
      backgroundColor: effects.map((each) => (kind.sure(each) ? color("accent") : color("pale"))),
      barPercentage: 0.7}]},
    options: {
      indexAxis: "y",
      interaction: {mode: "index", axis: "y", intersect: false},
      scales: {x: axis("", {min: kind.from < 0 ? -most : 0, max: most}),
               y: {grid: {display: false}, ticks: {autoSkip: false, font: {size: 11}}}},
      plugins: {legend: {display: false}, tooltip: {callbacks: {
        label: ({dataIndex: at}) =>
          `${number(effects[at].value, 3)}, from ${number(effects[at].low, 3)} to ${number(effects[at].high, 3)}`}}},
    },
  };
};

const drawEffects = () => {
  const metric = byId("effects-metric").value;
  const kinds = effectKinds.filter(({field}) => effectsOf(metric, field).length);
  for (const {field} of effectKinds) charts[`effects-${field}`]?.destroy(), described.delete(`effects-${field}`);
  byId("effects-charts").replaceChildren(...kinds.map(({field, title}) => el("div", {},
    el("h3", {}, title),
    el("div", {class: "chart", style: `height:${3.2 + 1.7 * effectsOf(metric, field).length}rem`},
      el("canvas", {id: `effects-${field}`, role: "img", "aria-label": `${title} of ${metric}: ` +
        effectsOf(metric, field).map(({key, value}) => `${key} ${number(value, 2)}`).join(", ")})))));
  byId("effects-note").textContent = `Lines are ${confidence} intervals. A pale bar cannot be told from none.${kinds.map(({note}) => note).join("")}`;
  for (const kind of kinds) draw(`effects-${kind.field}`, () => describeEffects(metric, kind));
};

const setUpEffects = () => {
  const metrics = [...new Set(summary.effects.map((each) => each.of))];
  if (!metrics.length) return;
  byId("effects").hidden = false;
  fillSelect(byId("effects-metric"), metrics, data.metrics.find((name) => metrics.includes(name)));
  byId("effects-metric").addEventListener("change", drawEffects);
  drawEffects();
};
