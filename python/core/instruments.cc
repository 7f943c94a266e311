// SPDX-License-Identifier: Apache-2.0
#include "python/core/instruments.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <tuple>
#include <vector>

#include "python/core/arrays.h"

namespace kestrel::python {
namespace py = pybind11;
namespace {

// A field after another of 8-byte numbers: its name, and how many there are.
struct Column {
  const char* name;
  int count;
};

// A row is t_ns and then the columns, as Packed has them in memory.
template <class Packed>
py::array Table(const std::vector<Packed>& rows, const std::vector<Column>& columns) {
  py::list fields;
  fields.append(py::make_tuple("t_ns", "i8"));
  int numbers = 1;
  for (const auto& [name, count] : columns) {
    if (count == 1)
      fields.append(py::make_tuple(name, "f8"));
    else
      fields.append(py::make_tuple(name, "f8", py::make_tuple(count)));
    numbers += count;
  }
  if (sizeof(Packed) != 8u * static_cast<unsigned>(numbers))
    throw std::logic_error("columns are not as the rows");
  py::array table(py::dtype::from_args(fields),
                  std::vector<py::ssize_t>{static_cast<py::ssize_t>(rows.size())});
  if (!rows.empty()) std::memcpy(table.mutable_data(), rows.data(), rows.size() * sizeof(Packed));
  return table;
}

template <class Instrument>
void Require(const std::optional<Instrument>& instrument, const char* name) {
  if (!instrument)
    throw SimError(fmt::format(
        "the scenario has no instruments.{0}; to carry one, override instruments.{0} by {{}}", name));
}

struct PackedTruth {
  std::int64_t t_ns;
  double position[3], attitude[4], velocity[3], rates[3], gyro_bias[3], accel_bias[3];
};

}  // namespace

py::array ImuOf(const Sim& sim) { return Table(sim.readings().imu, {{"gyro", 3}, {"accel", 3}}); }

py::array ImuTruthOf(const Sim& sim) {
  std::vector<PackedTruth> rows;
  for (const sim::TruthSample& truth : sim.readings().truth) {
    PackedTruth& row = rows.emplace_back();
    row.t_ns = truth.t_ns;
    const auto put = [](double* to, const auto& from) {
      std::copy(from.data(), from.data() + from.size(), to);
    };
    put(row.position, truth.X_NB.p);
    put(row.attitude, QuaternionOf(truth.X_NB.R));
    put(row.velocity, truth.v_N);
    put(row.rates, truth.w_B);
    put(row.gyro_bias, truth.gyroscope_bias_I);
    put(row.accel_bias, truth.accelerometer_bias_I);
  }
  return Table(
      rows,
      {{"position", 3}, {"attitude", 4}, {"velocity", 3}, {"rates", 3}, {"gyro_bias", 3}, {"accel_bias", 3}});
}

py::array GpsOf(const Sim& sim) {
  Require(sim.scenario().simulator.instruments.gps, "gps");
  return Table(sim.readings().gps, {{"position", 3}, {"velocity", 3}});
}

py::array BarometerOf(const Sim& sim) {
  Require(sim.scenario().simulator.instruments.barometer, "barometer");
  return Table(sim.readings().barometer, {{"height", 1}, {"pressure", 1}});
}

py::array MagnetometerOf(const Sim& sim) {
  Require(sim.scenario().simulator.instruments.magnetometer, "magnetometer");
  return Table(sim.readings().magnetometer, {{"field", 3}});
}

py::array RangefinderOf(const Sim& sim) {
  Require(sim.scenario().simulator.instruments.rangefinder, "rangefinder");
  return Table(sim.readings().rangefinder, {{"range", 1}});
}

py::array EventsOf(const Sim& sim) {
  static_assert(sizeof(sim::Event) == 16 && offsetof(sim::Event, x) == 8 && offsetof(sim::Event, on) == 12);
  py::list names, formats, offsets;
  int offset = 0;
  for (const auto& [name, format, bytes] :
       {std::tuple("t_ns", "i8", 8), {"x", "u2", 2}, {"y", "u2", 2}, {"on", "?", 1}}) {
    names.append(name), formats.append(format), offsets.append(offset);
    offset += bytes;
  }
  const std::vector<sim::Event>& events = sim.events();
  py::array table(py::dtype(names, formats, offsets, sizeof(sim::Event)),
                  std::vector<py::ssize_t>{static_cast<py::ssize_t>(events.size())});
  if (!events.empty()) std::memcpy(table.mutable_data(), events.data(), events.size() * sizeof(sim::Event));
  return table;
}

}  // namespace kestrel::python
