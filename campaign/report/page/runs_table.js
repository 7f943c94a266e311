// SPDX-License-Identifier: Apache-2.0
// Every run in a table that sorts and filters, and the worst of them.
const runsPerPage = 50;
const table = {by: "row", down: false, page: 0, status: "all", outcome: null};

// A column: its name, whether its values are numbers, and the value of a run.
const columns = () => {
  const fixed = [
    {name: "row", numeric: true, of: (run) => run.row},
    {name: "status", of: (run) => run.status},
    {name: "outcome", of: (run) => run.outcome},
  ];
  const parameters = data.keys.map((key, at) => {
    const {numeric, of} = parameterOf(key);
    return {name: key, kind: "parameter", numeric, of: numeric ? of : (run) => run.values[at], text: (run) => run.values[at]};
  });
  const metrics = data.metrics.map((name) => ({name, kind: "metric", numeric: true, of: metricOf(name)}));
  return [...fixed, ...metrics, ...parameters];
};
const allColumns = columns();
const shownColumns = () => allColumns.filter(({name, kind}) =>
  kind === undefined || (kind === "parameter" ? variesIn(name) : byId("runs-all").checked || shownFirst.includes(name)));

// Words that are all to be somewhere in a run's texts, and comparisons: "wind.mean_m_s>4".
const wordsOf = (text) => text.trim().split(/\s+/).filter(Boolean).map((word) => {
  const match = word.match(/^([^<>=]+)(<=|>=|<|>|=)(.+)$/);
  const column = match && (allColumns.find(({name}) => name === match[1]) ?? allColumns.find(({name}) => name.includes(match[1])));
  if (!column) return (run) => `${run.row} ${run.status} ${run.outcome} ${run.values.join(" ")}`.toLowerCase().includes(word.toLowerCase());
  const wanted = column.numeric ? Number(match[3]) : match[3];
  const tests = {"<": (v) => v < wanted, ">": (v) => v > wanted, "<=": (v) => v <= wanted, ">=": (v) => v >= wanted, "=": (v) => v === wanted};
  return (run) => (!column.numeric || hasNumber(column.of(run))) && tests[match[2]](column.of(run));
});

const filteredRuns = () => {
  const words = wordsOf(byId("runs-filter").value);
  return data.runs.filter((run) =>
    (table.status === "all" || (table.status === "not passed" ? !passed(run) : run.status === table.status)) &&
    (table.outcome === null || run.outcome === table.outcome) && words.every((word) => word(run)));
};

const sortedRuns = () => {
  const {numeric, of} = allColumns.find(({name}) => name === table.by);
  const none = (value) => (numeric ? !hasNumber(value) : value === "");
  const sign = table.down ? -1 : 1;
  return filteredRuns().sort((a, b) => {
    const [x, y] = [of(a), of(b)];
    if (none(x) || none(y)) return none(x) - none(y) || a.row - b.row;  // what has no value comes last
    return sign * (numeric ? x - y : x.localeCompare(y)) || a.row - b.row;
  });
};

// A seed has more digits than a number of JavaScript holds.
const whole = (text) => /^[+-]?\d+$/.test(text ?? "");

const cell = (run, {name, numeric, of, text}) => {
  if (name === "row") return el("td", {}, rowButton(run.row));
  if (name === "status") return el("td", {}, badge(run.status));
  const value = of(run);
  return el("td", {class: numeric ? "number" : "text", title: text ? text(run) : (numeric ? undefined : value)},
            numeric && !whole(text?.(run)) ? number(value) : text?.(run) ?? value);
};

const drawTable = () => {
  const runs = sortedRuns(), shown = shownColumns();
  const pages = Math.max(1, Math.ceil(runs.length / runsPerPage));
  table.page = Math.min(table.page, pages - 1);
  const heading = ({name, numeric}) => el("th", {class: numeric ? "number" : "", scope: "col", title: name,
    "aria-sort": table.by === name ? (table.down ? "descending" : "ascending") : "none"},
    el("button", {type: "button", "data-sort": name, onclick: () => {
      table.down = table.by === name ? !table.down : false;
      table.by = name;
      table.page = 0;
      drawTable();
      document.querySelector(`[data-sort="${CSS.escape(name)}"]`).focus();
    }}, plainName(name)), el("small", {}, unitOf(name)[1]));
  byId("runs-table").replaceChildren(
    el("thead", {}, el("tr", {}, shown.map(heading))),
    el("tbody", {}, runs.slice(table.page * runsPerPage, (table.page + 1) * runsPerPage).map((run) =>
      el("tr", {class: `pick ${run.row === shownRow ? "here" : ""}`, "data-row": run.row,
                onclick: (event) => { if (!event.target.closest("button")) showRun(run.row); }},
        shown.map((column) => cell(run, column))))));
  byId("runs-count").textContent = runs.length === data.runs.length ? plural(runs.length, "run")
    : `${count(runs.length)} of ${plural(data.runs.length, "run")}` + (table.outcome === null ? "" : `, with outcome “${table.outcome}”`);
  const turn = (to, label, off) => el("button", {type: "button", disabled: off, onclick: () => { table.page = to; drawTable(); }}, label);
  byId("runs-pages").replaceChildren(...(pages === 1 ? [] : [
    turn(0, "First", table.page === 0), turn(table.page - 1, "Before", table.page === 0),
    `page ${table.page + 1} of ${pages}`,
    turn(table.page + 1, "Next", table.page === pages - 1), turn(pages - 1, "Last", table.page === pages - 1)]));
};

// Shows these runs in the table, as a click on an outcome asks.
const filterRuns = ({status, outcome}) => {
  Object.assign(table, {status, outcome, page: 0});
  byId("runs-status").value = status;
  byId("runs-filter").value = "";
  drawTable();
  byId("runs").scrollIntoView();
  announce(byId("runs-count").textContent);
};

const csvOf = (runs) => {
  // A spreadsheet takes for a formula what begins so and is no number: as in runs.csv.
  const plain = (value) => (/^[=+\-@\t\r]/.test(value) && !Number.isFinite(Number(value)) ? `'${value}` : value);
  const quoted = (value) => (/[",\r\n]/.test(value) ? `"${plain(value).replaceAll('"', '""')}"` : plain(value));
  const text = (value) => (hasNumber(value) ? String(value) : quoted(value ?? ""));
  const line = (run) => allColumns.map((column) => text(column.text ? column.text(run) : column.of(run))).join(",");
  return `${[allColumns.map(({name}) => quoted(name)).join(","), ...runs.map(line)].join("\r\n")}\r\n`;
};

const setUpTable = () => {
  const present = statuses.filter((status) => data.runs.some((run) => run.status === status));
  fillSelect(byId("runs-status"), ["all", "not passed", ...present]);
  const again = () => { table.page = 0; drawTable(); };
  byId("runs-status").addEventListener("change", () => { table.status = byId("runs-status").value; table.outcome = null; again(); });
  byId("runs-filter").addEventListener("input", again);
  byId("runs-all").addEventListener("change", drawTable);
  byId("runs-all-label").hidden = data.metrics.length === shownFirst.length;
  byId("runs-csv").addEventListener("click", () => saveFile(`${data.name}.csv`, csvOf(sortedRuns()), "text/csv"));
  drawTable();
};

// The worst by a metric; a run that has none of it did not come so far, and is worse than all that did.
const drawWorst = () => {
  const name = byId('worst-metric').value, of = metricOf(name), least = byId('worst-order').value === 'min';
  const badness = (run) => (!hasNumber(of(run)) ? Infinity : (least ? -1 : 1) * of(run));
  const worst = [...data.runs].sort((a, b) =>
    badness(a) === badness(b) ? passed(a) - passed(b) || a.row - b.row : badness(b) - badness(a)).slice(0, 12);
  byId("worst-list").replaceChildren(...worst.map((run) => el("article", {},
    el("div", {}, rowButton(run.row), " ", badge(run.status)),
    el("p", {class: "value"}, hasNumber(of(run)) ? withUnit(of(run), name) : `no ${plainName(name)}`),
    el("p", {class: "why"}, run.outcome, run.status === "failed" && missedCriteria(run).length ? `; not met: ${missedCriteria(run).join(", ")}` : ""),
    videoOf(run),
    commandLine(replayCommand(run.row)))));
};

// What its criterion keeps from is bad; without one, what is known of the metric.
const worstEnd = (name) => {
  const {min, max} = data.limits[name] ?? {};
  if (hasNumber(min) !== hasNumber(max)) return hasNumber(min) ? "min" : "max";
  return summaryOf.get(name).better === "higher" ? "min" : "max";
};

const setUpWorst = () => {
  if (!data.metrics.length) return void (byId("worst").hidden = true);
  fillSelect(byId("worst-metric"), data.metrics, data.metrics[0]);
  const order = () => { byId("worst-order").value = worstEnd(byId("worst-metric").value); };
  byId("worst-metric").addEventListener("change", () => { order(); drawWorst(); });
  byId("worst-order").addEventListener("change", drawWorst);
  order();
  drawWorst();
};
