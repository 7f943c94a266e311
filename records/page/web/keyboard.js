// SPDX-License-Identifier: Apache-2.0
// What keys do. Where one writes or chooses they are left to that.
const keys = [
  [[" "], "Space", "play, pause", () => clock.toggle()],
  [["ArrowLeft"], "←", "1 s back, with Shift 10 s", ({shiftKey}) => clock.seek(clock.t_s - (shiftKey ? 10 : 1))],
  [["ArrowRight"], "→", "1 s on, with Shift 10 s", ({shiftKey}) => clock.seek(clock.t_s + (shiftKey ? 10 : 1))],
  [[","], ",", "a frame back", () => clock.step(-1)],
  [["."], ".", "a frame on", () => clock.step(1)],
  [["p"], "p", "to the event before", () => jumpToEvent(-1)],
  [["n"], "n", "to the next event", () => jumpToEvent(1)],
  [["Home"], "Home", "to the beginning", () => clock.seek(clock.begin_s)],
  [["End"], "End", "to the end", () => clock.seek(clock.end_s)],
  [[..."0123456789"], "0 … 9", "to so many tenths of it", ({key}) =>
    clock.seek(clock.begin_s + (clock.end_s - clock.begin_s) * Number(key) / 10)],
  [["-"], "−", "slower", () => clock.changeRate(-1)],
  [["+", "="], "+", "faster", () => clock.changeRate(1)],
  [["t"], "t", "light, dark", () => theme.toggle()],
];

const setUpKeyboard = () => {
  byId("keys").replaceChildren(...keys.map(([, name, meaning]) => el("div", {}, el("dt", {}, el("kbd", {}, name)), el("dd", {}, meaning))));
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const {target} = event, isTime = target === byId("time");
    if (target.closest("input, select, textarea, [contenteditable]") && !isTime && target.type !== "checkbox") return;
    if (event.key === " " && target.closest("button, summary, a, input[type=checkbox]")) return;
    const known = keys.find(([names]) => names.includes(event.key));
    if (!known) return;
    event.preventDefault();
    known[3](event);
  });
};
