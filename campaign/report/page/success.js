// SPDX-License-Identifier: Apache-2.0
// The heading, how many runs passed, how the others ended, and what was asked of the campaign.
const intervalScale = ({share, low, high, wanted}) => {
  const span = Math.max(high - low, 0.002);
  const from = Math.max(0, Math.min(low, wanted ?? low) - span), to = Math.min(1, high + span);
  const place = (value) => `${(100 * (value - from) / (to - from)).toFixed(2)}%`;
  const digits = to - from < 0.05 ? 1 : 0;
  // An end of the scale has no room for its label where the limit's is.
  const free = (end) => !hasNumber(wanted) || Math.abs(wanted - end) > 0.25 * (to - from);
  return el("div", {class: "scale", role: "img", "aria-label": `interval from ${percent(low)} to ${percent(high)}`},
    el("i", {class: "track"}),
    el("i", {class: "span", style: `left:${place(low)};right:calc(100% - ${place(high)})`}),
    el("i", {class: "at", style: `left:${place(share)}`}),
    hasNumber(wanted) ? el("i", {class: "wanted", style: `left:${place(wanted)}`, title: `wanted: ${percent(wanted)}`}) : null,
    free(from) ? el("span", {style: "left:0"}, percent(from, digits)) : null,
    hasNumber(wanted) ? el("span", {style: `left:${place(wanted)}`}, `wanted ${percent(wanted)}`) : null,
    free(to) ? el("span", {class: "last", style: "left:100%"}, percent(to, digits)) : null);
};

const drawHeading = () => {
  byId("kind").textContent = data.tuning ? "Kestrel tuning" : "Kestrel campaign";
  byId("name").textContent = data.name;
  byId("facts").replaceChildren(
    el("span", {}, "scenario ", el("b", {}, data.scenario)),
    data.tuning ? el("span", {}, el("b", {}, count(data.runs.length)), " flights with the gains found, on rows that no search saw")
      : el("span", {}, el("b", {}, count(data.runs.length)), ` of ${plural(summary.rows, "run")} done`),
    el("span", {}, "version ", el("b", {}, data.version)),
    el("span", {}, "sample table ", el("b", {class: "mono"}, data.table_hash)));
  for (const each of document.querySelectorAll(".confidence")) each.textContent = confidence;
};

// Why the interval of the share is right.
const intervalNote = () => {
  if (!hasNumber(summary.stop_when)) return "Clopper-Pearson.";
  const early = summary.ended_early ? `Ended early after ${count(summary.runs)} of ${plural(summary.rows, "run")}: ` : "";
  return `${early}an interval that holds however often one looks (--stop-when ${summary.stop_when}). ` +
    "Those of metrics are of a number of runs that was fixed.";
};

const drawShare = () => {
  const s = {share: summary.success.value, low: summary.success.low, high: summary.success.high, n: summary.runs, passed: summary.passed};
  const box = byId("success-share");
  if (!data.runs.length) return box.replaceChildren("No run is done yet.");
  const wanted = summary.thresholds.find(({name, at_least}) => name === "success" && at_least)?.limit;
  box.replaceChildren(
    el("div", {class: "share", id: "share"}, (100 * s.share).toFixed(s.n >= 200 ? 1 : 0), el("small", {}, " %")),
    el("p", {class: "interval"}, `${confidence} interval `, el("b", {}, `${percent(s.low)} to ${percent(s.high)}`)),
    intervalScale({...s, wanted}),
    el("p", {class: "note"}, `${plural(s.passed, "run")} of ${count(s.n)} passed: they did what the flight is for and met the scenario’s criteria; ` +
       `a run that broke off, crashed, was refused or timed out counts as one that did not. ${intervalNote()}`));
};

// The criteria that rows did not keep to, with how many did not: the most frequent first. Who kept to all did
// not do what the flight is for.
const orElse = (names, other) => (names.length ? names : [other]);
const missedBy = (rows) => {
  const counts = new Map();
  for (const row of rows)
    for (const name of orElse(missedCriteria(runOfRow.get(row)), "what the flight is for"))
      counts.set(name, (counts.get(name) ?? 0) + 1);
  return [...counts].sort((a, b) => b[1] - a[1]);
};

const missedText = (missed, runs) =>
  (missed.length > 1 && missed.length === Object.keys(data.limits).length && missed.every(([, n]) => n === runs)
    ? "no criterion met" : `not met: ${missed.map(([name, n]) => `${name} (${count(n)})`).join(", ")}`);

const drawOutcomes = () => {
  const ends = [...new Set(data.runs.filter(passed).map(({outcome}) => outcome))].map((outcome) =>
    ({status: "passed", outcome, runs: data.runs.filter((run) => passed(run) && run.outcome === outcome).length}));
  const rows = [...ends, ...summary.failures.map(({status, outcome, rows: those}) => ({status, outcome, runs: those.length, missed: status === "failed" ? missedBy(those) : []}))];
  byId("outcomes").replaceChildren(
    el("h3", {}, "How runs ended"),
    el("div", {class: "scroll"}, el("table", {},
      el("thead", {}, el("tr", {}, el("th", {}, "status"), el("th", {}, "outcome"),
        el("th", {class: "number"}, "runs"), el("th", {class: "number"}, "share"))),
      el("tbody", {}, rows.map(({status, outcome, runs, missed}) => el("tr", {},
        el("td", {}, badge(status)),
        el("td", {}, el("button", {type: "button", class: "link", title: "Show these runs in the table",
          onclick: () => filterRuns({status, outcome})}, outcome || "(none)"),
          missed?.length ? el("div", {class: "note"}, missedText(missed, runs)) : null),
        el("td", {class: "number"}, count(runs)),
        el("td", {class: "number"}, percent(runs / data.runs.length))))))));
};

const drawThresholds = () => {
  if (!summary.thresholds.length) return;
  const box = byId("thresholds");
  box.hidden = false;
  const shown = (value, name) => (name === "success" ? percent(value) : withUnit(value, name.split(",")[0]));
  box.replaceChildren(
    el("h3", {}, "Asked of the campaign"),
    el("div", {class: "scroll"}, el("table", {class: "stacks"},
      el("thead", {}, el("tr", {}, ["figure", "wanted", "value", `${confidence} interval`, "met"].map((t) => el("th", {}, t)))),
      el("tbody", {}, summary.thresholds.map((t) => el("tr", {},
        el("td", {}, t.name === "success" ? "share of runs that pass" : t.name),
        el("td", {"data-is": "wanted"}, `at ${t.at_least ? "least" : "most"} ${shown(t.limit, t.name)}`),
        el("td", {"data-is": "value"}, hasNumber(t.value) ? shown(t.value, t.name) : "none: not every run has it"),
        el("td", {"data-is": `${confidence} interval`}, hasNumber(t.value) ? intervalText(t.low, t.high, (value) => shown(value, t.name)) : "none"),
        el("td", {class: t.passed ? "met" : "missed"}, t.passed ? "met" : t.runs_to_tell ? "too few runs to tell" : "not met",
          t.runs_to_tell ? el("small", {}, ` (${count(t.runs_to_tell)} would do that came out alike)`) : null,
          t.without ? el("small", {}, ` (${plural(t.without, "run")} without it)`) : null)))))),
    el("p", {class: "note"}, "Met when the bound of the interval that is against it keeps to the limit. A run without the metric counts as worse than any that has it."));
};

const drawAgain = () => {
  byId("again").replaceChildren(
    el("h3", {}, "Fly it again"),
    ...(data.replay ? [el("p", {class: "note"}, "Any one run, exactly, from its row:"), commandLine(replayCommand("ROW"))]
      : [el("p", {class: "note"}, "These are flights with the gains found, on rows that no search saw; each row has its command.")]),
    ...(data.again ? [el("p", {class: "note"}, "All of it, from its file (below, under Files): the same version and file give the same table of results, bit for bit, with however many workers."),
      commandLine(data.again)] : []));
};
