// SPDX-License-Identifier: Apache-2.0
// What was wanted of a flight, and what came of it.
const verdictOf = ({data}) => (data.live ? ["flying", ""] : !data.complete ? ["broken off", "bad"]
  : data.criteria?.length ? (data.passed ? ["passed", "good"] : ["not passed", "bad"]) : ["flown", ""]);

const marginOf = ({name, value, limit, at_least, passed}) => {
  if (!hasNumber(value)) return "not reached";
  const spare = at_least ? value - limit : limit - value;
  const share = limit ? ` (${percent(Math.abs(spare / limit), 0)})` : "";
  if (spare === 0) return passed ? "exactly met" : "missed";
  return passed ? `${withUnit(spare, name)}${share} to spare` : `${withUnit(-spare, name)}${share} ${at_least ? "short" : "over"}`;
};

// From 0 to what came of it, with the limit as a dashed stroke.
const criterionBar = ({name, value, limit, at_least, passed}) => {
  const low = Math.min(0, value ?? 0, limit), high = Math.max(0, value ?? 0, limit);
  const reach = (high - low || 1) * (high > 0 ? 1.15 : 1);
  const place = (of) => `${100 * (of - low) / reach}%`;
  return el("div", {class: "criterion-bar", role: "img",
    "aria-label": `${plainName(name)}: ${withUnit(value, name)}, ${at_least ? "at least" : "at most"} ${withUnit(limit, name)}`},
  hasNumber(value) ? el("i", {class: passed ? "value good" : "value bad",
    style: `left: ${place(Math.min(0, value))}; width: max(3px, ${100 * Math.abs(value) / reach}%)`}) : null,
  el("i", {class: "limit", style: `left: ${place(limit)}`}));
};

// On a phone it may be broken, but not within a word.
const breakable = (name) => name.split(/(?<=_)/).flatMap((word) => [word, el("wbr", {})]);

const criterionRow = (criterion) => {
  const {name, value, limit, at_least, passed} = criterion;
  return el("tr", {"data-criterion": name},
    el("th", {scope: "row"}, plainName(name), el("code", {}, breakable(name))),
    el("td", {class: "number"}, hasNumber(value) ? withUnit(value, name) : "not reached"),
    el("td", {class: "reach"}, criterionBar(criterion)),
    el("td", {class: "number"}, `${at_least ? "at least" : "at most"} ${withUnit(limit, name)}`),
    el("td", {class: passed ? "met" : "missed"}, `${passed ? "✓" : "✗"} ${marginOf(criterion)}`));
};

const drawVerdict = (of) => {
  const {data} = of, [word, how] = verdictOf(of);
  const card = byId(`verdict-${of.letter}`);
  card.hidden = false;
  card.replaceChildren(
    el("p", {class: "verdict"}, second ? el("b", {class: "letter"}, of.letter) : "", el("span", {class: `badge big ${how}`}, word),
      el("span", {class: "outcome"}, data.outcome || (data.live ? "still in the air" : ""))),
    data.error && data.error !== data.outcome ? el("p", {class: "missed"}, data.error) : "",
    ...(data.left_out ?? []).map((what) => el("p", {class: "missed"}, `Left out: ${what}.`)),
    data.criteria?.length
      ? el("div", {class: "scroll", tabindex: 0, role: "region", "aria-label": `Criteria${second ? ` of run ${of.letter}` : ""}`},
        el("table", {class: "criteria"}, el("thead", {}, el("tr", {},
          ["Criterion", "Came to", "", "Limit", "Margin"].map((text, i) => (i === 2 ? el("td", {}) : el("th", {scope: "col",
            class: i === 1 || i === 3 ? "number" : null}, text))))),
        el("tbody", {}, data.criteria.map(criterionRow))))
      : el("p", {class: "note"}, data.live ? "Criteria are held against the whole flight, when it has ended."
        : data.complete ? "It was flown without criteria." : "It broke off before criteria were held against it."),
    ...(data.again ? [el("h2", {}, "Fly it again"), commandLine(data.again)] : []));
};

const factsOf = ({data}) => [
  ["seed", data.seed], ["mission", data.mission], ["", data.mode],
  ["", hasNumber(data.sim_s) && data.sim_s ? `${number(data.sim_s)} s of flight in ${number(data.wall_s, 3)} s` : ""],
].filter(([, text]) => text !== "" && text !== undefined && text !== null)
  .map(([name, text]) => el("span", {}, name ? `${name} ` : "", el("b", {}, String(text))));

const drawHeading = () => {
  const {data} = flight;
  byId("name").textContent = flights.map((each) => each.data.title || each.data.scenario).filter((name, i, all) => all.indexOf(name) === i)
    .join(" and ");
  byId("kind").textContent = second ? "Two flights, laid over each other" : flight.data.live ? "Kestrel, in the air" : "Kestrel flight";
  byId("wanted").textContent = data.wanted ?? "";
  byId("facts").replaceChildren(...flights.flatMap((each) => [
    second ? el("b", {class: "letter"}, each.letter) : "", ...factsOf(each)]));
  flights.forEach(drawVerdict);
};
const setUpVerdict = () => {
  drawHeading();
  flights.forEach((each) => each.onChange((what) => { if (what === "description") drawHeading(); }));
};
