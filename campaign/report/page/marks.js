// SPDX-License-Identifier: Apache-2.0
// Of a run, wherever it is named.
const badge = (status) => el("span", {class: `badge ${status === "passed" ? "passed" : ""}`}, status);
const rowButton = (row) =>
  el("button", {type: "button", class: "link", onclick: () => showRun(row)}, `run ${row}`);
const videoOf = (run) => (run.video
  // Without a time in its address a video is a black box until it is played.
  ? el("video", {controls: true, preload: "metadata", src: `${run.video}#t=0.05`, title: `Run ${run.row}`})
  : null);
