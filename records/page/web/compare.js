// SPDX-License-Identifier: Apache-2.0
// Tables of a flight, or of two beside each other.
const shownNumber = (value, name) => (hasNumber(value) ? withUnit(value, name) : "not reached");

// Rows of [name, value of A, value of B], with the difference.
const numbersTable = (caption, names, of) => el("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": caption},
  el("table", {}, el("thead", {}, el("tr", {}, el("th", {scope: "col"}, "Name"),
    ...(second ? ["A", "B", "B − A"] : ["Value"]).map((text) => el("th", {scope: "col", class: "number"}, text)))),
  el("tbody", {}, names.map((name) => {
    const values = flights.map((each) => of(each, name));
    const difference = second && values.every(hasNumber) ? [values[1] - values[0]] : second ? [null] : [];
    return el("tr", {}, el("th", {scope: "row"}, el("code", {}, name)),
      ...values.map((value) => el("td", {class: "number"}, shownNumber(value, name))),
      ...difference.map((value) => el("td", {class: "number"}, hasNumber(value) ? withUnit(value, name) : "–")));
  }))));

const namesOf = (of) => [...new Set(flights.flatMap((each) => Object.keys(of(each) ?? {})))].sort();

const stagesTable = () => {
  const names = namesOf(({data}) => data.stages);
  return el("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "Times of the stages"}, el("table", {}, el("thead", {}, el("tr", {}, el("th", {scope: "col"}, "Stage"),
    ...flights.flatMap(({letter}) => ["mean", "99 of 100 within"].map((text) =>
      el("th", {scope: "col", class: "number"}, second ? `${letter}, ${text}` : text))))),
  el("tbody", {}, names.map((name) => el("tr", {}, el("th", {scope: "row"}, name),
    ...flights.flatMap(({data}) => ["mean_ms", "p99_ms"].map((key) =>
      el("td", {class: "number"}, withUnit(data.stages?.[name]?.[key], key)))))))));
};

const provenance = () => {
  const words = {version: "Version", state_hash: "Hash of the states", image_hash: "Hash of the images", renderer: "Renderer"};
  const rows = [
    ...Object.entries(words).map(([key, name]) => [name, ({data}) => data[key]]),
    ["Plugins", ({data}) => (data.plugins ?? []).map((each) => (typeof each === "string" ? each : JSON.stringify(each))).join(", ")],
    ...namesOf(({data}) => data.machine).map((key) => [key.replaceAll("_", " "), ({data}) => String(data.machine?.[key] ?? "")]),
  ].filter(([, of]) => flights.some((each) => of(each)));
  return el("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": "Where it comes from"}, el("table", {}, el("tbody", {}, rows.map(([name, of]) =>
    el("tr", {}, el("th", {scope: "row"}, name), ...flights.map((each) => el("td", {}, el("code", {}, of(each) || "–"))))))));
};

const drawTables = () => {
  const detail = (title, table) => el("details", {}, el("summary", {}, title), table);
  const metrics = namesOf(({data}) => data.metrics);
  const opened = [...byId("tables").querySelectorAll("details")].map(({open}) => open);
  byId("tables").replaceChildren(...[
    metrics.length ? detail(plural(metrics.length, "metric"), numbersTable("Metrics", metrics, ({data}, name) => data.metrics?.[name])) : null,
    namesOf(({data}) => data.stages).length ? detail("Times of the stages of a frame", stagesTable()) : null,
    detail("Where it comes from: version, hashes, machine", provenance()),
  ].filter(Boolean));
  byId("tables").querySelectorAll("details").forEach((each, i) => { each.open = opened[i] ?? false; });
};
const setUpTables = () => {
  drawTables();
  flights.forEach((each) => each.onChange((what) => { if (what === "description") drawTables(); }));
};
