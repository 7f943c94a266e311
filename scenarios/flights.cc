// SPDX-License-Identifier: Apache-2.0
#include "scenarios/flights.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <optional>

#include "base/file/model_files.h"
#include "geometry/tait_bryan.h"

namespace kestrel {
namespace {

template <class... Each>
std::vector<std::string> NamesOf(const std::variant<Each...>&) {
  return {Each::kName...};
}

template <std::size_t index = 0>
void Select(const std::string& mission, Flight& flight) {
  if constexpr (index < std::variant_size_v<Flight>) {
    if (std::variant_alternative_t<index, Flight>::kName != mission)
      return Select<index + 1>(mission, flight);
    if (flight.index() != index) flight.emplace<index>();
  }
}

// Whether a flight looks for the pad: all do that do not say otherwise, by a constant kPadless.
template <class Each>
constexpr bool kLooksForPad = [] {
  if constexpr (requires { Each::kPadless; }) return !Each::kPadless;
  return true;
}();

// Whether a flight tells its target by colour: by a constant kLooksForColour.
bool NeedsColour(const Flight& flight) {
  return std::visit(
      []<class Each>(const Each&) {
        if constexpr (requires { Each::kLooksForColour; }) return Each::kLooksForColour;
        return false;
      },
      flight);
}

void CheckColour(const ColourRange& colour, const std::string& key, const std::string& where,
                 Mistakes& mistakes) {
  if (colour.least_value >= colour.most_value)
    mistakes.Add(where, key + ".least_value",
                 fmt::format("{:g} is not below most_value = {:g}: no pixel can match", colour.least_value,
                             colour.most_value));
}

void CheckAvoid(const AvoidFlight& flight, const std::string& where, Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.avoidance.hold.bearing_deg", flight.avoidance.hold.bearing_deg,
       flight.avoidance.most_bearing_deg, "flight.avoidance.most_bearing_deg");
  if (flight.marks.empty() && !flight.contrast)
    mistakes.Add(where, "flight.marks", "is empty; valid: at least one, or a flight.contrast");
  for (std::size_t i = 0; i < flight.marks.size(); ++i) {
    const ColourRange& a = flight.marks[i].colour;
    CheckColour(a, fmt::format("flight.marks.{}.colour", i), where, mistakes);
    for (std::size_t j = 0; j < i; ++j) {
      const ColourRange& b = flight.marks[j].colour;
      const double apart_deg = std::abs(Degrees(WrapAngle(Radians(a.hue_deg - b.hue_deg))));
      if (apart_deg < a.hue_half_width_deg + b.hue_half_width_deg)
        mistakes.Add(where, fmt::format("flight.marks.{}.colour", i),
                     fmt::format("hues {:g} +- {:g} overlap those of mark {}, {:g} +- {:g}: two marks alike "
                                 "cannot be told apart; valid: hues of their own",
                                 a.hue_deg, a.hue_half_width_deg, j, b.hue_deg, b.hue_half_width_deg));
    }
  }
  if (!flight.contrast) return;
  const ContrastTrackerOptions& tracker = flight.contrast->tracker;
  most("flight.contrast.tracker.confirm_sightings", tracker.confirm_sightings, tracker.confirm_images,
       "flight.contrast.tracker.confirm_images");
  most("flight.contrast.tracker.detector.least_diameter_px", tracker.detector.least_diameter_px,
       tracker.detector.most_diameter_px, "flight.contrast.tracker.detector.most_diameter_px");
}

// Who is to be avoided comes from ahead.
void CheckLooksAhead(const CameraModel& camera, const CameraMount& mount, const std::string& where,
                     Mistakes& mistakes) {
  const auto at = Project(camera, MountPose(mount).R.conjugate() * Eigen::Vector3d::UnitX());
  if (!at || at->x() < 0 || at->y() < 0 || at->x() > WidthPx(camera) - 1 || at->y() > HeightPx(camera) - 1)
    mistakes.Add(
        where, "mount.pitch_deg",
        fmt::format("{:g}: the camera does not see straight ahead, where others come from; valid: one "
                    "that does (90 looks ahead)",
                    mount.pitch_deg));
}

// A balloon can be wanted only where the camera sees it, at least from a level aircraft.
void CheckReferences(const FollowFlight& flight, const CameraModel& camera, const CameraMount& mount,
                     const std::string& where, Mistakes& mistakes) {
  constexpr int kPoints = 72;  // of the circle
  const double focal_px = Parameters(camera)[0];
  const Eigen::Quaterniond R_CB = MountPose(mount).R.conjugate();
  const auto seen = [&](const FollowReference& r, double angle) {
    const double radius_px = r.diameter_px / 2;
    const Eigen::Vector3d ahead(focal_px, r.u_px + radius_px * std::cos(angle),
                                r.v_px + radius_px * std::sin(angle));
    const auto at = Project(camera, R_CB * ahead);
    return at && at->x() >= 0 && at->y() >= 0 && at->x() <= WidthPx(camera) - 1 &&
           at->y() <= HeightPx(camera) - 1;
  };
  for (std::size_t i = 0; i < flight.reference.size(); ++i) {
    const FollowReference& r = flight.reference[i];
    const std::string key = fmt::format("flight.reference.{}", i);
    if (i > 0 && r.from_s <= flight.reference[i - 1].from_s)
      mistakes.Add(where, key + ".from_s",
                   fmt::format("{:g} is not after the one before; valid: above {:g}", r.from_s,
                               flight.reference[i - 1].from_s));
    bool whole = true;
    for (int k = 0; k < kPoints && whole; ++k) whole = seen(r, 2 * M_PI * k / kPoints);
    if (!whole)
      mistakes.Add(where, key,
                   fmt::format("u_px {:g}, v_px {:g} and diameter_px {:g} are a circle beyond the image of "
                               "{} x {} px, by this camera as it is mounted; valid: one within it, nearer "
                               "to the middle or smaller, and a camera that looks ahead",
                               r.u_px, r.v_px, r.diameter_px, WidthPx(camera), HeightPx(camera)));
  }
}

}  // namespace

std::vector<std::string> MissionNames() { return NamesOf(Flight{}); }
void SelectFlight(const std::string& mission, Flight& flight) { Select(mission, flight); }

bool LooksForPad(const Flight& flight) {
  return std::visit([]<class Each>(const Each&) { return kLooksForPad<Each>; }, flight);
}

std::unique_ptr<Mission> MakeMission(const FlightParts& parts) {
  return std::visit(
      [&]<class Each>(const Each& flight) {
        if constexpr (kLooksForPad<Each>) {
          return MakeMission(flight, HelipadPilot(parts.pad, parts.camera, parts.X_BC, parts.pilot));
        } else {
          return MakeMission(flight, parts.camera, parts.X_BC, parts.own_parts, parts.seed);
        }
      },
      parts.flight);
}

void CheckFlight(const Flight& flight, bool colour, const Config& config, const std::string& where,
                 Mistakes& mistakes) {
  if (NeedsColour(flight) && !colour)
    mistakes.Add(WhereOf(config, "image", where), "image.colour",
                 fmt::format("false, but the mission '{}' tells its target by colour; valid: true",
                             MissionNames()[flight.index()]));
  const std::string written = WhereOf(config, "flight", where);
  if (const auto* avoid = std::get_if<AvoidFlight>(&flight)) CheckAvoid(*avoid, written, mistakes);
  if (const auto* follow = std::get_if<FollowFlight>(&flight)) {
    if (follow->reference.empty()) mistakes.Add(written, "flight.reference", "is empty; valid: at least one");
    CheckColour(follow->balloon.colour, "flight.balloon.colour", written, mistakes);
  }
}

void CheckView(const Flight& flight, const std::string& camera_name, const CameraModel& camera,
               const CameraMount& mount, const Config& config, const std::string& where, Mistakes& mistakes) {
  if (LooksForPad(flight) && !TrackersCamera(camera)) {
    const Eigen::VectorXd numbers = Parameters(camera);
    mistakes.Add(WhereOf(config, "camera", where), "camera",
                 fmt::format("'{}' does not see along its own optical axis, where these flights look for "
                             "the pad: its principal point ({:g}, {:g}) is too near to the edge of the image "
                             "of {} x {} px or beyond it; valid: a camera that has it well within",
                             camera_name, numbers[2], numbers[3], WidthPx(camera), HeightPx(camera)));
  }
  if (std::holds_alternative<AvoidFlight>(flight))
    CheckLooksAhead(camera, mount, WhereOf(config, "mount", where), mistakes);
  if (const auto* follow = std::get_if<FollowFlight>(&flight))
    CheckReferences(*follow, camera, mount, WhereOf(config, "flight", where), mistakes);
}

void CheckHasPad(const Flight& flight, const Config& config, const std::string& where, Mistakes& mistakes) {
  if (LooksForPad(flight))
    mistakes.Add(
        WhereOf(config, "pad", where), "pad.name",
        fmt::format("none, but the mission '{}' looks for a pad; valid: {}", MissionNames()[flight.index()],
                    fmt::join(NamesIn(Root() / "models" / "pads", ""), ", ")));
}

}  // namespace kestrel
