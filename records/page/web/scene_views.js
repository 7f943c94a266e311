// SPDX-License-Identifier: Apache-2.0
// From where the scene is seen. In the coordinates of three.js: x north, y up, z east.
const toUp = ({x, y, z}) => new THREE.Vector3(x, -z, y);
const kTurnUp = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2);
const kLookAhead = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI);  // C to three's camera
const kFov_deg = 45;

const sceneViews = {orbit: "Orbit", chase: "Chase", top: "Top", board: "On board"};

class SceneCamera {
  // changed(): it is to be drawn again.
  constructor(canvas, flights, changed) {
    Object.assign(this, {flights, view: "orbit", yaw: null, at: null});
    this.eye = new THREE.PerspectiveCamera(kFov_deg, 1, 0.1, 1000);
    this.controls = new THREE.OrbitControls(this.eye, canvas);
    Object.assign(this.controls, {enableKeys: false, maxPolarAngle: 0.5 * Math.PI, minDistance: 0.3, maxDistance: 20e3,
      enableZoom: false});
    this.controls.addEventListener("change", changed);
    this.controls.addEventListener("start", () => { this.held = true; });
    // The wheel scrolls the page until one takes hold of the scene.
    canvas.addEventListener("pointerdown", () => { this.controls.enableZoom = true; });
    canvas.addEventListener("pointerleave", () => { this.controls.enableZoom = false; });
  }

  // The ball in which all of the flights takes place.
  ball() {
    const places = this.flights.flatMap((flight) => {
      const some = Math.max(1, Math.floor(flight.rows / 400)), found = [];
      for (let row = 0; row < flight.rows; row += some)
        found.push(positionIn(flight, "truth", row) ?? positionIn(flight, "estimate", row));
      return [...found, padPose(flight, flight.begin_s)?.p, groundCameraPose(flight)?.p];
    });
    const box = new THREE.Box3().setFromPoints(places.filter(Boolean).map(toUp));
    if (box.isEmpty()) box.set(new THREE.Vector3(-3, 0, -3), new THREE.Vector3(3, 4, 3));
    const ball = box.getBoundingSphere(new THREE.Sphere());
    ball.radius = Math.max(ball.radius, 1.5);
    return ball;
  }

  // Whether the flights go on where the view does not reach, and nobody has turned it by hand.
  outgrown() { return !this.held && ["orbit", "top"].includes(this.view) && this.ball().radius > 1.1 * this.radius; }

  choose(view, pose) {
    this.view = view;
    this.yaw = this.at = null;
    this.eye.up.set(0, 1, 0);
    this.eye.fov = kFov_deg;
    this.controls.enabled = view !== "board";
    this.controls.enableRotate = view !== "top";
    const {center, radius} = this.ball();
    this.radius = radius;
    const distance = 1.1 * radius / Math.sin(kFov_deg * kDegree / 2) / Math.min(1, this.eye.aspect);
    this.controls.target.copy(center);
    if (view === "top") this.eye.position.copy(center).add(new THREE.Vector3(-1e-3 * distance, distance, 0));
    else this.eye.position.copy(center).add(new THREE.Vector3(-0.72, 0.42, 0.55).normalize().multiplyScalar(distance));
    if (view === "chase" && pose) {
      this.controls.target.copy(toUp(pose.p));
      this.eye.position.copy(this.controls.target).add(new THREE.Vector3(-2.4, 1.0, 0));
      this.yaw = 0;
    }
    this.follow(pose);
  }

  // To where the aircraft is: {p, q} in N.
  follow(pose, camera) {
    if (this.view === "board") this.look(pose, camera);
    if (this.view === "chase" && pose) {
      const at = toUp(pose.p), ahead = new THREE.Vector3(1, 0, 0).applyQuaternion(pose.q);
      const yaw = Math.atan2(ahead.y, ahead.x);
      const offset = this.eye.position.clone().sub(this.controls.target)
        .applyAxisAngle(new THREE.Vector3(0, 1, 0), -(yaw - (this.yaw ?? yaw)));
      this.yaw = yaw;
      this.controls.target.copy(at);
      this.eye.position.copy(at).add(offset);
    }
    if (this.view !== "board") this.controls.update();
    const far = this.view === "board" ? 2 : this.eye.position.distanceTo(this.controls.target);
    this.eye.near = Math.min(Math.max(0.02 * far, 0.02), 10);
    this.eye.far = 3e5;
    this.eye.updateProjectionMatrix();
  }

  // As the camera on board does, as far as a flat picture can.
  look(pose, camera) {
    if (!pose || !camera) return;
    const X_BC = poseOf(camera.X_BC);
    this.eye.position.copy(toUp(X_BC.p.applyQuaternion(pose.q).add(pose.p)));
    this.eye.quaternion.copy(kTurnUp).multiply(pose.q).multiply(X_BC.q).multiply(kLookAhead);
    const [h, v] = camera.fov_deg.map((deg) => Math.tan(Math.min(deg, 110) * kDegree / 2));
    this.eye.fov = 2 * Math.atan(Math.max(v, h / this.eye.aspect)) / kDegree;
  }

  // Of one pixel at this place, m.
  scaleAt(place, height_px) {
    return 2 * Math.tan(this.eye.fov * kDegree / 2) * this.eye.position.distanceTo(place) / height_px;
  }
}
