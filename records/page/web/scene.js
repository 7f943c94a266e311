// SPDX-License-Identifier: Apache-2.0
// A flight in three dimensions, or two: createScene(element, flights, glbs) puts it into the element. glbs: of each flight the bytes of
// its scene.glb (ArrayBuffer) or null. show(t_s): that instant; repaint(): in the colours of the theme. It draws when one of these is
// called, when the view changes or the element's size, and never else.
const kNoWebGl = "This browser cannot draw in three dimensions (WebGL), so the scene is left out. All that it shows is in the plots.";

// Software draws every sample itself, and takes the processors from a flight that is watched.
const kSoftwarePeriod_ms = 66;
const kMoving_ms = 200, kCoarse = 0.6;  // by software what moves is drawn with so many pixels for each
const contextOf = (canvas) => {
  const probe = document.createElement("canvas").getContext("webgl");
  if (!probe) return null;
  const told = probe.getExtension("WEBGL_debug_renderer_info");
  const name = told ? String(probe.getParameter(told.UNMASKED_RENDERER_WEBGL)) : "";
  probe.getExtension("WEBGL_lose_context")?.loseContext();
  const software = /swiftshader|llvmpipe|software|basic render/i.test(name);
  const wanted = {antialias: !software, alpha: true};
  const context = canvas.getContext("webgl2", wanted) ?? canvas.getContext("webgl", wanted);
  return context && {context, software};
};

const legendOf = (flights, flight) => {
  const entry = (kind, text) => el("li", {}, el("span", {class: `scene-key ${kind}`, "aria-hidden": "true"}), text);
  return el("ul", {class: "scene-legend"}, ...(flight.has("truth_x_m") ? [entry("truth", "truth")] : []),
    ...(flight.rows && !flight.has("estimate_x_m") ? [] : [entry("estimate", "autopilot’s estimate")]),
    ...(flight.has("fix_x_m") ? [entry("fix", "vision’s fix, and the pad by it")] : []),
    ...(["setpoint_vx_m_s", "setpoint_x_m"].some((name) => flight.has(name)) ? [entry("setpoint", "setpoint")] : []),
    ...(flights.length > 1 ? [entry("second", "run B")] : []));
};

class FlightScene {
  constructor(element, flights, glbs, {context, software}, canvas) {
    Object.assign(this, {element, flights, canvas, t_s: flights[0].begin_s, models: [], inSight: true, looked_rows: 0, software, rendered_ms: 0});
    this.renderer = new THREE.WebGLRenderer({canvas, context, alpha: true});
    this.renderer.setPixelRatio(software ? 1 : Math.min(window.devicePixelRatio, 2));
    this.scene = new THREE.Scene();
    this.north = new THREE.Group();  // N in what is drawn
    this.north.quaternion.copy(kTurnUp);
    this.scene.add(this.north);
    const drawn = () => this.draw();
    this.camera = new SceneCamera(canvas, flights, drawn);
    this.marks = marksOf(this.north, flights[0], drawn);
    this.paths = [];
    this.takeColumns();
    new ResizeObserver(() => this.resize()).observe(canvas);
    new IntersectionObserver(([{isIntersecting}]) => {
      this.inSight = isIntersecting;
      if (isIntersecting) this.draw();
    }).observe(canvas);
    this.camera.choose("orbit", aircraftPose(flights[0], this.t_s));
    flights.forEach((flight) => flight.onChange?.((what) => { if (what === "columns") this.takeColumns(); }));
    Promise.all(glbs.map(loadModel)).then((models) => this.setModels(models));
  }

  // What there is to show, anew when a flight that is still flown has filled further columns, or begins again.
  takeColumns() {
    this.paths.forEach(({path}) => path.remove());
    this.paths = this.flights.flatMap((flight, i) => pathsOf(this.north, flight, i > 0).map((path) => ({flight, path})));
    this.setpointVelocity = velocitySetpointInN(this.flights[0]);
    this.element.querySelector(".scene-legend")?.replaceWith(legendOf(this.flights, this.flights[0]));
    if (!this.flights[0].rows) this.looked_rows = 0;
  }

  setModels(models) {
    const [first, other] = models;
    this.models = models;
    this.scene.add(first.root);
    if (first.bare) {
      const ground = new THREE.GridHelper(40, 40, "#888888", "#aaaaaa");
      Object.assign(ground.material, {transparent: true, opacity: 0.6});
      this.scene.add(ground);
    }
    this.scene.add(lightsOf(first.extras ?? {lights: [{direction: [0.3, 0.2, -0.9], ambient: [0.55, 0.55, 0.55], diffuse: [0.5, 0.5, 0.5]}]}));
    this.sky = skyOf(first.extras?.sky, () => this.draw());
    if (this.sky) this.scene.add(this.sky);
    if (other) {
      asGhost(other.aircraft, kColours.second);
      other.holder = new THREE.Group();
      other.holder.rotation.x = -Math.PI / 2;
      other.holder.add(other.aircraft);
      this.scene.add(other.holder);
    }
    this.show(this.t_s);
    // Pictures within the file come a little later.
    for (const after_ms of [100, 500]) setTimeout(() => this.draw(), after_ms);
  }

  choose(view) {
    this.camera.held = false;
    this.camera.choose(view, aircraftPose(this.flights[0], this.t_s));
    this.show(this.t_s);
  }

  show(t_s) {
    this.t_s = t_s;
    const [flight] = this.flights;
    // A flight that is still flown is kept in sight until one turns the view by hand.
    if (flight.rows > this.looked_rows) {
      this.looked_rows = 1.1 * flight.rows + 10;
      if (this.camera.outgrown()) this.camera.choose(this.camera.view, aircraftPose(flight, t_s));
    }
    if (!this.inSight) return;
    this.flights.forEach((each, i) => this.showAircraft(each, this.models[i], t_s));
    this.paths.forEach(({flight: of, path}) => path.show(of.rowAt(t_s)));
    if (flight.rows) this.showMarks(flight, t_s);
    // What flies has the processors first.
    const soon_ms = this.software && flight.data.live ? this.rendered_ms + kSoftwarePeriod_ms - performance.now() : 0;
    if (soon_ms > 0) return this.drawIn(soon_ms);
    this.render();
  }

  showAircraft(flight, model, t_s) {
    if (!model || !flight.rows) return;
    const row = flight.rowAt(t_s);
    placeNode(model.aircraft, aircraftPose(flight, t_s));
    if (!flight.value("landed", row)) turnRotors(model.rotors, t_s);
    if (flight !== this.flights[0]) return;
    if (flight.has("deck_x_m")) placeNode(model.pad, padPose(flight, t_s));
    for (let i = 0; flight.has(`truth_target${i}_x_m`); ++i) {
      const target = model.targets[i] ?? this.ballInPlace(model, i);
      const p = between(flight, (at) => positionIn(flight, `truth_target${i}`, at), t_s);
      target.visible = Boolean(p);
      if (p) target.position.set(p.x, -p.y, -p.z);
    }
  }
  ballInPlace(model, i) {
    const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.25, 16, 12), new THREE.MeshLambertMaterial({color: "#d91a1a"}));
    model.top.children[0]?.parent.add(ball);
    return model.targets[i] = ball;
  }

  showMarks(flight, t_s) {
    const {marks, camera} = this, row = flight.rowAt(t_s);
    const pose = aircraftPose(flight, t_s), pad = padPose(flight, t_s);
    camera.follow(pose, flight.data.camera);
    const onBoard = camera.view === "board";
    place(marks.body, pose);
    place(marks.padT, pad);
    if (!pose) return;
    const away_m = camera.eye.position.distanceTo(toUp(pose.p));
    const ground_m = Math.max(pad && Math.abs(pad.p.x - pose.p.x) < 1 && Math.abs(pad.p.y - pose.p.y) < 1 ? -pad.p.z : 0, 0);
    const height_m = -pose.p.z - ground_m;
    if (marks.frustum) {
      marks.frustum.visible = !onBoard;
      marks.frustum.scale.setScalar(Math.min(Math.max(0.5 * height_m, 0.6), Math.max(2, 0.25 * away_m)));
    }
    if (marks.plate) marks.plate.visible = this.models[0]?.bare ?? true;
    if (marks.seen) place(marks.seen, seenPad(flight, row));
    this.showArrows(flight, row, pose, away_m);
    marks.shadow.visible = marks.down.visible = !onBoard && height_m > 0.05;
    marks.shadow.position.set(pose.p.x, pose.p.y, -ground_m - 0.02);
    marks.down.position.copy(pose.p);
    marks.down.scale.z = Math.max(height_m, 1e-3);
    marks.ring.visible = !onBoard && away_m > 25;
    marks.ring.position.copy(pose.p);
  }

  showArrows(flight, row, pose, away_m) {
    const {marks} = this, size = Math.max(away_m / 7, 0.3);
    const hidden = this.camera.view === "board";
    const wind = ["n", "e", "d"].map((axis) => flight.value(`wind_${axis}_m_s`, row));
    const blows = hidden || wind.includes(null) ? null : new THREE.Vector3(...wind).multiplyScalar(0.15 * size);
    // It ends beside the aircraft.
    const from = blows && pose.p.clone().sub(blows).sub(blows.clone().normalize().multiplyScalar(0.4 * Math.sqrt(size)));
    pointArrow(marks.wind, from, blows, size);
    const velocity = hidden ? null : arrayAsPlace(this.setpointVelocity?.(row));
    pointArrow(marks.setpoint, pose.p, velocity?.multiplyScalar(0.6 * size), 0.7 * size);
    const wanted = positionIn(flight, "setpoint", row);
    marks.place.visible = Boolean(wanted) && !hidden;
    if (wanted) marks.place.position.copy(wanted);
    marks.place.scale.setScalar(size);
  }

  resize() {
    const {clientWidth, clientHeight} = this.canvas;
    if (!clientWidth || !clientHeight) return;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.eye.aspect = clientWidth / clientHeight;
    this.camera.eye.updateProjectionMatrix();
    if (!this.camera.held) this.camera.choose(this.camera.view, aircraftPose(this.flights[0], this.t_s));
    this.show(this.t_s);
  }

  repaint() {
    this.paths.forEach(({path}) => path.repaint());
    this.marks.ring.material.color.set(truthColour());
    this.draw();
  }

  // By software it is coarser while it moves.
  sharpen() {
    const moves = performance.now() - this.rendered_ms < kMoving_ms, ratio = moves ? kCoarse : 1;
    if (this.renderer.getPixelRatio() !== ratio) this.renderer.setPixelRatio(ratio);
    clearTimeout(this.still);
    if (moves) this.still = setTimeout(() => this.draw(), kMoving_ms);
  }

  render() {
    if (this.software) this.sharpen();
    if (this.sky) this.sky.position.copy(this.camera.eye.position);
    this.renderer.render(this.scene, this.camera.eye);
    this.rendered_ms = performance.now();
    ++this.drawings;
  }
  drawings = 0;  // for who measures

  drawIn(wait_ms) {
    this.later ??= setTimeout(() => {
      this.later = null;
      this.draw();
    }, wait_ms);
  }
  // With the next picture of the window, once.
  draw() {
    if (this.due) return;
    this.due = true;
    requestAnimationFrame(() => {
      this.due = false;
      this.show(this.t_s);
    });
  }
}

const createScene = (element, flights, glbs) => {
  const canvas = el("canvas", {class: "scene-canvas", role: "img",
    "aria-label": "The flight in three dimensions: the world, the aircraft, its path, where its camera looks, the wind"});
  const drawing = typeof THREE === "undefined" ? null : contextOf(canvas);
  if (!drawing) {
    element.replaceChildren(el("p", {class: "note"}, kNoWebGl));
    return {show() {}, repaint() {}};
  }
  const buttons = Object.entries(sceneViews).filter(([view]) => view !== "board" || flights[0].data.camera)
    .map(([view, text]) => el("button", {type: "button", "data-view": view, "aria-pressed": String(view === "orbit")}, text));
  element.replaceChildren(el("div", {class: "scene-views", role: "group", "aria-label": "View of the scene"}, buttons), canvas,
    legendOf(flights, flights[0]));
  const scene = new FlightScene(element, flights, glbs, drawing, canvas);
  for (const button of buttons) {
    button.addEventListener("click", () => {
      buttons.forEach((each) => each.setAttribute("aria-pressed", String(each === button)));
      scene.choose(button.dataset.view);
    });
  }
  return scene;
};
