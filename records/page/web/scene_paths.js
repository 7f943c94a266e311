// SPDX-License-Identifier: Apache-2.0
// Paths and points in N that are strong up to now and faint after, and that grow with the rows of a flight.
const kFaint = 0.3;
const kApart_m = 0.1;  // of points, so that a line behind them is in sight

class GrowingPath {
  // of(row): a place or null. options: {color(), dashed, points: size in pixels}
  constructor(parent, flight, of, {color, dashed = false, points = 0}) {
    Object.assign(this, {flight, of, color, dashed, rows: [], read: 0, length_m: 0});
    const material = (opacity) => {
      const properties = {color: color(), opacity, transparent: opacity < 1};
      if (points) return new THREE.PointsMaterial({...properties, size: points, sizeAttenuation: false});
      return dashed ? new THREE.LineDashedMaterial({...properties, dashSize: 0.12, gapSize: 0.08})
        : new THREE.LineBasicMaterial(properties);
    };
    const Drawn = points ? THREE.Points : THREE.Line;
    [this.past, this.rest] = [1, kFaint].map((opacity) => {
      const drawn = new Drawn(new THREE.BufferGeometry(), material(opacity));
      drawn.frustumCulled = false;
      parent.add(drawn);
      return drawn;
    });
    this.room(1024);
    this.grow();
  }

  // For so many places; those that are there stay.
  room(count) {
    const widened = (attribute, size) => {
      const array = new Float32Array(size * count);
      if (attribute) array.set(attribute.array);
      return new THREE.BufferAttribute(array, size);
    };
    this.places = widened(this.places, 3);
    if (this.dashed) this.along = widened(this.along, 1);
    for (const {geometry} of [this.past, this.rest]) {
      geometry.setAttribute("position", this.places);
      if (this.dashed) geometry.setAttribute("lineDistance", this.along);
    }
  }

  // By the rows that have come since.
  grow() {
    for (; this.read < this.flight.rows; ++this.read) {
      const place = this.of(this.read);
      if (!place) continue;
      const n = this.rows.length;
      if (n === this.places.count) this.room(2 * n);
      const last = n ? new THREE.Vector3().fromBufferAttribute(this.places, n - 1) : null;
      if (last && this.past.isPoints && last.distanceTo(place) < kApart_m) continue;
      if (this.dashed && n) {
        this.length_m += last.distanceTo(place);
        this.along.setX(n, this.length_m);
        this.along.needsUpdate = true;
      }
      this.places.setXYZ(n, place.x, place.y, place.z);
      this.places.needsUpdate = true;
      this.rows.push(this.read);
    }
  }

  // row: the last one that is past.
  show(row) {
    this.grow();
    let low = 0, high = this.rows.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.rows[middle] <= row) low = middle + 1;
      else high = middle;
    }
    this.past.geometry.setDrawRange(0, low);
    const from = Math.max(low - 1, 0);
    this.rest.geometry.setDrawRange(from, this.rows.length - from);
  }

  remove() {
    for (const drawn of [this.past, this.rest]) {
      drawn.parent.remove(drawn);
      drawn.geometry.dispose();
      drawn.material.dispose();
    }
  }
  repaint() {
    for (const {material} of [this.past, this.rest]) material.color.set(this.color());
  }
}

const arrayAsPlace = (v) => (v ? new THREE.Vector3(...v) : null);

// Truth, estimate and fix of a flight; of the second one the truth alone, in its colour.
const pathsOf = (parent, flight, isSecond) => {
  const path = (of, options) => new GrowingPath(parent, flight, of, options);
  const truth = (row) => positionIn(flight, "truth", row), estimate = (row) => positionIn(flight, "estimate", row);
  if (isSecond)
    return [path((row) => truth(row) ?? estimate(row), {color: () => kColours.second})];
  const fix = fixInN(flight);
  return [
    path(truth, {color: truthColour}),
    path(estimate, {color: () => kColours.estimate, dashed: true}),
    ...(fix ? [path((row) => arrayAsPlace(fix(row)), {color: () => kColours.fix, points: 3})] : []),
  ];
};
