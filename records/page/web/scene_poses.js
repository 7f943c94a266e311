// SPDX-License-Identifier: Apache-2.0
// Where things are in space. Everything here is in N (north, east, down, m) and in the frames of the telemetry, as three.js's vectors
// and quaternions; only the scene itself turns N into what three.js draws, whose y is up.
const kColours = {estimate: "#0072B2", fix: "#E69F00", setpoint: "#009E73", second: "#CC79A7"};
const truthColour = () => (theme.dark ? "#eeeeee" : "#222222");
const kDegree = Math.PI / 180;

const quaternionOf = (yaw_deg, pitch_deg, roll_deg) =>
  new THREE.Quaternion().setFromEuler(new THREE.Euler(roll_deg * kDegree, pitch_deg * kDegree, yaw_deg * kDegree, "ZYX"));
// Of {p, q} with q as w, x, y, z.
const poseOf = ({p, q}) => ({p: new THREE.Vector3(...p), q: new THREE.Quaternion(q[1], q[2], q[3], q[0])});

const positionIn = (flight, name, row) => {
  const v = ["x", "y", "z"].map((axis) => flight.value(`${name}_${axis}_m`, row));
  return v.includes(null) ? null : new THREE.Vector3(...v);
};
const poseIn = (flight, name, row) => {
  const p = positionIn(flight, name, row);
  const angles = ["yaw", "pitch", "roll"].map((angle) => flight.value(`${name}_${angle}_deg`, row));
  return p && !angles.includes(null) ? {p, q: quaternionOf(...angles)} : null;
};

// Between two rows; null: it is not known there.
const between = (flight, of, t_s) => {
  const row = flight.rowAt(t_s), here = of(row), next = row + 1 < flight.rows ? of(row + 1) : null;
  if (!here || !next) return here;
  const [t, t_next] = [flight.value("t_s", row), flight.value("t_s", row + 1)];
  const share = Math.min(Math.max((t_s - t) / (t_next - t), 0), 1);
  return here.isVector3 ? here.lerp(next, share) : {p: here.p.lerp(next.p, share), q: here.q.slerp(next.q, share)};
};

// Of the aircraft: the truth, where there is one.
const aircraftPose = (flight, t_s) =>
  between(flight, (row) => poseIn(flight, "truth", row) ?? poseIn(flight, "estimate", row), t_s);
// Of the pad, X_NT: what the deck's columns tell, or where it has been from the beginning.
const padPose = (flight, t_s) => between(flight, (row) => poseIn(flight, "deck", row), t_s)
  ?? (flight.data.pad?.X_NT ? poseOf(flight.data.pad.X_NT) : null);

// Of a camera on the ground, X_NC, where the flight takes it to be; null: there is none.
const groundCameraPose = ({data: {ground_camera, pad}}) => {
  if (!ground_camera) return null;
  const {p, q} = poseOf(ground_camera.X_TC), X_NT = pad?.X_NT ? poseOf(pad.X_NT) : null;
  return X_NT ? {p: p.applyQuaternion(X_NT.q).add(X_NT.p), q: X_NT.q.multiply(q)} : {p, q};
};

// Where vision takes the pad to be, in the frame of where it is: from the fix and from the truth of the same instant.
const seenPad = (flight, row) => {
  const fix = positionIn(flight, "fix", row), truth = positionIn(flight, "target", row);
  if (!fix || !truth) return null;
  const turn = flight.value("target_yaw_deg", row) - (flight.value("fix_yaw_deg", row) ?? flight.value("target_yaw_deg", row));
  const q = quaternionOf(turn, 0, 0);
  return {p: truth.sub(fix.applyQuaternion(q)), q};
};

const place = (object, pose) => {
  object.visible = Boolean(pose);
  if (!pose) return;
  object.position.copy(pose.p);
  object.quaternion.copy(pose.q);
};
// The same for a node of scene.glb, whose axes are north, west, up, and forward, left, up: half a turn about x from ours.
const placeNode = (node, pose) => {
  if (!node || !pose) return;
  node.position.set(pose.p.x, -pose.p.y, -pose.p.z);
  node.quaternion.set(pose.q.x, -pose.q.y, -pose.q.z, pose.q.w);
};
