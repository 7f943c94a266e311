// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/instruments.h"

#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "base/gravity.h"
#include "base/nanoseconds.h"
#include "base/random.h"
#include "geometry/tait_bryan.h"
#include "sim/instrument/instrument_noise.h"
#include "sim/instrument/motion.h"
#include "sim/instrument/sample_clock.h"

namespace kestrel::sim {
namespace {

double StandardPressure_pa(double height_m) {  // ISO 2533
  return 101325 * std::pow(1 - 2.25577e-5 * height_m, 5.25588);
}

// What a class of an instrument is: Measure(motion, beam) makes its next reading.
struct Imu {
  using Reading = ImuReading;
  ImuParameters parameters;
  Eigen::Quaterniond R_BI;
  RandomStream random;
  InertialNoise gyroscopes, accelerometers;

  Imu(const ImuParameters& p, std::uint64_t seed)
      : parameters(p),
        R_BI(RotationFromTaitBryan({Radians(p.yaw_deg), Radians(p.pitch_deg), Radians(p.roll_deg)})),
        random(seed, "instrument imu"),
        gyroscopes(p.gyroscope_noise_density, p.gyroscope_random_walk, p.gyroscope_turn_on_rad_s, p.rate_hz,
                   random),
        accelerometers(p.accelerometer_noise_density, p.accelerometer_random_walk,
                       p.accelerometer_turn_on_m_s2, p.rate_hz, random) {}

  Reading Measure(const Motion& m, const Beam&) {
    const Eigen::Vector3d force_N =
        PointAcceleration(m, parameters.position_m) - Eigen::Vector3d(0, 0, kGravity_m_s2);
    Reading reading;
    reading.w_I = R_BI.conjugate() * m.w_B + gyroscopes.Next(random);
    reading.specific_force_I = (m.X_NB.R * R_BI).conjugate() * force_N + accelerometers.Next(random);
    return reading;
  }
};

struct Gps {
  using Reading = GpsReading;
  GpsParameters parameters;
  RandomStream random;
  WanderNoise horizontal, vertical, velocity;

  Gps(const GpsParameters& p, std::uint64_t seed)
      : parameters(p),
        random(seed, "instrument gps"),
        horizontal(p.horizontal_m, p.rate_hz),
        vertical(p.vertical_m, p.rate_hz),
        velocity(p.velocity_m_s, p.rate_hz) {}

  Reading Measure(const Motion& m, const Beam&) {
    Reading reading;
    const Eigen::Vector3d level = horizontal.Next(random), down = vertical.Next(random);
    reading.p_N = m.X_NB * parameters.position_m + Eigen::Vector3d(level.x(), level.y(), down.z());
    reading.v_N = PointVelocity(m, parameters.position_m) + velocity.Next(random);
    return reading;
  }
};

struct Barometer {
  using Reading = BarometerReading;
  BarometerParameters parameters;
  RandomStream random;
  WanderNoise height;

  Barometer(const BarometerParameters& p, std::uint64_t seed)
      : parameters(p), random(seed, "instrument barometer"), height(p.height_m, p.rate_hz) {}

  Reading Measure(const Motion& m, const Beam&) {
    Reading reading;
    reading.height_m = -m.X_NB.p.z() + height.Next(random).x();
    reading.pressure_pa = StandardPressure_pa(reading.height_m);
    return reading;
  }
};

struct Magnetometer {
  using Reading = MagnetometerReading;
  MagnetometerParameters parameters;
  RandomStream random;
  Eigen::Vector3d bias_B;

  Magnetometer(const MagnetometerParameters& p, std::uint64_t seed)
      : parameters(p), random(seed, "instrument magnetometer"), bias_B(p.turn_on_t * Normal3(random)) {}

  Reading Measure(const Motion& m, const Beam&) {
    Reading reading;
    reading.field_B = m.X_NB.R.conjugate() * EarthField_N() + bias_B + parameters.white_t * Normal3(random);
    return reading;
  }
};

struct Rangefinder {
  using Reading = RangeReading;
  RangefinderParameters parameters;
  RandomStream random;

  Rangefinder(const RangefinderParameters& p, std::uint64_t seed)
      : parameters(p), random(seed, "instrument rangefinder") {}

  Reading Measure(const Motion& m, const Beam& beam) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    const RangefinderParameters& p = parameters;
    Reading reading;
    const double measured_m =
        beam(m.X_NB * p.position_m, m.X_NB.R * p.direction.normalized()) + p.noise_m * random.Normal();
    reading.range_m = measured_m > p.max_m ? kInfinite : measured_m < p.min_m ? -kInfinite : measured_m;
    return reading;
  }
};

template <class Instrument>
struct Running {
  Instrument instrument;
  SampleClock clock;
  ReadingsUnderWay<typename Instrument::Reading> readings;

  template <class Parameters>
  Running(const Parameters& parameters, std::uint64_t seed)
      : instrument(parameters, seed), clock(parameters.rate_hz, parameters.phase_s), readings(parameters) {}
};

template <class Instrument>
using MayRun = std::optional<Running<Instrument>>;

}  // namespace

struct Instruments::Carried {
  MayRun<Imu> imu;
  std::optional<ReadingsUnderWay<TruthSample>> truth;
  MayRun<Gps> gps;
  MayRun<Barometer> barometer;
  MayRun<Magnetometer> magnetometer;
  MayRun<Rangefinder> rangefinder;
};

Instruments::Instruments(const InstrumentParameters& p, std::uint64_t seed)
    : carried_(std::make_unique<Carried>()) {
  const auto begin = [&](auto& running, const auto& parameters) {
    if (parameters) running.emplace(*parameters, seed);
  };
  begin(carried_->imu, p.imu);
  begin(carried_->gps, p.gps);
  begin(carried_->barometer, p.barometer);
  begin(carried_->magnetometer, p.magnetometer);
  begin(carried_->rangefinder, p.rangefinder);
  if (p.imu) carried_->truth.emplace(SampleTiming{.latency_s = p.imu->latency_s});
}

Instruments::~Instruments() = default;

void Instruments::Step(const Truth& before, const Truth& after, const Beam& beam) {
  const std::int64_t from_ns = Nanoseconds(before.t_s), to_ns = Nanoseconds(after.t_s);
  const auto run = [&](auto& running, const auto& then) {
    if (!running) return;
    for (; running->clock.next_ns() <= to_ns; running->clock.Tick()) {
      const std::int64_t t_ns = running->clock.next_ns();
      const double share = static_cast<double>(t_ns - from_ns) / static_cast<double>(to_ns - from_ns);
      const Motion motion = Between(before, after, share);
      running->readings.Send(t_ns, running->instrument.Measure(motion, beam));
      then(t_ns, motion);
    }
  };
  const auto nothing = [](std::int64_t, const Motion&) {};
  Carried& c = *carried_;
  run(c.imu, [&](std::int64_t t_ns, const Motion& motion) {
    const Imu& imu = c.imu->instrument;
    c.truth->Send(t_ns,
                  {0, motion.X_NB, motion.v_N, motion.w_B, imu.gyroscopes.bias(), imu.accelerometers.bias()});
  });
  run(c.gps, nothing);
  run(c.barometer, nothing);
  run(c.magnetometer, nothing);
  run(c.rangefinder, nothing);
}

Readings Instruments::Take(double t_s) {
  const std::int64_t now_ns = Nanoseconds(t_s);
  const auto take = [&](auto& running, auto& into) {
    if (running) into = running->readings.Take(now_ns);
  };
  Readings come;
  take(carried_->imu, come.imu);
  if (carried_->truth) come.truth = carried_->truth->Take(now_ns);
  take(carried_->gps, come.gps);
  take(carried_->barometer, come.barometer);
  take(carried_->magnetometer, come.magnetometer);
  take(carried_->rangefinder, come.rangefinder);
  return come;
}

}  // namespace kestrel::sim
