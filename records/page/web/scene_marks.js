// SPDX-License-Identifier: Apache-2.0
// What is drawn into the scene that is no thing: where the camera looks, the wind, the pad as vision has it, setpoints. All in N.
const kAround = 48;

const plainColour = (color, more = {}) => new THREE.MeshBasicMaterial({color, ...more});
const lineOf = (places, color, more = {}) => new THREE.LineSegments(
  new THREE.BufferGeometry().setFromPoints(places), new THREE.LineBasicMaterial({color, ...more}));

// Of a camera in its own frame C (x right, y down, z ahead), one metre long.
const frustumOf = (camera) => {
  const [h, v] = camera.fov_deg.map((deg) => deg * kDegree / 2);
  const rim = [], tip = new THREE.Vector3();
  const round = !/pinhole|brown|perspective/i.test(camera.projection) || h > 1.3;
  const spokes = [];
  if (round) {
    for (let i = 0; i < kAround; ++i) {
      const a = 2 * Math.PI * i / kAround, c = Math.cos(a), s = Math.sin(a);
      const off = h * v / Math.hypot(v * c, h * s);  // an ellipse in angle
      rim.push(new THREE.Vector3(Math.sin(off) * c, Math.sin(off) * s, Math.cos(off)));
      if (i % (kAround / 8) === 0) spokes.push(rim[i]);
    }
  } else {
    const [x, y] = [Math.tan(h), Math.tan(v)];
    for (const [sx, sy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) rim.push(new THREE.Vector3(sx * x, sy * y, 1));
    spokes.push(...rim);
  }
  const edges = spokes.flatMap((place) => [tip, place]);
  rim.forEach((place, i) => edges.push(place, rim[(i + 1) % rim.length]));
  const sides = rim.flatMap((place, i) => [tip, place, rim[(i + 1) % rim.length]]);
  const group = new THREE.Group();
  const shape = new THREE.BufferGeometry().setFromPoints(sides);
  group.add(lineOf(edges, kColours.fix, {transparent: true, opacity: 0.9}));
  group.add(new THREE.Mesh(shape, plainColour(kColours.fix,
    {transparent: true, opacity: 0.12, side: THREE.DoubleSide, depthWrite: false})));
  // Above the picture.
  const top = round ? rim[3 * kAround / 4] : new THREE.Vector3(0, rim[0].y, 1);
  group.add(lineOf([top, new THREE.Vector3(top.x, top.y - 0.12, top.z)], kColours.fix));
  return group;
};

// A camera on the ground, at a pose in N, with a mast down to the ground and where it looks with its head at rest.
const mastOf = (camera, pose, ground_m) => {
  const mast = new THREE.Group(), view = frustumOf(camera);
  place(view, pose);
  view.scale.setScalar(Math.hypot(...camera.X_TC.p) / 4);
  const height_m = Math.max(ground_m - pose.p.z, 0.01);
  const pole = new THREE.Mesh(new THREE.CylinderBufferGeometry(0.06, 0.06, height_m, 12).rotateX(Math.PI / 2), plainColour("#555555"));
  pole.position.copy(pose.p).setZ(pose.p.z + height_m / 2);
  return mast.add(view, pole);
};

// A frame round a pad of this size, in T, a little above it.
const outlineOf = (size_m, color) => {
  const [x, y] = size_m.map((each) => each / 2), edge = 0.04 * Math.max(...size_m);
  const shape = new THREE.Shape([[-x, -y], [x, -y], [x, y], [-x, y]].map((p) => new THREE.Vector2(...p)));
  shape.holes.push(new THREE.Path([[-x + edge, -y + edge], [-x + edge, y - edge], [x - edge, y - edge],
    [x - edge, -y + edge]].map((p) => new THREE.Vector2(...p))));
  const outline = new THREE.Mesh(new THREE.ShapeBufferGeometry(shape),
    plainColour(color, {side: THREE.DoubleSide, depthTest: false, transparent: true, opacity: 0.95}));
  outline.renderOrder = 5;
  return outline;
};

// The pad as a plate with its picture, where no file has it. In T: its picture's up is x, its right y.
const plateOf = (pad, drawn) => {
  const plate = new THREE.PlaneBufferGeometry(pad.size_m[1], pad.size_m[0]);  // right along x, up along y, seen from z
  plate.applyMatrix(new THREE.Matrix4().set(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1));
  const map = pad.picture ? new THREE.TextureLoader().load(pad.picture, drawn) : null;
  return new THREE.Mesh(plate, plainColour(map ? "#ffffff" : "#999999", {map, side: THREE.DoubleSide}));
};

// From the origin along z, one metre long.
const arrowOf = (color) => {
  const arrow = new THREE.Group();
  const shaft = new THREE.CylinderBufferGeometry(0.025, 0.025, 0.75, 8), tip = new THREE.ConeBufferGeometry(0.08, 0.25, 12);
  const material = plainColour(color);
  for (const [shape, middle] of [[shaft, 0.375], [tip, 0.875]]) {
    shape.rotateX(Math.PI / 2).translate(0, 0, middle);
    arrow.add(new THREE.Mesh(shape, material));
  }
  return arrow;
};
// along: its direction and length; null: it is not shown.
const pointArrow = (arrow, from, along, width_m) => {
  const length = along?.length() ?? 0;
  arrow.visible = length > 1e-3;
  if (!arrow.visible) return;
  arrow.position.copy(from);
  arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), along.clone().normalize());
  arrow.scale.set(width_m, width_m, length);
};

// A dark round spot under the aircraft, and a line down to it, without which nobody sees how high it is.
const shadowOf = (radius_m) => {
  const spot = new THREE.Mesh(new THREE.CircleBufferGeometry(radius_m, 32),
    plainColour("#000000", {transparent: true, opacity: 0.35, side: THREE.DoubleSide, depthWrite: false}));
  spot.rotation.x = Math.PI;
  return spot;
};

// A ring of a size on the screen, round what is too small to be seen.
const ringOf = (color) => {
  const canvas = el("canvas", {width: 64, height: 64}), pen = canvas.getContext("2d");
  pen.lineWidth = 6;
  pen.strokeStyle = "#ffffff";
  pen.arc(32, 32, 26, 0, 2 * Math.PI);
  pen.stroke();
  const ring = new THREE.Sprite(new THREE.SpriteMaterial({map: new THREE.CanvasTexture(canvas), color,
    sizeAttenuation: false, depthTest: false, transparent: true}));
  ring.scale.setScalar(0.05);
  ring.renderOrder = 6;
  return ring;
};

// Of the first flight: all that is beside the world itself.
const marksOf = (north, flight, drawn) => {
  const add = (object, parent = north) => {
    object.visible = false;
    parent.add(object);
    return object;
  };
  const {camera, pad} = flight.data;
  const marks = {
    body: add(new THREE.Group()), padT: add(new THREE.Group()),
    wind: add(arrowOf("#56B4E9")), setpoint: add(arrowOf(kColours.setpoint)),
    place: add(new THREE.Mesh(new THREE.OctahedronBufferGeometry(0.12), plainColour(kColours.setpoint))),
    shadow: add(shadowOf(0.3)), ring: add(ringOf(truthColour())),
    down: add(lineOf([new THREE.Vector3(), new THREE.Vector3(0, 0, 1)], "#000000", {transparent: true, opacity: 0.35})),
  };
  if (camera) {
    const mount = new THREE.Group();
    place(mount, poseOf(camera.X_BC));
    marks.body.add(mount);
    mount.add(marks.frustum = frustumOf(camera));
  }
  const mast = groundCameraPose(flight);
  if (mast) {
    marks.mast = add(mastOf(flight.data.ground_camera, mast, padPose(flight, flight.begin_s)?.p.z ?? 0));
    marks.mast.visible = true;
  }
  if (pad) {
    marks.plate = add(plateOf(pad, drawn), marks.padT);
    marks.seen = add(outlineOf(pad.size_m, kColours.fix), marks.padT);
  }
  return marks;
};
