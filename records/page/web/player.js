// SPDX-License-Identifier: Apache-2.0
// Play, pause, steps, the time line that is dragged, and what holds at this instant.
const symbols = {
  play: "M6 4l13 8-13 8z", pause: "M6 4h4v16H6zM14 4h4v16h-4z",
  before: "M5 4h3v16H5zM20 4v16L9 12z", after: "M16 4h3v16h-3zM4 4l11 8-11 8z",
  back: "M14 5v14l-9-7zM16 5h3v14h-3z", on: "M10 5l9 7-9 7zM5 5h3v14H5z",
};
const symbol = (name) => {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", symbols[name]);
  svg.append(path);
  return svg;
};

// Of each flight, in words: what the columns of text say.
const stateColumns = ["phase", "target", "target_state", "mode", "reaction"];
const stateAt = (flight, t_s) => {
  if (!flight.rows) return "";
  const row = flight.rowAt(t_s);
  const words = stateColumns.map((name) => [name, flight.text(name, row)]).filter(([, text]) => text && text !== "none")
    .map(([name, text]) => `${name.replaceAll("_", " ")} ${text}`);
  if (flight.value("saturated", row)) words.push("saturated");
  return words.join(" · ");
};

const setUpPlayer = () => {
  const slider = byId("time"), play = byId("play"), rate = byId("rate");
  const button = (id, name, action) => {
    byId(id).replaceChildren(symbol(name));
    byId(id).addEventListener("click", action);
  };
  button("play", "play", clock.toggle);
  button("event-before", "before", () => jumpToEvent(-1));
  button("event-after", "after", () => jumpToEvent(1));
  button("frame-back", "back", () => clock.step(-1));
  button("frame-on", "on", () => clock.step(1));
  rate.replaceChildren(...clock.rates.map((each) => el("option", {value: each}, `${each} ×`)));
  rate.addEventListener("change", () => clock.setRate(Number(rate.value)));
  slider.addEventListener("input", () => {
    if (clock.playing) clock.pause();
    clock.seek(Number(slider.value));
  });
  byId("newest").addEventListener("click", clock.follow);

  const changed = () => {
    const runs = clock.playing || clock.following;
    if (changed.runs !== runs) play.replaceChildren(symbol(runs ? "pause" : "play"));
    changed.runs = runs;
    play.setAttribute("aria-label", runs ? "Pause" : "Play");
    rate.value = String(clock.rate);
    Object.assign(slider, {min: clock.begin_s, max: clock.end_s, step: "any"});
    byId("newest").hidden = !flight.data.live;
    byId("newest").setAttribute("aria-pressed", String(clock.following));
    byId("length").textContent = `of ${seconds(clock.end_s)}`;
    if (changed.end_s !== clock.end_s) growTimeline();
    changed.end_s = clock.end_s;
  };
  // That of a flight that is still flown grows with every row.
  let growing = null;
  const growTimeline = () => {
    if (!flight.data.live) return drawTimeline();
    growing ??= setTimeout(() => {
      growing = null;
      drawTimeline();
    }, 200);
  };
  clock.onChange(changed);
  clock.onTime((t_s) => {
    slider.value = t_s;
    byId("now").textContent = seconds(t_s);
    const states = flights.map((each) => (second ? `${each.letter}: ` : "") + stateAt(each, t_s));
    byId("played").style.width = `${placeOnLine(t_s)}%`;
    states.forEach((text, i) => {
      if (byId("states").children[i].textContent !== text) byId("states").children[i].textContent = text;
    });
    if (Math.abs((setUpPlayer.spoken ?? -1) - t_s) > 0.2) {
      setUpPlayer.spoken = t_s;
      slider.setAttribute("aria-valuetext", `${seconds(t_s)} of ${seconds(clock.end_s)}`);
    }
  });
  byId("states").replaceChildren(...flights.map(() => el("p", {})));
  flights.forEach((each) => each.onChange((what) => { if (what === "row" || what === "columns") clock.span(); }));
  clock.span();
};
