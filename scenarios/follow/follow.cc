// SPDX-License-Identifier: Apache-2.0
#include "scenarios/follow/follow.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/stopwatch.h"
#include "control/estimate/late_following.h"
#include "control/estimate/state_history.h"
#include "control/law/sphere_target.h"
#include "geometry/tait_bryan.h"
#include "mission/balloon_observer.h"
#include "mission/command_arrows.h"
#include "scenarios/follow/follow_metrics.h"
#include "scenarios/follow/follow_plots.h"
#include "scenarios/follow/follow_report.h"
#include "vision/capture/frozen_image.h"
#include "vision/drawn_colours.h"

namespace kestrel::scenarios {
namespace {

constexpr double kBackOff_m_s = 0.5;  // from a balloon that fills the image

class FollowMission final : public mission::Mission {
 public:
  FollowMission(const FollowFlight& flight, const vision::CameraModel& camera, const Pose& X_BC)
      : flight_(flight),
        camera_(camera),
        X_BC_(X_BC),
        focal_px_(vision::Parameters(camera)[0]),
        watch_(
            camera, X_BC, flight.balloon,
            flight.features.outline ? vision::BalloonMeasure::kOutline : vision::BalloonMeasure::kCamShift) {}

  mission::Decision Step(const vision::Frame& frame, const control::VehicleState& state) override {
    mission::Decision decision;
    const auto start = std::chrono::steady_clock::now();
    watch_.Observe(frame, state, frozen_.Is(frame.image));
    decision.vision_s = SecondsSince(start);
    decision.target = watch_.status();
    decision.target_state = watch_.target_state();
    decision.fix_age_s = watch_.age_s();
    X_NC_ = Pose{state.R_NB, state.p_NB} * X_BC_;
    yaw_ = YawOf(state.R_NB);
    history_.Add(state);
    following_.Hear(state);
    turning_.Hear(state.t_s, {0, 0, state.w_B.z()});
    exposed_R_NB_ = history_.At(frame.t_s).value_or(state).R_NB;
    sight_.reset();
    wanted_ = WantedAt(state.t_s);
    balloon_ = flight_.features.filter ? Filtered() : AsSeen(frame, state);
    if (balloon_) {
      decision.setpoint = Follow(state);
      const Eigen::Vector3d asked_N = HeadingRotation(yaw_) * command_.v_H;
      following_.Give(asked_N, asked_N);
      const Eigen::Vector3d turn(0, 0, command_.yaw_rate);
      turning_.Give(turn, turn);
      if (sight_) {
        const auto report = std::make_shared<FollowReport>();
        report->sight = *sight_;
        decision.report = report;
      }
    } else if (watch_.state() == vision::TrackState::kTooClose) {
      phase_ = "too close";
      lost_since_s_.reset();
      command_ = {{-kBackOff_m_s, 0, 0}, 0};
      decision.setpoint = command_;
    } else {
      decision.setpoint = LookForIt(state);
      if (state.t_s - *lost_since_s_ > flight_.look_around.give_up_s) decision.outcome = "balloon not found";
    }
    decision.phase = phase_;
    return decision;
  }

  bool Accomplished() const override { return balloon_.has_value(); }

  mission::TargetNeed Target() const override { return mission::TargetNeed::kInSight; }

  // Of the vertical velocity, by which the image's height is held; the law reckons with velocity_response_s.
  control::VelocityLag MaxLag() const override {
    return {.vertical_s =
                flight_.gains.velocity_response_s + kestrel::control::MaxLag(flight_.gains.lambda_per_s[1])};
  }

  void Change(const mission::Flight& flight, const mission::PilotParameters&) override {
    if (const auto* changed = flight.As<FollowFlight>()) flight_ = *changed;
  }

  void Draw(cv::Mat& bgr) const override {
    watch_.Draw(bgr);
    DrawWanted(bgr);
    mission::DrawCommand(bgr, command_,
                         {{flight_.gains.speed_limit_m_s, 0, flight_.gains.climb_limit_m_s}, YawLimit()});
  }
  std::vector<mission::Caption> Captions() const override {
    std::vector<mission::Caption> captions = {{std::string(phase_)},
                                              {fmt::format("balloon {}", watch_.status()), !sight_}};
    if (sight_)
      captions.push_back({fmt::format(
          "u {:+.1f} ({:+.0f})  v {:+.1f} ({:+.0f})  diameter {:.1f} ({:.0f}) px  {:.2f} m",
          focal_px_ * sight_->now.s.x(), focal_px_ * wanted_.s.x(), focal_px_ * sight_->now.s.y(),
          focal_px_ * wanted_.s.y(), focal_px_ * sight_->now.diameter, focal_px_ * wanted_.diameter,
          control::SphereDepth(sight_->now, flight_.balloon.diameter_m))});
    captions.push_back({fmt::format("ahead {:+.2f}  down {:+.2f} m/s  yaw {:+.1f} deg/s", command_.v_H.x(),
                                    command_.v_H.z(), Degrees(command_.yaw_rate))});
    return captions;
  }

 private:
  struct Balloon {
    Eigen::Vector3d p_N, v_N;
  };

  std::optional<Balloon> Filtered() const {
    if (!watch_.HasEstimate()) return std::nullopt;
    return Balloon{watch_.where().p_N, watch_.where().v_N};
  }

  // Thesis 5.4: the last image of it as if it were that of now, Z = D / diameter, and no motion.
  std::optional<Balloon> AsSeen(const vision::Frame& frame, const control::VehicleState& state) {
    if (const auto features = watch_.features()) {
      const Eigen::Vector3d& xyd = features->xyd;
      const Eigen::Vector3d p_C = flight_.balloon.diameter_m / xyd.z() * Eigen::Vector3d(xyd.x(), xyd.y(), 1);
      const Eigen::Vector3d p_B = X_BC_.R * p_C;
      seen_H_ = flight_.features.level
                    ? HeadingRotation(YawOf(exposed_R_NB_)).conjugate() * (exposed_R_NB_ * p_B)
                    : p_B;
      seen_s_ = frame.t_s;
    }
    if (!seen_s_ || state.t_s - *seen_s_ >= flight_.balloon.coast_s) return std::nullopt;
    return Balloon{X_NC_.p + HeadingRotation(yaw_) * seen_H_, Eigen::Vector3d::Zero()};
  }

  control::SphereImage WantedAt(double t_s) const {
    const FollowReference* now = &flight_.reference.front();
    for (const FollowReference& reference : flight_.reference)
      if (reference.from_s <= t_s) now = &reference;
    return {Eigen::Vector2d(now->u_px, now->v_px) / focal_px_, now->diameter_px / focal_px_};
  }

  control::Setpoint Follow(const control::VehicleState& state) {
    phase_ = "follow";
    lost_since_s_.reset();
    const FollowGains& g = flight_.gains;
    const double D = flight_.balloon.diameter_m;
    command_ = {};
    const Eigen::Vector3d now_V = control::LevelAhead(balloon_->p_N, X_NC_.p, yaw_);
    side_ = now_V.x() < 0 ? -1 : 1;
    // By when it answers: at the rate that it has, or, where the autopilot turns out to be late, at those it was given.
    const double turned = turning_.climb_s() > 0 ? turning_.ToCome_N().z() : g.yaw_response_s * state.w_B.z();
    const Eigen::Vector3d v_T_N = g.feed_forward ? balloon_->v_N : Eigen::Vector3d::Zero();
    const Eigen::Vector3d ahead_N = Ahead_N(state, v_T_N);
    const Eigen::Vector3d ahead_V = control::LevelAhead(ahead_N, X_NC_.p, yaw_ + turned);
    if (now_V.z() < D || ahead_V.z() < D) {  // beside or behind: only a turn brings it back into view
      command_.yaw_rate = side_ * YawLimit();
      return command_;
    }
    sight_ = BalloonSight{control::SphereImageOf(now_V, D), wanted_, focal_px_};
    const control::SphereImage ahead = control::SphereImageOf(ahead_V, D);
    Eigen::Vector3d drift = Eigen::Vector3d::Zero();
    if (g.feed_forward) {
      const Eigen::Vector3d v_T = control::LevelAhead(v_T_N, Eigen::Vector3d::Zero(), yaw_ + turned);
      const Eigen::Vector3d v_own = control::LevelAhead(state.v_N, Eigen::Vector3d::Zero(), yaw_ + turned);
      // Sideways the law commands nothing, but the aircraft may move.
      drift = control::SphereDrift(ahead, ahead_V.z(), {v_T.x() - v_own.x(), v_T.y(), v_T.z()});
    }
    const auto coupling =
        flight_.law == "decoupled" ? control::FollowCoupling::kDecoupled : control::FollowCoupling::kCoupled;
    const control::FollowStep step =
        control::FollowVelocity(ahead, wanted_, ahead_V.z(), coupling, g.lambda_per_s, drift);
    command_.v_H = {std::clamp(step.velocity[1], -g.speed_limit_m_s, g.speed_limit_m_s), 0,
                    std::clamp(step.velocity[0], -g.climb_limit_m_s, g.climb_limit_m_s)};
    if (-state.p_NB.z() < g.min_height_m) command_.v_H.z() = std::min(command_.v_H.z(), 0.0);
    command_.yaw_rate = std::clamp(step.velocity[2], -YawLimit(), YawLimit());
    return command_;
  }

  // Where the balloon is, less the way that the aircraft has gone, by when it answers: at the velocity that it has,
  // or, where the autopilot turns out to be late, at those that it was given.
  Eigen::Vector3d Ahead_N(const control::VehicleState& state, const Eigen::Vector3d& v_T_N) const {
    const double response_s = flight_.gains.velocity_response_s;
    Eigen::Vector3d ahead_N = balloon_->p_N + response_s * (v_T_N - state.v_N);
    const Eigen::Vector3d to_come_N = following_.ToCome_N();
    const double level_s = following_.level_s(), climb_s = following_.climb_s();
    if (level_s > 0) ahead_N.head<2>() = (balloon_->p_N + level_s * v_T_N - to_come_N).head<2>();
    if (climb_s > 0) ahead_N.z() = balloon_->p_N.z() + climb_s * v_T_N.z() - to_come_N.z();
    return ahead_N;
  }

  control::Setpoint LookForIt(const control::VehicleState& state) {
    if (!lost_since_s_) lost_since_s_ = state.t_s;
    const double lost_s = state.t_s - *lost_since_s_;
    const LookAround& look = flight_.look_around;
    // A picture in which nothing can be told from anything says nothing new from another side either.
    const bool turns = lost_s > look.stop_s && watch_.state() != vision::TrackState::kAmbiguous;
    phase_ = turns ? "look around" : "stop";
    command_ = {Eigen::Vector3d::Zero(), turns ? side_ * Radians(look.turn_deg_s) : 0};
    return command_;
  }

  double YawLimit() const { return Radians(flight_.gains.yaw_rate_limit_deg_s); }

  // The image wanted, as the camera would have had it at the exposure: a circle about a cross.
  void DrawWanted(cv::Mat& bgr) const {
    const cv::Scalar& colour = vision::kSetpointColour;
    const Eigen::Quaterniond R_NH = HeadingRotation(YawOf(exposed_R_NB_)), R_NC = exposed_R_NB_ * X_BC_.R;
    const auto at = [&](const Eigen::Vector2d& s) {
      return vision::Project(camera_, R_NC.conjugate() * (R_NH * Eigen::Vector3d(1, s.x(), s.y())));
    };
    constexpr int kPieces = 60;
    for (int i = 0; i < kPieces; i += 2) {
      const auto point = [&](int k) {
        const double a = 2 * M_PI * k / kPieces;
        return at(wanted_.s + wanted_.diameter / 2 * Eigen::Vector2d(std::cos(a), std::sin(a)));
      };
      if (const auto a = point(i), b = point(i + 1); a && b)
        cv::line(bgr, cv::Point2d(a->x(), a->y()), cv::Point2d(b->x(), b->y()), colour, 1, cv::LINE_AA);
    }
    if (const auto middle = at(wanted_.s))
      cv::drawMarker(bgr, cv::Point2d(middle->x(), middle->y()), colour, cv::MARKER_CROSS, 12, 1,
                     cv::LINE_AA);
  }

  FollowFlight flight_;
  vision::CameraModel camera_;
  Pose X_BC_;
  double focal_px_;
  mission::BalloonObserver watch_;
  vision::FrozenImage frozen_;

  std::string_view phase_ = "stop";
  Pose X_NC_;  // now, by the autopilot
  control::StateHistory history_;
  control::LateFollowing following_, turning_{control::LateFollowing::OfTurns()};
  Eigen::Quaterniond exposed_R_NB_ = Eigen::Quaterniond::Identity();  // when the last image was exposed
  double yaw_ = 0;
  std::optional<Balloon> balloon_;  // as it is reckoned with now; none: it is lost
  // Without a filter, by the last image that shows it: where it was in H, off the camera, and when.
  Eigen::Vector3d seen_H_ = Eigen::Vector3d::Zero();
  std::optional<double> seen_s_;
  double side_ = 1;  // where it was last: 1 right, -1 left
  control::SphereImage wanted_;
  std::optional<BalloonSight> sight_;
  control::VelocitySetpoint command_;
  std::optional<double> lost_since_s_;
};

}  // namespace

mission::MissionType TypeOf(const FollowFlight&) {
  return {.name = "follow",
          .summary = "Follows a coloured balloon by the centre and the diameter of its image.",
          .needs_colour = true,
          .telemetry = FollowColumns(),
          .metrics = FollowMetrics(),
          .add_metrics = AddFollowMetrics,
          .plots = {{"follow.png", FollowsBalloon, FollowPlot}},
          .changeable = {"flight.gains.*", "flight.reference.*", "flight.look_around.*"}};
}

std::unique_ptr<mission::Mission> MakeMission(const FollowFlight& flight,
                                              const mission::MissionParts& parts) {
  return std::make_unique<FollowMission>(flight, parts.camera, parts.X_BC);
}

void CheckFlight(const FollowFlight& flight, const Place& where, Mistakes& mistakes) {
  if (flight.reference.empty()) mistakes.Add(where, "flight.reference", "is empty", "valid: at least one");
  mission::CheckColour(flight.balloon.colour, "flight.balloon.colour", where, mistakes);
  if (!flight.features.filter && flight.gains.feed_forward)
    mistakes.Add(where, "flight.gains.feed_forward",
                 "true, but without flight.features.filter nobody knows the balloon's motion",
                 "valid: false, or flight.features.filter: true");
}

void CheckFlightLimits(const FollowFlight& flight, const mission::AircraftLimits& limits, const Place& where,
                       Mistakes& mistakes) {
  const NoMoreThan most{where, mistakes};
  most("flight.gains.speed_limit_m_s", flight.gains.speed_limit_m_s, limits.speed_m_s,
       "autopilot.speed_limit_m_s");
  most("flight.gains.climb_limit_m_s", flight.gains.climb_limit_m_s, limits.climb_m_s,
       "autopilot.climb_limit_m_s");
  most("flight.gains.yaw_rate_limit_deg_s", flight.gains.yaw_rate_limit_deg_s, limits.yaw_rate_deg_s,
       "autopilot.yaw_rate_limit_deg_s");
}

// A balloon can be wanted only where the camera sees it, at least from a level aircraft.
void CheckFlightView(const FollowFlight& flight, const vision::CameraModel& camera,
                     const vision::CameraMount& mount, const Place& where, const Place&, Mistakes& mistakes) {
  constexpr int kPoints = 72;  // of the circle
  const double focal_px = vision::Parameters(camera)[0];
  const Eigen::Quaterniond R_CB = vision::MountPose(mount).R.conjugate();
  const auto seen = [&](const FollowReference& r, double angle) {
    const double radius_px = r.diameter_px / 2;
    const Eigen::Vector3d ahead(focal_px, r.u_px + radius_px * std::cos(angle),
                                r.v_px + radius_px * std::sin(angle));
    const auto at = vision::Project(camera, R_CB * ahead);
    return at && at->x() >= 0 && at->y() >= 0 && at->x() <= vision::WidthPx(camera) - 1 &&
           at->y() <= vision::HeightPx(camera) - 1;
  };
  for (std::size_t i = 0; i < flight.reference.size(); ++i) {
    const FollowReference& r = flight.reference[i];
    const std::string key = fmt::format("flight.reference.{}", i);
    if (i > 0 && r.from_s <= flight.reference[i - 1].from_s)
      mistakes.Add(where, key + ".from_s", fmt::format("{:g} is not after the one before", r.from_s),
                   fmt::format("valid: above {:g}", flight.reference[i - 1].from_s));
    bool whole = true;
    for (int k = 0; k < kPoints && whole; ++k) whole = seen(r, 2 * M_PI * k / kPoints);
    if (!whole)
      mistakes.Add(
          where, key,
          fmt::format("u_px {:g}, v_px {:g} and diameter_px {:g} are a circle beyond the image of {} x {} "
                      "px, by this camera as it is mounted",
                      r.u_px, r.v_px, r.diameter_px, vision::WidthPx(camera), vision::HeightPx(camera)),
          "valid: one within it, nearer to the middle or smaller, and a camera that looks ahead");
  }
}

bool FlightCanHave(const FollowFlight& flight, const std::string& metric, const mission::Varies& varies) {
  // Whether references differ by a field, so that there are steps of it.
  const auto steps = [&](double FollowReference::*field) {
    return varies("flight.reference") ||
           std::any_of(flight.reference.begin(), flight.reference.end(), [&](const FollowReference& each) {
             return each.*field != flight.reference.front().*field;
           });
  };
  if (metric.starts_with("step_u_")) return steps(&FollowReference::u_px);
  if (metric.starts_with("step_distance_")) return steps(&FollowReference::diameter_px);
  return true;
}

}  // namespace kestrel::scenarios
