// SPDX-License-Identifier: Apache-2.0
// A flight as the page knows it: FlightData's object (records/page/flight_data.h), with its rows by number and by
// time. Rows are those of telemetry.csv, in the frames of that file. A flight that is still flown grows.
class Flight {
  constructor(data, letter) {
    this.letter = letter;  // "A" or "B"
    this.changed = [];
    this.columns = {};
    this.names = [];  // of the columns, in the order of appended rows
    this.filled = new Set();
    this.describe(data);
    for (const [name, column] of Object.entries(data.columns ?? {})) {
      this.columns[name] = column;
      this.names.push(name);
      if ((column.words ? column.at : column).some((value) => value !== null)) this.filled.add(name);
    }
  }

  // What is known of it besides its rows; what is not named stays.
  describe(data) {
    this.data = {...this.data, ...data, columns: undefined};
    this.events = [...(data.events ?? this.events ?? [])].sort((a, b) => a.t_s - b.t_s);
    this.tell("description");
  }

  get rows() { return this.columns.t_s?.length ?? 0; }
  get begin_s() { return this.rows ? this.columns.t_s[0] : 0; }
  get end_s() { return this.rows ? this.columns.t_s[this.rows - 1] : this.begin_s; }
  get step_s() { return 1 / (this.data.rate_hz || 20); }

  has(name) { return this.filled.has(name); }
  isText(name) { return Boolean(this.columns[name]?.words); }

  // null: there is none in this row.
  value(name, row) {
    const value = this.columns[name]?.[row];
    return typeof value === "number" ? value : null;
  }
  text(name, row) {
    const column = this.columns[name];
    return column?.words?.[column.at[row]] ?? "";
  }

  // The last row that is not later; the first one before all.
  rowAt(t_s) {
    const times = this.columns.t_s ?? [];
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= t_s + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // Between two rows, for what is known by a time of its own.
  valueAt(name, t_s) {
    const row = this.rowAt(t_s);
    const [a, b] = [this.value(name, row), this.value(name, row + 1)];
    const [t, next] = [this.columns.t_s[row], this.columns.t_s[row + 1]];
    return a === null || b === null || next === undefined ? a : a + (b - a) * Math.max(0, (t_s - t) / (next - t));
  }

  // What grows in flight.
  setColumns(names) {
    this.names = names;
    this.columns = Object.fromEntries(names.map((name) => [name, []]));
    this.filled.clear();
    this.tell("columns");
  }
  append(rows) {
    const filled = this.filled.size;
    for (const row of rows) this.names.forEach((name, i) => this.push(name, row[i] ?? null));
    this.tell("row");
    if (this.filled.size !== filled) this.tell("columns");
  }
  push(name, value) {
    let column = this.columns[name];
    if (typeof value === "string" && !column.words)
      column = this.columns[name] = {words: [], at: column.map(() => null)};
    if (value !== null) this.filled.add(name);
    if (!column.words) return column.push(value);
    if (value !== null && !column.words.includes(value)) column.words.push(value);
    column.at.push(value === null ? null : column.words.indexOf(value));
  }
  addEvent(event) {
    this.events.push(event);
    this.events.sort((a, b) => a.t_s - b.t_s);
    this.tell("event");
  }

  // fn("description" | "columns" | "row" | "event") after each change.
  onChange(fn) { this.changed.push(fn); }
  tell(what) { this.changed.forEach((fn) => fn(what)); }
}

const data = JSON.parse(byId("data").textContent);
const flights = data.flights.map((flight, i) => new Flight(flight, "AB"[i]));
const [flight, second] = flights;
const isLive = Boolean(flight.data.live);  // the page is of a flight that is, or was, still flown
