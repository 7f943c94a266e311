// SPDX-License-Identifier: Apache-2.0
// A flight while it flies: what its server tells (docs/guide/live.md), and what one asks of it.
const live = {
  socket: null, tries: 0, pictures: {}, state: "connecting", paused: false, refusals: {},

  connect() {
    const address = new URL("/live", location.href);
    address.protocol = location.protocol === "https:" ? "wss:" : "ws:";
    address.search = location.search;  // the token
    live.socket = new WebSocket(address);
    live.socket.binaryType = "arraybuffer";
    live.socket.addEventListener("message", ({data}) => live.hear(data));
    live.socket.addEventListener("close", live.lost);
  },
  // Again and again, ever less often; who comes back gets all rows anew.
  lost() {
    const wait_s = Math.min(0.5 * 2 ** live.tries++, 5);
    live.become("lost");
    live.timer = setTimeout(live.connect, 1000 * wait_s);
  },
  become(state) {
    if (state === "lost" && !flight.data.live) state = "ended";
    if (live.state === state) return;
    live.state = state;
    announce(liveStates[state].says);
    drawLive();
  },
  say(command) {
    refusedInFlight("");
    if (live.socket?.readyState === WebSocket.OPEN) live.socket.send(JSON.stringify(command));
  },

  hear(message) {
    if (typeof message !== "string") return live.picture(message);
    const {op, ...told} = JSON.parse(message);
    live.told[op]?.(told);
  },
  told: {
    flight(told) {
      if (goesToNext(told)) return;
      live.tries = 0;
      live.refusals = told.refusals ?? {};
      Object.values(live.pictures).forEach((each) => each.clear());
      flight.describe(told);
      flight.setColumns([]);
      live.become("flying");
      fillLive();
      clock.follow();
    },
    columns({names}) { flight.setColumns(names); },
    rows({rows}) { flight.append(rows); },
    event(event) { flight.addEvent(event); },
    state({paused, speed, real_time_factor}) {
      Object.assign(live, {paused, speed, factor: real_time_factor});
      drawLive();
    },
    end(told) {
      flight.describe({...told, live: false});
      live.become("ended");
      announce(`${verdictOf(flight)[0]}: ${told.outcome}`);
      if (clock.following) clock.follow();
    },
    changed({key, value, again}) {
      refusedInFlight("");
      flight.describe({again});
      showChanged(key, value);
    },
    refused({why, key}) {
      refusedInFlight(why, key);
      drawLive();
      showAllAsTheyAre();
    },
  },

  // A byte of what it is, 8 of its time, a JPEG.
  picture(bytes) {
    const name = {1: "video", 2: "view"}[new DataView(bytes).getUint8(0)];
    if (!name) return;
    live.pictures[name] ??= new LivePictures(name);
    live.pictures[name].add(new DataView(bytes).getFloat64(1, true), new Blob([new Uint8Array(bytes, 9)], {type: "image/jpeg"}));
  },
};

// The page is of one flight, with its world. The server has the page of the next one by the time that it tells of it.
let loadedFor;
const whichFlight = ({scenario, seed, mode, mission, title, again, version}) =>
  JSON.stringify([scenario, seed, mode, mission, title, again, version]);
// Not twice for the same one, should it come as another nevertheless.
const goesToNext = (told) => {
  try {
    const [wanted, before] = [whichFlight(told), sessionStorage.getItem("kestrel-live")];
    sessionStorage.removeItem("kestrel-live");
    if (wanted === loadedFor || wanted === before) return false;
    sessionStorage.setItem("kestrel-live", wanted);
  } catch {  // a page that may keep nothing
    return false;
  }
  location.reload();
  return true;
};

const liveStates = {
  connecting: {badge: "connecting", says: "Connecting to the flight"},
  flying: {badge: "live", how: "good", says: "Connected to the flight"},
  paused: {badge: "paused", says: "The flight is paused"},
  lost: {badge: "lost", how: "bad", says: "The connection is lost; it is tried again"},
  ended: {badge: "ended", says: "The flight has ended"},
};
const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 0];
const speedName = (speed) => (speed === 0 ? "as fast as it goes" : `${number(speed)} ×`);

// Where it was asked for; until the next that is.
const refusedInFlight = (why, key = "") => {
  byId("live-refused").remove();
  const place = [...document.querySelectorAll(".change")].find((each) => key && each.dataset.key === key);
  (place ?? byId("live")).append(refusalLine(why && `Refused: ${why}`));
};
const refusalLine = (text = "") => el("p", {id: "live-refused", class: "missed", role: "alert"}, text);

const drawLive = () => {
  const name = live.state === "flying" && live.paused ? "paused" : live.state;
  const {badge, how = "", says} = liveStates[name], {factor = 0} = live;
  Object.assign(byId("live-badge"), {textContent: badge, className: `badge ${how}`});
  byId("live-says").textContent = name === "flying" && factor ? `${fixedNumber(factor)} × real time` : says;
  const flying = live.state === "flying";
  byId("live-more").hidden = !changes.size || live.state === "ended";
  byId("live-pace").hidden = Boolean(live.refusals.pace) || live.state === "connecting" || live.state === "ended";
  byId("live-pace").disabled = byId("live-changes").disabled = !flying;
  byId("live-pause").textContent = live.paused ? "Fly on" : "Pause the flight";
  const select = byId("live-speed");
  if (live.speed === undefined || document.activeElement === select) return;
  const value = String(live.speed);
  if (![...select.options].some((each) => each.value === value))
    select.append(el("option", {value}, speedName(live.speed)));
  select.value = value;
};

// What can be asked of this flight.
const fillLive = () => {
  const why = live.refusals.pace;
  Object.assign(byId("live-only"), {hidden: !why, textContent: why ? `${why[0].toUpperCase()}${why.slice(1)}.` : ""});
  fillChanges(live.refusals.change ? [] : flight.data.changeable ?? []);
  drawLive();
};

const setUpLive = () => {
  if (!isLive) return;
  const button = (id, text, op) => el("button", {type: "button", id, onclick: () => live.say({op: op()})}, text);
  byId("live").hidden = false;
  byId("live").replaceChildren(
    el("div", {class: "live-line"}, el("span", {id: "live-badge"}), el("span", {id: "live-says"}),
      el("fieldset", {id: "live-pace", "aria-label": "Pace of the flight"},
        button("live-pause", "Pause the flight", () => (live.paused ? "resume" : "pause")),
        button("live-step", "One frame", () => "step"),
        el("label", {}, "Speed of the flight ", el("select", {id: "live-speed",
          onchange: (event) => live.say({op: "speed", value: Number(event.target.value)})},
        speeds.map((speed) => el("option", {value: speed}, speedName(speed))))))),
    el("p", {id: "live-only", class: "note", hidden: true}),
    refusalLine(),
    el("details", {id: "live-more", hidden: true}, el("summary", {}, "Change in flight"),
      el("fieldset", {id: "live-changes", "aria-label": "Changes in flight"})));
  drawLive();
  loadedFor = whichFlight(flight.data);
  if (location.host) live.connect();
  else live.become("lost");  // a copy of the page
};
