// SPDX-License-Identifier: Apache-2.0
// What scene.glb holds (sim/gltf/scene_glb.h), drawn as MuJoCo draws it: colours as they are in the pictures, times the sum of the lights.
const kRotorTurns_per_s = 4;  // as it is seen; true ones are a blur
const kSkyRadius_m = 150e3;

const likeMuJoCo = (material) => {
  const shown = (texture) => {
    if (texture) texture.encoding = THREE.LinearEncoding;
    return texture;
  };
  const properties = {
    color: material.color.clone().convertLinearToSRGB(), map: shown(material.map), side: material.side,
    transparent: material.transparent, opacity: material.opacity, depthWrite: !material.transparent,
  };
  if (material.isMeshBasicMaterial) return new THREE.MeshBasicMaterial(properties);
  return new THREE.MeshLambertMaterial({...properties, emissive: material.emissive.clone().convertLinearToSRGB(),
    emissiveMap: shown(material.emissiveMap)});
};

const lightsOf = (extras) => {
  const group = new THREE.Group();
  const ambient = new THREE.Color(0, 0, 0);
  for (const light of extras?.lights ?? []) {
    ambient.add(new THREE.Color(...light.ambient));
    const sun = new THREE.DirectionalLight(new THREE.Color(...light.diffuse));
    const [x, y, z] = light.direction;  // in M, in which it shines
    sun.position.set(-x, -z, y);
    group.add(sun);
  }
  group.add(new THREE.AmbientLight(ambient));
  return group;
};

const skyOf = (url, drawn) => {
  if (!url) return null;
  const ball = new THREE.SphereBufferGeometry(kSkyRadius_m, 32, 24);
  ball.scale(-1, 1, 1);  // seen from inside; its columns then go from north by east
  const map = new THREE.TextureLoader().load(url, drawn);
  map.wrapS = THREE.RepeatWrapping;
  map.offset.x = 0.5;
  const sky = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({map, depthWrite: false, depthTest: false}));
  sky.renderOrder = -1;
  sky.frustumCulled = false;
  return sky;
};

// Of a flight without a file: something to look at in its place.
const schematicAircraft = () => {
  const aircraft = new THREE.Group();
  const paint = (color) => new THREE.MeshLambertMaterial({color});
  const add = (parent, geometry, material, x, y, z) => {
    const mesh = new THREE.Mesh(geometry, material);
    mesh.position.set(x, y, z);
    parent.add(mesh);
  };
  const dark = paint("#333333"), orange = paint("#d98a20");
  add(aircraft, new THREE.BoxBufferGeometry(0.15, 0.12, 0.06), dark, 0, 0, 0);
  add(aircraft, new THREE.BoxBufferGeometry(0.44, 0.02, 0.012), dark, 0, 0, 0.01);
  add(aircraft, new THREE.BoxBufferGeometry(0.02, 0.44, 0.012), dark, 0, 0, 0.01);
  add(aircraft, new THREE.BoxBufferGeometry(0.05, 0.03, 0.02), orange, 0.17, 0, 0.01);
  [[0.21, 0], [0, -0.21], [-0.21, 0], [0, 0.21]].forEach(([x, y], i) => {
    const rotor = new THREE.Group();
    rotor.name = `rotor_${i}`;
    rotor.position.set(x, y, 0.05);
    rotor.userData = {axis: [0, 0, 1], spin: i % 2 ? 1 : -1};
    add(rotor, new THREE.BoxBufferGeometry(0.25, 0.016, 0.004), dark, 0, 0, 0);
    aircraft.add(rotor);
  });
  return aircraft;
};

// {root, world, aircraft, pad, targets, rotors, bare}; root is to be added to a scene whose y is up. bare: there was no file.
const modelOf = (gltf) => {
  const root = gltf?.scene ?? new THREE.Group();
  const bare = !gltf;
  let top = root;
  if (bare) {
    top = new THREE.Group();
    top.rotation.x = -Math.PI / 2;
    root.add(top);
    top.add(Object.assign(schematicAircraft(), {name: "aircraft"}));
  }
  root.traverse((object) => {
    if (object.isMesh) object.material = likeMuJoCo(object.material);
  });
  const named = (name) => root.getObjectByName(name) ?? null;
  const targets = [];
  for (let i = 0; named(`target_${i}`); ++i) targets.push(named(`target_${i}`));
  const rotors = [];
  root.traverse((object) => {
    if (/^rotor_\d+$/.test(object.name)) rotors.push(object);
  });
  const extras = root.children.map(({userData}) => userData).find(({lights}) => lights);
  return {root, top, bare, extras, world: named("world"), aircraft: named("aircraft"), pad: named("pad"), targets, rotors};
};

// To where they are at this time of the flight.
const turnRotors = (rotors, t_s) => {
  for (const rotor of rotors) {
    const {axis, spin} = rotor.userData;
    rotor.quaternion.setFromAxisAngle(new THREE.Vector3(...axis), spin * 2 * Math.PI * ((kRotorTurns_per_s * t_s) % 1));
  }
};

// In one colour, and one sees through it.
const asGhost = (object, color) => {
  object.traverse((each) => {
    if (each.isMesh) each.material = new THREE.MeshLambertMaterial({color, transparent: true, opacity: 0.75});
  });
};

const loadModel = (bytes) => new Promise((resolve) => {
  if (!bytes) return resolve(modelOf(null));
  new THREE.GLTFLoader().parse(bytes, "", (gltf) => resolve(modelOf(gltf)), (error) => {
    console.info(error);
    resolve(modelOf(null));
  });
});
