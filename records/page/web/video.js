// SPDX-License-Identifier: Apache-2.0
// The videos of the flights, by the clock. Frame i of a video shows row i of its flight.
const videoOfFlight = (element, of) => {
  const first_s = of.begin_s, half_s = of.step_s / 2;
  let wanted_s = null;
  const timeOf = (t_s) => {
    const last = (element.duration || Infinity) - half_s;
    return Math.min(Math.max(clock.playing ? t_s - first_s + half_s : of.rowAt(t_s) * of.step_s + half_s, half_s), last);
  };
  // One search at a time: while it searches only the newest wish is kept.
  const search = (to_s) => {
    if (element.seeking) { wanted_s = to_s; return; }
    wanted_s = null;
    if (Math.abs(element.currentTime - to_s) > 1e-4) element.currentTime = to_s;
  };
  element.addEventListener("seeked", () => { if (wanted_s !== null) search(wanted_s); });
  element.addEventListener("loadedmetadata", () => search(timeOf(clock.t_s)));
  return {
    show(t_s) {
      if (!element.readyState) return;
      const runs = clock.playing && t_s - first_s < element.duration - half_s;
      if (runs) {
        element.playbackRate = clock.rate;
        if (element.paused) element.play().catch(() => {});
        // It runs by itself; only where it has drifted it is set.
        if (Math.abs(element.currentTime - timeOf(t_s)) < Math.max(0.12, 0.15 * clock.rate)) return;
      } else if (!element.paused) {
        element.pause();
      }
      search(timeOf(t_s));
    },
  };
};

// The bytes of a script element of base64 text; null: there is none. The text is let go.
const takeBytes = (id) => {
  const element = byId(id);
  if (!element) return null;
  const text = atob(element.textContent.trim());
  element.remove();
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
};

const pane = (id, title, ...content) =>
  el("figure", {class: "pane", id}, el("figcaption", {}, title), ...content);
const panes = {
  video: {title: "On board", media: "video"},
  view: {title: "From outside", media: "view"},
};
const movingPictures = [];

const addVideo = (name, of) => {
  const bytes = takeBytes(panes[name].media + (of === second ? "-b" : ""));
  if (!bytes) return;
  const element = el("video", {muted: true, playsinline: true, preload: "auto", tabindex: -1,
    "aria-label": `${panes[name].title}${second ? `, run ${of.letter}` : ""}`});
  element.muted = true;
  element.src = URL.createObjectURL(new Blob([bytes], {type: "video/mp4"}));
  const of_b = of === second;
  byId("panes").append(pane(`${name}-pane${of_b ? "-b" : ""}`,
    panes[name].title + (second ? `, run ${of.letter}` : ""), element));
  element.addEventListener("click", clock.toggle);
  movingPictures.push(videoOfFlight(element, of));
};
const setUpVideos = () => {
  for (const name of Object.keys(panes)) for (const of of flights) addVideo(name, of);
  clock.onTime((t_s) => movingPictures.forEach((each) => each.show(t_s)));
  clock.onChange(() => movingPictures.forEach((each) => each.show(clock.t_s)));
};
