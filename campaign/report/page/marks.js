// SPDX-License-Identifier: Apache-2.0
// Of a run, wherever it is named.
const badge = (status) => el("span", {class: `badge ${status === "passed" ? "passed" : ""}`}, status);
const rowButton = (row) =>
  el("button", {type: "button", class: "link", onclick: () => showRun(row)}, `run ${row}`);
const videoOf = (run) => (run.video
  ? el("video", {controls: true, preload: "metadata", src: run.video, title: `Run ${run.row}`})
  : null);
