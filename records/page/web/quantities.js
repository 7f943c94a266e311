// SPDX-License-Identifier: Apache-2.0
// What can be plotted: the columns that mean the same quantity are one plot, laid over each other. A series is
// {kind, label, of(row), at(row)}: its value, or null, and the time it is of.
const kinds = {
  truth: "truth", estimate: "autopilot’s estimate", own: "autopilot’s own attitude", fix: "vision’s fix",
  setpoint: "setpoint", target: "target", second: "run B",
};

const seriesOf = (flight, kind, of, label = kinds[kind], at = null) =>
  (of ? {flight, kind, label, of, at: at ?? ((row) => flight.columns.t_s[row])} : null);
const columnOf = (flight, name, sign = 1) => (flight.has(name) && !flight.isText(name) ? (row) => {
  const value = flight.value(name, row);
  return value === null ? null : sign * value;
} : null);
const less = (a, b) => (a && b ? (row) => {
  const [of_a, of_b] = [a(row), b(row)];
  return of_a === null || of_b === null ? null : of_a - of_b;
} : null);
const wrapped = (angle) => angle && ((row) => {
  const value = angle(row);
  return value === null ? null : value - 360 * Math.round(value / 360);
});
const exposureOf = (flight) => (row) => flight.value("exposure_t_s", row) ?? flight.columns.t_s[row];

const axes = ["x", "y", "z"];
const turned = (v, yaw_deg) => {
  const [c, s] = [Math.cos(yaw_deg * Math.PI / 180), Math.sin(yaw_deg * Math.PI / 180)];
  return [c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]];
};
const vectorAt = (flight, pattern, row) => {
  const v = axes.map((axis) => flight.value(pattern.replace("?", axis), row));
  return v.includes(null) ? null : v;
};

// A fix is of the landmark's frame. Where the landmark truly is at its exposure the simulator's truth tells, of a
// real aircraft its pose in N does.
const fixInN = (flight) => {
  if (!flight.has("fix_x_m")) return null;
  const exposure = exposureOf(flight);
  if (flight.has("truth_x_m") && flight.has("target_x_m")) return (row) => {
    const fix = vectorAt(flight, "fix_?_m", row), truly = vectorAt(flight, "target_?_m", row);
    if (!fix || !truly) return null;
    const t_s = exposure(row);
    const yaw_deg = flight.valueAt("truth_yaw_deg", t_s) - flight.value("target_yaw_deg", row);
    const error = turned(fix.map((each, i) => each - truly[i]), yaw_deg);
    return axes.map((axis, i) => flight.valueAt(`truth_${axis}_m`, t_s) + error[i]);
  };
  const X_NT = flight.data.pad?.X_NT;
  if (!X_NT) return null;
  const [w, x, y, z] = X_NT.q;
  const yaw_deg = Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)) * 180 / Math.PI;
  return (row) => {
    const fix = vectorAt(flight, "fix_?_m", row);
    return fix && turned(fix, yaw_deg).map((each, i) => each + X_NT.p[i]);
  };
};

// The setpoint of velocity is of the heading frame.
const velocitySetpointInN = (flight) => {
  if (!flight.has("setpoint_vx_m_s") || !flight.has("estimate_yaw_deg")) return null;
  return (row) => {
    const v = vectorAt(flight, "setpoint_v?_m_s", row), yaw_deg = flight.value("estimate_yaw_deg", row);
    return v && yaw_deg !== null ? turned(v, yaw_deg) : null;
  };
};
const part = (vector, i, sign = 1) => vector && ((row) => {
  const v = vector(row);
  return v && sign * v[i];
});

const placeOf = (flight, i) => {
  const sign = i === 2 ? -1 : 1;
  const column = (of) => columnOf(flight, `${of}_${axes[i]}_m`, sign);
  return [
    seriesOf(flight, "truth", column("truth")), seriesOf(flight, "estimate", column("estimate")),
    seriesOf(flight, "setpoint", column("setpoint")),
    seriesOf(flight, "fix", part(fixInN(flight), i, sign), undefined, exposureOf(flight)),
    seriesOf(flight, "target", column("truth_target0"), "target 0"),
  ];
};
const velocityOf = (flight, i) => [
  seriesOf(flight, "truth", columnOf(flight, `truth_v${axes[i]}_m_s`)),
  seriesOf(flight, "estimate", columnOf(flight, `estimate_v${axes[i]}_m_s`)),
  seriesOf(flight, "setpoint", part(velocitySetpointInN(flight), i)),
];
// The own attitude is drawn where the autopilot flies by another.
const attitudeOf = (flight, angle) => {
  const fix = columnOf(flight, angle === "yaw" ? "fix_yaw_deg" : `horizon_${angle}_deg`);
  return [
    seriesOf(flight, "truth", columnOf(flight, `truth_${angle}_deg`)),
    flight.columns.aided?.includes(1)
      ? seriesOf(flight, "own", columnOf(flight, `inertial_${angle}_deg`)) : null,
    seriesOf(flight, "estimate", columnOf(flight, `estimate_${angle}_deg`)),
    seriesOf(flight, "setpoint", columnOf(flight, `setpoint_${angle}_deg`)),
    seriesOf(flight, "fix", fix, undefined, exposureOf(flight)),
  ];
};
const rateOf = (flight, axis, angle) => [
  seriesOf(flight, "truth", columnOf(flight, `truth_rate_${axis}_deg_s`)),
  seriesOf(flight, "setpoint", columnOf(flight, `setpoint_${angle}_rate_deg_s`)),
];
const truthAtExposure = (flight, name) => (flight.has(name)
  ? (row) => flight.valueAt(name, exposureOf(flight)(row)) : null);
const placeErrorOf = (flight, axis) => [
  seriesOf(flight, "estimate", less(columnOf(flight, `estimate_${axis}_m`), columnOf(flight, `truth_${axis}_m`))),
  seriesOf(flight, "fix", less(columnOf(flight, `fix_${axis}_m`), columnOf(flight, `target_${axis}_m`)),
    undefined, exposureOf(flight)),
];
const angleErrorOf = (flight, angle) => {
  const truth = columnOf(flight, `truth_${angle}_deg`);
  const fix = angle === "yaw" ? less(columnOf(flight, "fix_yaw_deg"), columnOf(flight, "target_yaw_deg"))
    : less(columnOf(flight, `horizon_${angle}_deg`), truthAtExposure(flight, `truth_${angle}_deg`));
  return [
    seriesOf(flight, "estimate", wrapped(less(columnOf(flight, `estimate_${angle}_deg`), truth))),
    seriesOf(flight, "fix", wrapped(fix), undefined, exposureOf(flight)),
  ];
};
const distanceOf = (flight, i) => [seriesOf(flight, "truth", flight.has(`truth_target${i}_x_m`) ? (row) => {
  const a = vectorAt(flight, "truth_?_m", row), b = vectorAt(flight, `truth_target${i}_?_m`, row);
  return a && b && Math.hypot(...a.map((each, k) => each - b[k]));
} : null)];
const single = (name) => (flight) => [
  seriesOf(flight, name.startsWith("truth") ? "truth" : "plain", columnOf(flight, name), plainName(name))];
const measured = (of, wanted) => (flight) => [
  seriesOf(flight, "fix", columnOf(flight, of), "in the image"),
  seriesOf(flight, "setpoint", columnOf(flight, wanted), "wanted"),
];

const quantity = (group, key, title, unit, series, more = {}) => ({group, key, title, unit, series, ...more});
const overlaid = [
  quantity("Position", "x", "North, x", "m", (f) => placeOf(f, 0)),
  quantity("Position", "y", "East, y", "m", (f) => placeOf(f, 1)),
  quantity("Position", "height", "Height, −z", "m", (f) => placeOf(f, 2)),
  quantity("Velocity", "vx", "Velocity north", "m/s", (f) => velocityOf(f, 0)),
  quantity("Velocity", "vy", "Velocity east", "m/s", (f) => velocityOf(f, 1)),
  quantity("Velocity", "vz", "Velocity down", "m/s", (f) => velocityOf(f, 2)),
  ...["roll", "pitch", "yaw"].map((angle) => quantity("Attitude", angle, angle[0].toUpperCase() + angle.slice(1), "°",
    (f) => attitudeOf(f, angle), {angle: true})),
  ...[["x", "roll"], ["y", "pitch"], ["z", "yaw"]].map(([axis, angle]) => quantity("Attitude", `rate_${axis}`,
    `Rate about ${axis}`, "°/s", (f) => rateOf(f, axis, angle))),
  ...axes.map((axis) => quantity("Errors against the truth", `error_${axis}`, `Error of ${axis}`, "m",
    (f) => placeErrorOf(f, axis))),
  ...["roll", "pitch", "yaw"].map((angle) => quantity("Errors against the truth", `error_${angle}`,
    `Error of ${angle}`, "°", (f) => angleErrorOf(f, angle))),
  quantity("Target", "distance", "Distance to target 0", "m", (f) => distanceOf(f, 0)),
  quantity("Target", "distance1", "Distance to target 1", "m", (f) => distanceOf(f, 1)),
  quantity("Target", "bearing", "Bearing of the intruder", "°",
    measured("intruder_bearing_deg", "intruder_wanted_deg"), {angle: true}),
  ...[["u", "u"], ["v", "v"], ["diameter", "diameter"]].map(([of, name]) => quantity("Target", `balloon_${of}`,
    `Balloon’s ${name}`, "px", measured(`balloon_${of}_px`, `wanted_${of}_px`))),
];

// What is shown without being asked for: the first of these that there are.
const shownAtFirst = (keys) => {
  const attitude = keys.includes("error_roll") && flight.has("horizon_roll_deg");
  const wanted = attitude ? ["roll", "pitch", "error_roll", "error_pitch", "yaw", "height"]
    : ["x", "y", "height", "yaw", "error_x", "error_y", "distance", "bearing", "balloon_u", "balloon_diameter", "vx", "vy"];
  const shown = wanted.filter((key) => keys.includes(key) && !(key.startsWith("error_") && !attitude && !flight.has("fix_x_m")));
  return shown.length ? shown.slice(0, 8) : keys.slice(0, 4);
};

// All that this flight can show, the remaining columns each by itself.
const quantities = () => {
  const known = overlaid.filter(({series}) => series(flight).some(Boolean));
  const columns = flight.names.filter((name) => !["t_s", "exposure_t_s", "sequence"].includes(name)
    && flight.has(name) && !flight.isText(name));
  return [...known, ...columns.map((name) => quantity("Single columns", name, plainName(name), unitOf(name)[1],
    single(name), {angle: name.endsWith("_deg")}))];
};

// The series of a quantity, of the second flight the first that there is.
const allSeries = ({series}) => {
  const of_first = series(flight).filter(Boolean);
  const other = second && series(second).find(Boolean);
  return other ? [...of_first, {...other, kind: "second", label: `run B, ${other.label}`}] : of_first;
};
