// SPDX-License-Identifier: Apache-2.0
// One run: what it was given, what it came to, how to fly it again.
let shownRow = null, cameFrom = null;

const showRun = (row) => {
  const run = runOfRow.get(row);
  if (!run) return;
  const panel = byId("run");
  if (panel.hidden) cameFrom = document.activeElement;
  shownRow = row;
  const at = data.runs.indexOf(run);
  const step = (by, label) => el("button", {type: "button", "aria-label": label, disabled: !data.runs[at + by],
    onclick: () => showRun(data.runs[at + by].row)}, by < 0 ? "‹" : "›");
  const table = (rows) => el("table", {}, el("tbody", {}, rows.map(([name, value]) =>
    el("tr", {}, el("td", {}, name), el("td", {class: missedCriteria(run).includes(name) ? "missed" : null}, value)))));
  panel.replaceChildren(...[
    el("div", {class: "bar-top"}, el("h2", {id: "run-title"}, `Run ${row}`), step(-1, "Run before"), step(1, "Run after"),
      el("button", {type: "button", "aria-label": "Close", onclick: hideRun}, "✕")),
    el("p", {}, badge(run.status), " ", run.outcome),
    run.status === "failed" && missedCriteria(run).length
      ? el("p", {class: "note"}, "Not met: ", missedCriteria(run).join(", ")) : null,
    videoOf(run),
    el("h3", {}, "Fly it again"), commandLine(replayCommand(row)),
    run.recording ? el("p", {class: "note"}, "Recorded in ", el("a", {href: `${run.recording}/`}, run.recording)) : null,
    run.log ? el("details", {open: true}, el("summary", {}, "What its worker said last"), el("pre", {tabindex: 0}, run.log)) : null,
    el("h3", {}, "Parameters"), table(data.keys.map((key, i) => [key, run.values[i]])),
    el("h3", {}, "Metrics"), table(data.metrics.filter((_, i) => hasNumber(run.metrics[i]))
      .map((name) => [name, withUnit(metricOf(name)(run), name)])),
    el("p", {class: "note"}, "State hash ", el("code", {}, run.state_hash || "none"), ", image hash ", el("code", {}, run.image_hash || "none")),
  ].filter(Boolean));
  panel.hidden = false;
  panel.scrollTop = 0;
  panel.focus({preventScroll: true});
  for (const tr of document.querySelectorAll("tr[data-row]")) tr.classList.toggle("here", Number(tr.dataset.row) === row);
  history.replaceState(null, "", `#run=${row}`);
};

const hideRun = () => {
  byId("run").hidden = true;
  shownRow = null;
  for (const tr of document.querySelectorAll("tr.here")) tr.classList.remove("here");
  history.replaceState(null, "", location.pathname + location.search);
  cameFrom?.focus({preventScroll: true});
};

const setUpRunPanel = () => {
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && !byId("run").hidden) hideRun();
  });
  const fromAddress = () => {
    const match = location.hash.match(/^#run=(\d+)$/);
    if (match && Number(match[1]) !== shownRow) showRun(Number(match[1]));
  };
  addEventListener("hashchange", fromAddress);
  fromAddress();
};
