// SPDX-License-Identifier: Apache-2.0
// How far each method had come after so many flights, and the gains that came of it.
const methodColors = ["accent", "bad", "good", "soft", "ink"];
const methods = () => [...new Set(data.tuning.searches.map(({method}) => method))];

const costAfter = (search, flights) => search.cost[search.flights.filter((each) => each <= flights).length - 1];

const medianOfSearches = (searches) => {
  const places = [...new Set(searches.flatMap(({flights}) => flights))].sort((a, b) => a - b);
  return places.map((flights) => ({x: flights, all: searches.map((each) => costAfter(each, flights))}))
      .filter(({all}) => all.every(hasNumber)).map(({x, all}) => ({x, y: quantileOfSorted(ascending(all), 0.5)}));
};

const describeTuning = () => {
  const logarithmic = byId("tuning-log").checked;
  const datasets = [];
  methods().forEach((method, at) => {
    const searches = data.tuning.searches.filter((each) => each.method === method);
    const line = {stepped: "before", pointRadius: 0, pointHitRadius: 4, borderColor: color(methodColors[at % methodColors.length]),
                  borderDash: at < methodColors.length ? [] : [6, 4], showLine: true, pointStyle: "line"};
    datasets.push({...line, label: method, borderWidth: 3, data: medianOfSearches(searches), order: 1});
    if (searches.length > 1)
      for (const each of searches)
        datasets.push({...line, label: `${method}, repetition ${each.repetition}`, alone: true, borderWidth: 0.8, order: 2,
                       data: each.flights.map((x, i) => ({x, y: each.cost[i]}))});
  });
  const start = data.tuning.start_cost;
  const last = Math.max(...data.tuning.searches.flatMap(({flights}) => flights));
  if (hasNumber(start))
    datasets.push({label: "gains it started from, where no search saw them", data: [{x: 0, y: start}, {x: last, y: start}], showLine: true, pointRadius: 0,
                   borderColor: color("soft"), borderDash: [6, 4], borderWidth: 1.5, pointStyle: "line", order: 3});
  return {type: "scatter", data: {datasets}, options: {
    interaction: {mode: "nearest", axis: "x", intersect: false},
    scales: {x: axis("flights", {min: 0}), y: axis("cost", logarithmic ? {type: "logarithmic"} : {})},
    plugins: {legend: {labels: {usePointStyle: true, filter: ({datasetIndex}) => !datasets[datasetIndex].alone}},
              tooltip: {callbacks: {label: ({dataset, parsed}) => `${dataset.label}: ${number(parsed.y)} after ${count(parsed.x)} flights`}}},
  }};
};

// Searches side by side, by what the gains that they found cost where none of them looked.
const showHeldOut = () => {
  const rows = methods().map((method) => {
    const costs = ascending(data.tuning.searches.filter((each) => each.method === method).map(({held_out}) => held_out));
    return {method, costs, median: quantileOfSorted(costs, 0.5)};
  }).filter(({costs}) => costs.length).sort((a, b) => a.median - b.median);
  byId("tuning-note").after(el("h3", {}, "Cost on rows that no search saw"), el("table", {id: "tuning-held-out"},
    el("thead", {}, el("tr", {}, el("th", {}, "method"), el("th", {class: "number"}, "median"), el("th", {}, "each search"))),
    el("tbody", {}, rows.map(({method, costs, median}) => el("tr", {}, el("td", {}, method),
      el("td", {class: "number"}, number(median)), el("td", {}, costs.map((cost) => number(cost)).join("  ")))))));
};

const setUpTuning = () => {
  if (!data.tuning || !data.tuning.searches.length) return;
  byId("tuning").hidden = false;
  byId("top").prepend(byId("tuning"));
  const drawIt = () => draw("tuning-chart", describeTuning);
  byId("tuning-controls").append(el("label", {}, el("input", {type: "checkbox", id: "tuning-log", onchange: drawIt}), " logarithmic"));
  byId("tuning-chart").setAttribute("role", "img");
  byId("tuning-chart").setAttribute("aria-label", "Cost against flights for each method");
  const repeated = methods().some((method) => data.tuning.searches.filter((each) => each.method === method).length > 1);
  byId("tuning-note").textContent = "What candidates cost as the search saw it: the median of each round, which flies rows of its own; of random search, where all fly the same, the least so far" +
    (repeated ? "; thick: the median of the repetitions, thin: each of them." : ".") +
    ` Cost: ${data.tuning.cost}. How the gains do on rows that the search never saw is in the other sections.`;
  if (data.tuning.verdict) byId("tuning-note").after(el("p", {id: "tuning-verdict"}, data.tuning.verdict));
  drawIt();
  if (data.tuning.searches.length > 1) showHeldOut();
  if (!data.tuning.gains.length) return void (byId("tuning-gains").hidden = true);
  byId('tuning-gains')
      .append(
          el('h3', {}, 'Gains'),
          el('table', {},
             el('thead', {},
                el('tr', {}, el('th', {}, 'key'),
                   ['started from', 'tuned', 'minimum', 'maximum'].map((t) => el('th', {class: 'number'}, t)),
                   el('th', {}, 'scale'))),
             el('tbody', {},
                data.tuning.gains.map(
                    (g) => el(
                        'tr', {}, el('td', {class: 'mono'}, g.key),
                        [g.start, g.tuned, g.low, g.high].map((v) => el('td', {class: 'number'}, number(v))),
                        el('td', {}, g.log ? 'log' : 'linear'))))));
};
