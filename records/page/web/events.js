// SPDX-License-Identifier: Apache-2.0
// What happened: phases and marks on the time line, and the list of it. Each leads to its instant.
const phasesOf = (flight) => flight.events.filter(({what}) => what === "phase");
const allEvents = () => flights.flatMap((of) => of.events.map((event) => ({...event, of})))
  .sort((a, b) => a.t_s - b.t_s);
const seconds = (t_s) => `${t_s.toFixed(2)} s`;
const placeOnLine = (t_s) => 100 * (t_s - clock.begin_s) / (clock.end_s - clock.begin_s || 1);

// What weighs more than that something began.
const isGrave = ({what, is}) => /lost|fail|wrong|abort|crash|error|saturated|limits|stale|refused|broke/.test(`${what} ${is}`)
  && !/no longer|is back/.test(is);

const jumpToEvent = (by) => {
  const times = allEvents().map(({t_s}) => t_s);
  const t_s = by > 0 ? times.find((each) => each > clock.t_s + 1e-3) : times.findLast((each) => each < clock.t_s - 1e-3);
  clock.pause();
  clock.seek(t_s ?? (by > 0 ? clock.end_s : clock.begin_s));
};

// An event happens between rows: what it leads to is the row in which it shows.
const eventButton = (event) => el("button", {type: "button", class: "event", onclick: () => {
  clock.pause();
  clock.seek(event.t_s);
}}, el("span", {class: "when"}, seconds(event.t_s)),
el("span", {class: isGrave(event) ? "grave" : null}, second ? el("b", {class: "letter"}, event.of.letter) : null,
  `${event.what}: ${event.is}`));

let eventButtons = [];
const drawEvents = () => {
  const events = allEvents();
  eventButtons = events.map((event) => ({t_s: event.t_s, button: eventButton(event)}));
  byId("events-list").replaceChildren(...eventButtons.map(({button}) => el("li", {}, button)));
  byId("events-count").textContent = plural(events.length, "event");
  drawTimeline();
  showEvent(clock.t_s);
};

// Phases as bands, all else as strokes.
const drawTimeline = () => {
  const phases = phasesOf(flight);
  byId("phases").replaceChildren(...phases.map(({t_s, is}, i) => {
    const end_s = phases[i + 1]?.t_s ?? flight.end_s;
    const [from, to] = [placeOnLine(t_s), placeOnLine(end_s)];
    return to > from ? el("span", {style: `left: ${from}%; width: ${to - from}%`}, is) : null;
  }).filter(Boolean));
  byId("marks").replaceChildren(...allEvents().map((event) =>
    el("i", {class: [isGrave(event) ? "grave" : "", event.of === second ? "second" : ""].join(" ").trim() || null,
      style: `left: ${placeOnLine(event.t_s)}%`})));
};

const showEvent = (t_s) => {
  let at = -1;
  eventButtons.forEach((each, i) => { if (each.t_s <= t_s + 1e-3) at = i; });
  const button = eventButtons[at]?.button;
  if (button === showEvent.shown) return;
  showEvent.shown?.removeAttribute("aria-current");
  button?.setAttribute("aria-current", "true");
  showEvent.shown = button;
  const list = byId("events-list");
  if (button) list.scrollTop = Math.max(0, button.offsetTop - list.clientHeight / 2);
};

// The mark that lies nearest to a click.
const clickOnMarks = (click) => {
  const box = byId("marks").getBoundingClientRect();
  const t_s = clock.begin_s + (clock.end_s - clock.begin_s) * (click.clientX - box.left) / box.width;
  const nearest = allEvents().reduce((best, event) =>
    (!best || Math.abs(event.t_s - t_s) < Math.abs(best.t_s - t_s) ? event : best), null);
  if (!nearest) return;
  clock.pause();
  clock.seek(nearest.t_s);
  announce(`${seconds(nearest.t_s)}, ${nearest.what}: ${nearest.is}`);
};

const setUpEvents = () => {
  byId("marks").addEventListener("click", clickOnMarks);
  drawEvents();
  clock.onTime(showEvent);
  flights.forEach((each) => each.onChange((what) => { if (what === "event" || what === "description") drawEvents(); }));
};
