// SPDX-License-Identifier: Apache-2.0
// The one time of the page, by which everything is shown.
const clock = {
  t_s: 0, begin_s: 0, end_s: 0, playing: false,
  rate: 1,  // seconds of the flight in one second
  following: isLive,  // the newest row of a flight that is still flown
  rates: [0.1, 0.25, 0.5, 1, 2, 4, 8],
  listeners: [], changed: [],

  // fn(t_s) with the next picture of the window, after each change of time.
  onTime(fn) { clock.listeners.push(fn); },
  // fn() after play, pause, another rate, another end.
  onChange(fn) { clock.changed.push(fn); },

  seek(t_s) {
    clock.following = flight.data.live && t_s >= clock.end_s;
    clock.t_s = Math.min(Math.max(t_s, clock.begin_s), clock.end_s);
    clock.redraw();
  },
  // By so many rows, to the instant of a row.
  step(n) {
    clock.pause();
    const row = flight.rowAt(clock.t_s) + n;
    clock.seek(flight.columns.t_s?.[Math.min(Math.max(row, 0), flight.rows - 1)] ?? 0);
  },
  play() {
    if (clock.playing || !flight.rows) return;
    if (clock.t_s >= clock.end_s && !flight.data.live) clock.seek(clock.begin_s);
    clock.playing = true;
    clock.last_ms = undefined;
    requestAnimationFrame(clock.advance);
    clock.tell();
  },
  pause() {
    clock.following = false;
    clock.playing = false;
    clock.tell();
  },
  toggle() { clock.playing || clock.following ? clock.pause() : clock.play(); },
  follow() {
    clock.playing = false;
    clock.following = flight.data.live;
    clock.seek(clock.end_s);
    clock.tell();
  },
  setRate(rate) {
    clock.rate = rate;
    clock.tell();
  },
  // To the next rate of the list, up or down.
  changeRate(by) {
    const at = clock.rates.indexOf(clock.rate);
    clock.setRate(clock.rates[Math.min(Math.max(at + by, 0), clock.rates.length - 1)]);
  },

  // The span of all flights; a flight that is flown goes on.
  span() {
    const flown = flights.filter(({rows}) => rows);
    const known = clock.end_s > clock.begin_s;
    clock.begin_s = Math.min(...flown.map((each) => each.begin_s), Infinity);
    if (!flown.length) clock.begin_s = 0;
    clock.end_s = Math.max(...flown.map((each) => each.end_s), clock.begin_s);
    if (clock.following) clock.t_s = clock.end_s;
    else if (!known) clock.t_s = clock.begin_s;
    clock.redraw();
    clock.tell();
  },

  advance(now_ms) {
    if (!clock.playing) return;
    const passed_s = (now_ms - (clock.last_ms ?? now_ms)) / 1000;
    clock.last_ms = now_ms;
    clock.t_s = Math.min(clock.t_s + passed_s * clock.rate, clock.end_s);
    clock.show();
    if (clock.t_s < clock.end_s) return requestAnimationFrame(clock.advance);
    clock.playing = false;
    clock.following = flight.data.live;
    clock.tell();
  },
  // However often the time is set, it is shown once for each picture of the window.
  redraw() {
    if (clock.due) return;
    clock.due = true;
    requestAnimationFrame(() => {
      clock.due = false;
      clock.show();
    });
  },
  show() { clock.listeners.forEach((fn) => fn(clock.t_s)); },
  tell() { clock.changed.forEach((fn) => fn()); },
};
