// SPDX-License-Identifier: Apache-2.0
#include "scenarios/avoid/avoid.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "base/file/model_files.h"
#include "base/stopwatch.h"
#include "control/estimate/state_history.h"
#include "geometry/tait_bryan.h"
#include "mission/caption/caption.h"
#include "mission/command_arrows.h"
#include "scenarios/avoid/avoid_metrics.h"
#include "scenarios/avoid/avoid_plots.h"
#include "scenarios/avoid/avoid_report.h"
#include "scenarios/avoid/sight_mission.h"
#include "vision/capture/blank_image.h"
#include "vision/capture/frozen_image.h"
#include "vision/drawn_colours.h"

namespace kestrel::scenarios {
namespace {

constexpr double kYawGain_per_s = 1.2;
constexpr double kOnCourse_m = 0.5;  // from its line
constexpr double kArrived_m = 0.5;
constexpr double kBlind_s = 0.5;  // without sight it flies on no longer: who does not see must not go ahead
constexpr int kSightings = 5;     // before anybody is believed to be there
constexpr double kSlope = 0.2;    // of the climb or descent of the others, and of what is measured of them
constexpr double kSureOfMotion =
    0.5;                             // standard deviation of a velocity that is believed, as a share of that
constexpr double kSeen_s = 0.5;      // who was seen so lately is where it is said to be
constexpr double kStands_m_s = 0.3;  // what is slower than its speed is known stands still

class AvoidMission final : public mission::Mission {
 public:
  AvoidMission(const AvoidFlight& flight, const vision::CameraModel& camera, const Pose& X_BC,
               const cv::Mat& forbidden)
      : flight_(flight), camera_(camera), X_BC_(X_BC) {
    for (const mission::BalloonObserverParameters& mark : flight.marks)
      watches_.emplace_back(camera, X_BC, mark);
    if (flight.contrast) contrast_.emplace(camera, X_BC, forbidden, *flight.contrast);
    if (flight.decides_by == "growth") growth_.emplace(flight.growth, flight.avoidance, flight.confirm_s);
  }

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    const auto start = std::chrono::steady_clock::now();
    const bool frozen = frozen_.Is(frame.image);
    control::VehicleState seen_from = state;
    // Places relative to us, in units of which nobody knows how long they are: our own way cannot be taken out.
    if (growth_) seen_from.v_N.setZero();
    for (mission::BalloonObserver& watch : watches_) watch.Observe(frame, seen_from, frozen);
    if (contrast_) contrast_->Observe(frame, seen_from, frozen, flight_.memory_s);
    decision.vision_s = SecondsSince(start);
    history_.Add(state);
    state_ = state, exposed_ = history_.At(frame.t_s).value_or(state);
    if (!begin_) begin_ = state.p_NB, course_ = YawOf(state.R_NB);
    Look(state);
    blank_ = vision::Blank(frame.image);
    sees_ = !blank_ && (!contrast_ || contrast_->Sees()) &&
            std::all_of(watches_.begin(), watches_.end(),
                        [](const mission::BalloonObserver& w) { return w.Sees(); });
    if (sees_ || !saw_s_) saw_s_ = state.t_s;
    decision.target = Status();
    decision.fix_age_s = held_age_s_;
    const Eigen::Vector2d along = AlongCourse(state.p_NB.head<2>() - begin_->head<2>());
    if (along.x() > flight_.course_m - kArrived_m) {
      phase_ = "goal";
      decision.outcome = "goal reached";
      command_ = {};
    } else {
      Fly(state, along);
    }
    if (flight_.avoids && state.t_s - *saw_s_ > kBlind_s && phase_ != "goal") {
      phase_ = "blind";
      command_ = {};
    }
    decision.setpoint = command_;
    decision.phase = phase_;
    if (encounter_) {
      const auto report = std::make_shared<AvoidReport>();
      report->encounter = *encounter_;
      decision.report = report;
    }
    return decision;
  }

  bool Accomplished() const override { return phase_ == "goal"; }

  // That nobody is in sight is how it should be; when it sees nothing at all it stands still by itself.
  mission::TargetNeed Target() const override { return mission::TargetNeed::kNone; }

  void Change(const mission::Flight& flight, const mission::PilotParameters&) override {
    const auto* changed = flight.As<AvoidFlight>();
    if (!changed) return;
    flight_ = *changed;
    if (growth_) growth_->Change(flight_.growth, flight_.avoidance, flight_.confirm_s);
  }

  void Draw(cv::Mat& bgr) const override {
    for (const mission::BalloonObserver& watch : watches_) watch.Draw(bgr);
    if (contrast_) contrast_->Draw(bgr);
    mission::DrawCommand(
        bgr, command_,
        {{flight_.speed_m_s, 0, kClimbLimit_m_s}, Radians(flight_.avoidance.hold.yaw_rate_limit_deg_s)});
    if (!encounter_) return;
    const double to_other = YawOf(state_.R_NB) + encounter_->azimuth;
    DrawAzimuth(bgr, to_other, fmt::format("tb {:+.0f}", Degrees(encounter_->azimuth)), vision::kFixColour,
                2);
    if (encounter_->wanted)
      DrawAzimuth(bgr, YawOf(exposed_.R_NB) + *encounter_->wanted,
                  fmt::format("db {:+.0f}", Degrees(*encounter_->wanted)), vision::kSetpointColour, 2, false);
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = {{std::string(phase_)}, {fmt::format("other {}", Status())}};
    if (encounter_) {
      std::string text =
          fmt::format("bearing {:+.1f}{} deg", Degrees(encounter_->azimuth),
                      encounter_->wanted ? fmt::format(" ({:+.0f})", Degrees(*encounter_->wanted)) : "");
      if (encounter_->range_m)
        text += fmt::format("   {:.1f} m   nearest {:.1f} m", *encounter_->range_m, *encounter_->miss_m);
      if (encounter_->after_s) text += fmt::format(" in {:.1f} s", *encounter_->after_s);
      captions.push_back({text});
    }
    captions.push_back(
        {fmt::format("ahead {:+.2f} m/s  yaw {:+.1f} deg/s", command_.v_H.x(), Degrees(command_.yaw_rate))});
    return captions;
  }

 private:
  // A piece of the vertical plane at an azimuth from north, as the camera had it at the exposure.
  void DrawAzimuth(cv::Mat& bgr, double azimuth, const std::string& name, const cv::Scalar& colour,
                   int thickness, bool named_above = true) const {
    std::vector<cv::Point> line;
    for (double elevation = -10; elevation <= 10; elevation += 2) {
      const double e = Radians(elevation);
      const Eigen::Vector3d ray_N(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth),
                                  -std::sin(e));
      if (const auto at = vision::Project(camera_, (exposed_.R_NB * X_BC_.R).conjugate() * ray_N))
        line.emplace_back(cv::Point2d(at->x(), at->y()));
    }
    if (line.empty()) return;
    cv::polylines(bgr, line, false, {0, 0, 0}, thickness + 2, cv::LINE_AA);
    cv::polylines(bgr, line, false, colour, thickness, cv::LINE_AA);
    const cv::Point end = named_above ? line.back() + cv::Point(0, -6) : line.front() + cv::Point(0, 18);
    mission::NameMark(bgr, {std::clamp(end.x - 22, 2, std::max(2, bgr.cols - 56)), end.y}, name);
  }

  Eigen::Vector2d AlongCourse(const Eigen::Vector2d& v_N) const { return Eigen::Rotation2Dd(-course_) * v_N; }

  // Who is about, by what has been seen and how it went on.
  void Look(const control::VehicleState& state) {
    intruders_.clear(), sighted_.clear(), ids_.clear();
    for (std::size_t i = 0; i < watches_.size(); ++i)
      if (const auto& where = watches_[i].last_known()) Add(*where, i, state);
    if (contrast_)
      for (const auto& where : contrast_->Known()) Add(where, watches_.size(), state);
  }

  void Add(const control::MovingTarget::Estimate& where, std::size_t watch,
           const control::VehicleState& state) {
    if (where.age_s > flight_.memory_s || where.measurements < kSightings) return;
    if (growth_) {
      const Eigen::Vector3d p = where.p_N - state.p_NB;
      if (std::abs(p.z()) > (flight_.growth.miss_share + kSlope) * p.head<2>().norm()) return;
      const bool sure = where.v_sigma < kSureOfMotion * where.v_N.norm();
      sighted_.push_back({p.head<2>(), sure ? Eigen::Vector2d(where.v_N.head<2>()) : Eigen::Vector2d::Zero(),
                          sure && where.age_s < kSeen_s});
      ids_.push_back({watch, where.age_s});
      return;
    }
    // Who passes far above or below is no threat, and what is seen far below is often the ground.
    const control::AvoidanceOptions& o = flight_.avoidance;
    if (std::abs(where.p_N.z() - state.p_NB.z()) >
        o.clear_share * o.safe_m + kSlope * (where.p_N - state.p_NB).head<2>().norm())
      return;
    const bool stands = where.v_N.norm() < std::max(kStands_m_s, 2 * where.v_sigma);
    const Eigen::Vector3d p_N = where.p_N - (stands ? where.age_s : 0) * where.v_N;
    intruders_.push_back({(p_N - state.p_NB).head<2>(),
                          stands ? Eigen::Vector2d::Zero() : Eigen::Vector2d(where.v_N.head<2>())});
    ids_.push_back({watch, where.age_s});
  }

  std::string_view Status() const {
    if (blank_) return "blank";
    if (!sees_) {
      for (const mission::BalloonObserver& watch : watches_)
        if (!watch.Sees()) return watch.status();
      return contrast_->status();
    }
    return held_ < watches_.size() ? watches_[held_].status() : contrast_->status();
  }

  // Whether to avoid: begins with a threat that lasts, and ends when the way on has been clear for as long.
  // To be clear it must not lead nearer again than what was avoided has been, or it would be met twice.
  void Judge(const control::VehicleState& state, const Eigen::Vector2d& wanted_v) {
    control::AvoidanceOptions o = flight_.avoidance;
    double distance_m = (avoiding_ ? o.clear_share : 1) * o.safe_m;
    double range_m = std::numeric_limits<double>::infinity();
    for (const control::Intruder& i : intruders_) range_m = std::min(range_m, i.p.norm());
    if (avoiding_) {
      nearest_m_ = std::min(nearest_m_, range_m);
      o.horizon_s *= 2;
    }
    if (phase_ == "cruise") {
      nearest_m_ = std::numeric_limits<double>::infinity();
      keep_m_ = std::isfinite(range_m)
                    ? flight_.keep_share * range_m * std::sin(Radians(std::min(90.0, o.hold.bearing_deg)))
                    : 0;
    } else {
      distance_m = std::max(distance_m, std::min(keep_m_, nearest_m_));
    }
    const bool otherwise = control::Threatened(intruders_, wanted_v, distance_m, o) != avoiding_;
    if (!otherwise || !flight_.avoids)
      since_s_.reset();
    else if (!since_s_)
      since_s_ = state.t_s;
    if (!since_s_ || state.t_s - *since_s_ < flight_.confirm_s) return;
    avoiding_ = !avoiding_;
    side_.reset(), since_s_.reset();
  }

  // The yaw rate that holds another at a bearing; only ever away: held to the end, the bearing would lead
  // inwards (control/law/hold_bearing.h).
  double HoldAway(double azimuth, double bearing) {
    const bool left = bearing > 0;
    control::HoldBearingGains gains = flight_.avoidance.hold;
    gains.bearing_deg = Degrees(std::abs(bearing));
    const control::HoldBearingStep step = control::HoldBearing(
        {left ? control::PassingSide::kLeft : control::PassingSide::kRight}, azimuth, gains);
    const double yaw_rate = left ? std::min(step.yaw_rate, 0.0) : std::max(step.yaw_rate, 0.0);
    phase_ = yaw_rate == 0 ? "pass" : "avoid";
    return yaw_rate;
  }

  void Fly(const control::VehicleState& state, const Eigen::Vector2d& along) {
    const double yaw = YawOf(state.R_NB), speed = flight_.speed_m_s;
    const Eigen::Vector2d v = state.v_N.head<2>();
    // Back to the line at 45 degrees at most.
    const double back = std::asin(
        std::clamp(-flight_.cross_track_gain_per_s * along.y() / speed, -std::sqrt(0.5), std::sqrt(0.5)));
    const Eigen::Vector2d wanted_v =
        speed * Eigen::Vector2d(std::cos(course_ + back), std::sin(course_ + back));
    if (!growth_) Judge(state, wanted_v);

    double yaw_rate = kYawGain_per_s * WrapAngle(course_ + back - yaw);
    phase_ = std::abs(along.y()) > kOnCourse_m ? "return" : "cruise";
    encounter_.reset();
    if (const auto judged = growth_ && flight_.avoids
                                ? growth_->Judge(state.t_s, sighted_, yaw, course_ + back)
                                : std::nullopt) {
      if (judged->other) {
        const Eigen::Vector2d& p = sighted_[*judged->other].p;
        held_ = ids_[*judged->other].watch, held_age_s_ = ids_[*judged->other].age_s;
        encounter_ = Encounter{
            WrapAngle(std::atan2(p.y(), p.x()) - yaw), judged->hold, {}, {}, judged->approach.after_s};
        if (judged->hold) yaw_rate = HoldAway(encounter_->azimuth, *judged->hold);
      } else {
        yaw_rate = 0, phase_ = "pass";
      }
    }
    control::AvoidanceOptions o = flight_.avoidance;
    o.clear_share = std::max(o.clear_share, keep_m_ / o.safe_m);
    const Eigen::Vector2d flown_v = v.norm() > speed / 2 ? v : wanted_v;  // not yet at speed: as it will be
    if (const auto plan = control::PlanManoeuvre(intruders_, flown_v, yaw, side_, o)) {
      held_ = ids_[plan->intruder].watch, held_age_s_ = ids_[plan->intruder].age_s;
      const control::Intruder& other = intruders_[plan->intruder];
      const double azimuth = WrapAngle(std::atan2(other.p.y(), other.p.x()) - yaw);
      const control::ClosestApproach approach = control::ApproachOf(other.p, other.v - v);
      encounter_ = Encounter{azimuth, {}, other.p.norm(), approach.distance_m, approach.after_s};
      if (avoiding_) {
        side_ = plan->side;
        yaw_rate = HoldAway(azimuth, plan->bearing);
        encounter_->wanted = plan->bearing;
      }
    }
    const double limit = Radians(o.hold.yaw_rate_limit_deg_s);
    const double sink = kHeightGain_per_s * (begin_->z() - state.p_NB.z());
    command_ = {{speed, 0, std::clamp(sink, -kClimbLimit_m_s, kClimbLimit_m_s)},
                std::clamp(yaw_rate, -limit, limit)};
  }

  AvoidFlight flight_;
  vision::CameraModel camera_;
  Pose X_BC_;
  std::vector<mission::BalloonObserver> watches_;
  std::optional<ContrastObserver> contrast_;
  vision::FrozenImage frozen_;

  std::optional<Eigen::Vector3d> begin_;  // of the course, in N
  double course_ = 0;                     // rad, from north
  bool blank_ = false, sees_ = true;
  std::optional<double> saw_s_;
  std::optional<GrowthJudge> growth_;
  std::vector<control::Intruder> intruders_;
  std::vector<Sighted> sighted_;  // in their place, if it decides by growth
  struct Source {
    std::size_t watch;  // whose mark it carries; the number of marks: by contrast
    double age_s;       // since it was measured
  };
  std::vector<Source> ids_;  // of either
  std::size_t held_ = 0;     // what the log speaks of
  double held_age_s_ = 0;
  bool avoiding_ = false;
  double nearest_m_ = std::numeric_limits<double>::infinity();  // any has come in this manoeuvre
  double keep_m_ = 0;                                           // from all, by where the manoeuvre began
  std::optional<double> since_s_;  // it has been time to change between avoiding and not
  std::optional<control::PassingSide> side_;
  std::string_view phase_ = "cruise";
  std::optional<Encounter> encounter_;
  control::VelocitySetpoint command_;
  control::StateHistory history_;
  control::VehicleState state_, exposed_;  // of the last frame: when it was decided on, and at its exposure
};

}  // namespace

mission::MissionType TypeOf(const AvoidFlight&) {
  return {
      .name = "avoid",
      .summary = "Flies a course, passes intruders at a bearing that it holds, and returns to its course.",
      .needs_colour = true,
      .telemetry = AvoidColumns(),
      .metrics = AvoidMetrics(),
      .add_metrics = AddAvoidMetrics,
      .plots = {{"encounter.png", MeetsIntruders, EncounterPlot}},
      .changeable = {"flight.speed_m_s", "flight.course_m", "flight.avoids", "flight.memory_s",
                     "flight.confirm_s", "flight.keep_share", "flight.cross_track_gain_per_s",
                     "flight.avoidance.*", "flight.growth.*"}};
}

std::unique_ptr<mission::Mission> MakeMission(const AvoidFlight& flight, const mission::MissionParts& parts) {
  if (flight.decides_by == "sight") return MakeSightMission(flight, parts);
  return std::make_unique<AvoidMission>(flight, parts.camera, parts.X_BC, parts.own_parts);
}

void CheckFlight(const AvoidFlight& flight, const Place& where, Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.avoidance.hold.bearing_deg", flight.avoidance.hold.bearing_deg,
       flight.avoidance.max_bearing_deg, "flight.avoidance.max_bearing_deg");
  if (flight.decides_by == "sight" && (flight.marks.size() != 1 || flight.contrast))
    mistakes.Add(where, "flight.decides_by", "sight, and not by one mark alone",
                 "valid: flight.marks with one mark and no flight.contrast, or another flight.decides_by");
  if (flight.marks.empty() && !flight.contrast)
    mistakes.Add(where, "flight.marks", "is empty", "valid: at least one, or a flight.contrast");
  for (std::size_t i = 0; i < flight.marks.size(); ++i) {
    const vision::ColourRange& a = flight.marks[i].colour;
    mission::CheckColour(a, fmt::format("flight.marks.{}.colour", i), where, mistakes);
    for (std::size_t j = 0; j < i; ++j) {
      const vision::ColourRange& b = flight.marks[j].colour;
      const double apart_deg = std::abs(Degrees(WrapAngle(Radians(a.hue_deg - b.hue_deg))));
      if (apart_deg < a.hue_half_width_deg + b.hue_half_width_deg)
        mistakes.Add(where, fmt::format("flight.marks.{}.colour", i),
                     fmt::format("hues {:g} +- {:g} overlap those of mark {}, {:g} +- {:g}: two marks alike "
                                 "cannot be told apart",
                                 a.hue_deg, a.hue_half_width_deg, j, b.hue_deg, b.hue_half_width_deg),
                     "valid: hues of their own");
    }
  }
  if (!flight.contrast) return;
  const vision::ContrastTrackerOptions& tracker = flight.contrast->tracker;
  most("flight.contrast.tracker.confirm_sightings", tracker.confirm_sightings, tracker.confirm_images,
       "flight.contrast.tracker.confirm_images");
  most("flight.contrast.tracker.detector.min_diameter_px", tracker.detector.min_diameter_px,
       tracker.detector.max_diameter_px, "flight.contrast.tracker.detector.max_diameter_px");
}

void CheckFlightLimits(const AvoidFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.speed_m_s", flight.speed_m_s, limits.speed_m_s, "autopilot.speed_limit_m_s");
  most("flight.avoidance.hold.yaw_rate_limit_deg_s", flight.avoidance.hold.yaw_rate_limit_deg_s,
       limits.yaw_rate_deg_s, "autopilot.yaw_rate_limit_deg_s");
  most("flight.avoidance.acceleration_m_s2", flight.avoidance.acceleration_m_s2, limits.acceleration_m_s2,
       "autopilot.acceleration_limit_m_s2");
}

// Who is to be avoided comes from ahead.
void CheckFlightView(const AvoidFlight&, const vision::CameraModel& camera, const vision::CameraMount& mount,
                     const Place&, const Place& mount_where, Mistakes& mistakes) {
  const auto at = vision::Project(camera, vision::MountPose(mount).R.conjugate() * Eigen::Vector3d::UnitX());
  if (!at || at->x() < 0 || at->y() < 0 || at->x() > vision::WidthPx(camera) - 1 ||
      at->y() > vision::HeightPx(camera) - 1)
    mistakes.Add(
        mount_where, "mount.pitch_deg",
        fmt::format("{:g}: the camera does not see straight ahead, where others come from", mount.pitch_deg),
        "valid: one that does (90 looks ahead)");
}

bool FlightCanHave(const AvoidFlight&, const std::string&, const mission::Varies& varies) {
  return varies("targets");
}

}  // namespace kestrel::scenarios
