// SPDX-License-Identifier: Apache-2.0
// The page is usable before its media are there: those are long texts, which are read once it has been drawn.
let sceneView = null;

const setUpScene = (glbs) => {
  if (typeof createScene !== "function") return;
  const element = el("div", {id: "scene-view"});
  const figure = pane("scene-pane", "In space", element);
  byId("panes").append(figure);
  try {
    sceneView = createScene(element, flights, glbs);
  } catch (error) {  // a browser without WebGL
    console.info(error);
    element.replaceChildren(el("p", {class: "note"}, "This browser does not draw in three dimensions."));
    return;
  }
  if (!sceneView) return figure.remove();
  clock.onTime((t_s) => sceneView.show(t_s));
  clock.redraw();
};

const setUpMedia = () => {
  setUpVideos();
  setUpScene(["scene", "scene-b"].slice(0, flights.length).map((id) => takeBytes(id)?.buffer ?? null));
  performance.mark("media");
};

setUpVerdict();
setUpPlayer();
setUpEvents();
setUpPlots();
setUpTables();
setUpKeyboard();
setUpLive();
theme.onChange(() => {
  drawPlotsAgain();
  sceneView?.repaint();
});
performance.mark("usable");

// Media stand behind this script.
const afterPaint = (fn) => requestAnimationFrame(() => setTimeout(fn));
if (document.readyState === "loading") addEventListener("DOMContentLoaded", () => afterPaint(setUpMedia));
else afterPaint(setUpMedia);
