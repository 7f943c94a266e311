// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "mission/figure_text.h"
#include "mission/helipad_pilot.h"
#include "mission/log_row.h"
#include "mission/metric.h"
#include "mission/mission.h"
#include "vision/aircraft/ground_sight.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/camera_mount.h"
#include "vision/landmark/pad_reference.h"

// What a mission declares of itself. The recorder, the runner, campaigns and the hardware program take
// it from here; none of them knows a mission by its name.
namespace kestrel::mission {

// A column of telemetry.csv; no value: an empty cell.
struct TelemetryColumn {
  std::string name;  // with the unit
  std::function<std::optional<double>(const LogRow&)> value;
};

// A figure of the flight, judged by the truth.
struct MissionPlot {
  std::string file;                                          // "follow.png"
  std::function<bool(const std::vector<LogRow>&)> has_data;  // whether there is anything to draw
  // gnuplot's script that draws it (records/plot/plot_parts.h).
  std::function<std::string(const std::filesystem::path&, const std::vector<LogRow>&, const FigureText&)>
      script;
};

struct MissionType {
  std::string name;                  // of the key `mission` in a scenario
  std::string summary;               // one sentence
  bool looks_for_pad = false;        // it needs a pad, and a camera that sees along its own axis
  bool needs_ground_camera = false;  // it flies by a camera on the ground
  bool needs_colour = false;         // it tells its target by colour
  bool begins_in_the_air = false;
  std::vector<TelemetryColumn> telemetry = {};  // beside those of every flight
  // Its own metrics, beside those of every flight (records/telemetry/metrics.h), and what computes them from those.
  std::vector<Metric> metrics = {};
  std::function<void(const std::vector<LogRow>&, std::map<std::string, double>&)> add_metrics = nullptr;
  // Which of the metrics of every flight mean something here: names, or beginnings of names before '*'.
  std::vector<std::string> common_metrics = {};
  std::vector<MissionPlot> plots = {};
  // What its vision makes for people to look at, beside the plots: files in the folder of the records, and the
  // one of them that is a video, which grows frame by frame (Mission::WriteProducts, ProductImage).
  std::vector<std::string> products = {};
  std::string product_video = {};
  // Which keys of flight and pilot may change in flight (Mission::Change): names, or patterns with '*', such as
  // "flight.gains.*".
  std::vector<std::string> changeable = {};
};

// What a mission is made from, in the simulator as on a real aircraft.
struct MissionParts {
  PilotParameters pilot;  // of a mission that looks for the pad
  vision::CameraModel camera;
  Pose X_BC;
  vision::PadReference pad;  // the same
  cv::Mat own_parts;         // of the others: where the camera sees the aircraft itself, CV_8U, 255 there
  std::uint64_t seed = 1;    // of a pilot who is made up
  std::optional<vision::GroundSight> ground = {};  // a second camera; none: there is none
};
HelipadPilot PilotOf(const MissionParts& parts);

// What an autopilot gives at most, as far as a mission may ask for it.
struct AircraftLimits {
  double speed_m_s = 0, climb_m_s = 0, yaw_rate_deg_s = 0, acceleration_m_s2 = 0;
};

// Whether a key of the scenario may have another value than it has, as a campaign varies it; of "targets",
// also whether there are any.
using Varies = std::function<bool(const std::string& key)>;

// The parameters of a mission: what a scenario has under `flight`. Everything that is wrong with them is a
// mistake before anything starts; where: the file and line, for messages.
class FlightParameters {
 public:
  virtual ~FlightParameters() = default;
  virtual const MissionType& type() const = 0;
  virtual std::unique_ptr<FlightParameters> Clone() const = 0;
  virtual void Visit(FieldVisitor& visitor) = 0;
  virtual std::unique_ptr<Mission> Make(const MissionParts& parts) const = 0;
  // What each number allows and their sum does not.
  virtual void Check(const Place& where, Mistakes& mistakes) const = 0;
  virtual void CheckLimits(const AircraftLimits& limits, const Place& where, Mistakes& mistakes) const = 0;
  // What this camera, so mounted, does not allow. mount_where: where the scenario has the mount.
  virtual void CheckView(const vision::CameraModel& camera, const vision::CameraMount& mount,
                         const Place& where, const Place& mount_where, Mistakes& mistakes) const = 0;
  // What a pad that the camera sees from this height above it on, and not below, does not allow.
  virtual void CheckPad(double seen_from_m, const Place& where, Mistakes& mistakes) const = 0;
  // Whether a flight by these parameters can have a metric of its type at all.
  virtual bool CanHave(const std::string& metric, const Varies& varies) const = 0;
};

// The same as a value. Empty until a mission is chosen.
class Flight {
 public:
  Flight() = default;
  template <class Parameters>
  requires std::derived_from<Parameters, FlightParameters>
  explicit Flight(Parameters parameters) : is_(std::make_unique<Parameters>(std::move(parameters))) {}
  explicit Flight(std::unique_ptr<FlightParameters> parameters) : is_(std::move(parameters)) {}
  Flight(const Flight& other) : is_(other.is_ ? other.is_->Clone() : nullptr) {}
  Flight(Flight&&) noexcept = default;
  Flight& operator=(Flight other) noexcept {
    is_ = std::move(other.is_);
    return *this;
  }

  explicit operator bool() const { return is_ != nullptr; }
  FlightParameters* operator->() { return is_.get(); }
  const FlightParameters* operator->() const { return is_.get(); }
  const MissionType& type() const { return is_->type(); }
  // As the parameters of one mission; null: it is another.
  template <class Parameters>
  Parameters* As();
  template <class Parameters>
  const Parameters* As() const;

 private:
  std::unique_ptr<FlightParameters> is_;
};

// FlightParameters of a plain struct with Fields, found by what stands beside it: MissionType TypeOf(const
// Parameters&), MakeMission(parameters, parts), and where there is anything to check CheckFlight,
// CheckFlightLimits, CheckFlightView, CheckFlightPad and FlightCanHave, with the struct before the arguments
// above.
template <class Parameters>
class FlightOf final : public FlightParameters {
 public:
  explicit FlightOf(Parameters parameters = {}) : values(std::move(parameters)) {}

  const MissionType& type() const override {
    static const MissionType kType = TypeOf(Parameters{});
    return kType;
  }
  std::unique_ptr<FlightParameters> Clone() const override { return std::make_unique<FlightOf>(*this); }
  void Visit(FieldVisitor& visitor) override { Fields(visitor, values); }
  std::unique_ptr<Mission> Make(const MissionParts& parts) const override {
    return MakeMission(values, parts);
  }
  void Check(const Place& where, Mistakes& mistakes) const override {
    if constexpr (requires { CheckFlight(values, where, mistakes); }) CheckFlight(values, where, mistakes);
  }
  void CheckLimits(const AircraftLimits& limits, const Place& where, Mistakes& mistakes) const override {
    if constexpr (requires { CheckFlightLimits(values, limits, where, mistakes); })
      CheckFlightLimits(values, limits, where, mistakes);
  }
  void CheckView(const vision::CameraModel& camera, const vision::CameraMount& mount, const Place& where,
                 const Place& mount_where, Mistakes& mistakes) const override {
    if constexpr (requires { CheckFlightView(values, camera, mount, where, mount_where, mistakes); })
      CheckFlightView(values, camera, mount, where, mount_where, mistakes);
  }
  void CheckPad(double seen_from_m, const Place& where, Mistakes& mistakes) const override {
    if constexpr (requires { CheckFlightPad(values, seen_from_m, where, mistakes); })
      CheckFlightPad(values, seen_from_m, where, mistakes);
  }
  bool CanHave(const std::string& metric, const Varies& varies) const override {
    if constexpr (requires { FlightCanHave(values, metric, varies); })
      return FlightCanHave(values, metric, varies);
    return true;
  }

  Parameters values;
};

template <class Parameters>
Parameters* Flight::As() {
  auto* of = dynamic_cast<FlightOf<Parameters>*>(is_.get());
  return of ? &of->values : nullptr;
}
template <class Parameters>
const Parameters* Flight::As() const {
  const auto* of = dynamic_cast<const FlightOf<Parameters>*>(is_.get());
  return of ? &of->values : nullptr;
}

inline void Fields(FieldVisitor& visitor, Flight& flight) {
  if (flight) flight->Visit(visitor);
}

// The missions that there are. A program adds its own before it reads a scenario; two of one name are refused
// by std::logic_error.
void AddMission(Flight defaults);
template <class Parameters>
void AddMission() {
  AddMission(Flight(FlightOf<Parameters>{}));
}
const std::vector<Flight>& Missions();  // with their defaults, in the order in which they were added
std::vector<std::string> MissionNames();

// With its defaults, unless it is that one already. Without such a mission as it is, or else the first.
void SelectMission(const std::string& name, Flight& flight);

}  // namespace kestrel::mission
