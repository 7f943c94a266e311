// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "base/gravity.h"
#include "base/stopwatch.h"
#include "control/estimate/moving_target.h"
#include "geometry/tait_bryan.h"
#include "sim/instrument/beam.h"
#include "sim/world/frames.h"

namespace kestrel::sim {
namespace {

constexpr double kAirborne_m = 0.3;
constexpr double kFixedAfter_s = 0.3;  // of standing on a deck that holds it fast
constexpr char kNavigation[] = "navigation";
constexpr std::int64_t kNever = CameraClock::kNever;

SceneParameters SceneOf(const SimulatorParameters& parameters) {
  SceneParameters scene = parameters.scene;
  scene.occluder = parameters.occlusion.share > 0;
  scene.targets = parameters.targets;
  if (const auto& ground = parameters.ground) {
    scene.lights = ground->lights;
    scene.blind = !ground->view.blocked.empty();
  }
  return scene;
}

SimulatorParameters WithScatterDrawn(SimulatorParameters parameters, const CameraError& error) {
  parameters.image = DrawScatter(parameters.image, parameters.seed);
  parameters.camera = error.Of(parameters.camera);
  return parameters;
}

ModelPtr ModelOf(const SimulatorParameters& parameters) {
  ModelPtr model = MakeModel(SceneOf(parameters));
  if (parameters.step_s) model->opt.timestep = *parameters.step_s;
  return model;
}

}  // namespace

struct Simulator::Hashes {
  XXH3_state_t *state = XXH3_createState(), *image = XXH3_createState();
  Hashes() {
    XXH3_64bits_reset(state);
    XXH3_64bits_reset(image);
  }
  ~Hashes() {
    XXH3_freeState(state);
    XXH3_freeState(image);
  }
};

Simulator::Simulator(const SimulatorParameters& parameters)
    : camera_error_(parameters.camera_error, parameters.seed),
      parameters_(WithScatterDrawn(parameters, camera_error_)),
      model_(ModelOf(parameters)),
      data_(MakeData(model_.get())),
      vehicle_(MakeAirframe(parameters.vehicle, model_.get(), !parameters.start.on_ground)),
      wind_(parameters.wind, parameters.seed),
      sensors_(parameters.sensors, parameters.seed),
      sensor_faults_(parameters.sensors.faults, parameters.seed),
      X_BC_(camera_error_.Of(vision::MountPose(parameters.mount))),
      vibration_(parameters.mount.vibration, parameters.seed),
      renderer_(parameters.images
                    ? std::make_unique<FrameRenderer>(model_.get(), parameters_.camera, parameters.render,
                                                      parameters_.image, X_BC_, vibration_, parameters.seed,
                                                      parameters.surfaces, parameters.draw_beside)
                    : nullptr),
      hashes_(std::make_unique<Hashes>()),
      scheduled_(ChangesOf(parameters.sensors.faults, parameters.actuators.faults, parameters.vehicle)),
      clock_(parameters_.image, vision::HeightPx(parameters.camera), parameters.seed, parameters.duration_s,
             model_->opt.timestep) {
  std::reverse(scheduled_.begin(), scheduled_.end());
  mj_forward(model_.get(), data_.get());
  contact_search_.emplace(model_.get(), data_.get());
  const Pose X_NT = PadPose(model_.get(), data_.get());
  if (parameters.ground)
    ground_ = std::make_unique<SimulatedGroundCamera>(model_.get(), X_NT, *parameters.ground,
                                                      parameters.render, parameters.seed,
                                                      parameters.duration_s, parameters.draw_beside);
  if (parameters.events)
    events_ = std::make_unique<EventRenderer>(model_.get(), parameters_.camera, parameters.render,
                                              parameters_.image, X_BC_, vibration_, *parameters.events,
                                              parameters.seed);
  if (parameters.instruments.any()) {
    instruments_ = std::make_unique<Instruments>(parameters.instruments, parameters.seed);
    beam_ = BeamIn(model_.get(), data_.get());
  }
  for (const CarriedCameraParameters& camera : parameters.cameras)
    cameras_.push_back(std::make_unique<CarriedCamera>(
        model_.get(), camera, parameters.render, parameters.seed, parameters.duration_s,
        CarriedCameraOptions{parameters.images, parameters.surfaces, parameters.draw_beside}));
  const StartParameters& start = parameters.start;
  RandomStream random(parameters.seed, "start");
  const double radius = start.scatter_m * std::sqrt(random.Uniform(0, 1));
  const double direction = random.Uniform(0, 2 * std::numbers::pi);
  Pose X_NB;
  X_NB.p << X_NT.p.head<2>() + start.offset_m +
                radius * Eigen::Vector2d(std::cos(direction), std::sin(direction)),
      X_NT.p.z() - start.height_m;
  X_NB.R = HeadingRotation(Radians(start.yaw_deg + start.yaw_scatter_deg * random.Uniform(-1, 1)));
  if (start.on_ground) {
    // The lowest point of the aircraft's contact geoms stands on the pad.
    X_NB.p.z() = X_NT.p.z();
    PoseToMujoco(X_NB, data_->qpos);
    mj_kinematics(model_.get(), data_.get());
    double lowest = 0;
    for (int g = 0; g < model_->ngeom; ++g) {
      if (model_->body_rootid[model_->geom_bodyid[g]] != mj_name2id(model_.get(), mjOBJ_BODY, "vehicle"))
        continue;
      if (model_->geom_contype[g] == 0 && model_->geom_conaffinity[g] == 0) continue;
      const double below = -(data_->geom_xpos[3 * g + 2] - model_->geom_size[3 * g]) - X_NB.p.z();
      lowest = std::max(lowest, below);
    }
    X_NB.p.z() -= lowest;
  }
  if (parameters.carry) X_NB = carried_.emplace(*parameters.carry, parameters.seed).X_NB(-start.settle_s);
  PoseToMujoco(X_NB, data_->qpos);
  mj_forward(model_.get(), data_.get());

  // The gyroscopes' bias, averaged over two seconds at rest before the flight.
  Sensors at_rest = sensors_;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  const double dt = model_->opt.timestep;
  const int samples = static_cast<int>(std::lround(2 / dt));
  for (int i = 0; i < samples; ++i) {
    bias += at_rest.Read(dt, X_NB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), {0, 0, -kGravity_m_s2})
                .imu.w_B /
            samples;
  }
  autopilot_ =
      std::make_unique<EmulatedAutopilot>(parameters.autopilot, parameters.sensors, parameters.vehicle, X_NB,
                                          !start.on_ground && !carried_, bias);
  for (std::size_t i = 0; i < parameters.targets.size(); ++i)
    PlaceTarget(model_.get(), data_.get(), i,
                targets_.emplace_back(parameters.targets[i], parameters.seed, i));
  steps_ = -std::lround(start.settle_s / dt);
  if (parameters.scene.deck) {
    deck_.emplace(*parameters.scene.deck, X_NT, parameters.seed, static_cast<double>(steps_) * dt, dt);
    PlaceDeck(model_.get(), data_.get(), deck_->now());
  }
  if (carried_) Carry();
  autopilot_->SetClock(static_cast<double>(steps_) * dt);
  truth_ = Look();
  airborne_ = !start.on_ground;
  RunCamera();
  AdvanceTo(0);
}

Simulator::~Simulator() = default;

Truth Simulator::Look() const {
  Truth t;
  t.t_s = static_cast<double>(steps_) * model_->opt.timestep;
  t.X_NB = PoseFromMujoco(data_->qpos);
  t.v_N = VectorFromMujoco(data_->qvel);
  t.w_B = VectorFromMujoco(data_->qvel + 3);
  t.wind_N = wind_.Velocity();
  t.attitude_failed = FaultAt(parameters_.sensors.attitude_faults, t.t_s) != nullptr;
  if (deck_) {
    t.X_NT = deck_->now().X_NT;
    t.v_NT = deck_->now().v_N;
    t.w_NT = deck_->now().w_N;
  } else {
    t.X_NT = PadPose(model_.get(), data_.get());
  }
  const int vehicle = mj_name2id(model_.get(), mjOBJ_BODY, "vehicle");
  const Pose X_NC = t.X_NB * X_BC_;
  t.X_NC = vibration_.still() ? X_NC : X_NC * vibration_.At(t.t_s);
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    const Eigen::Vector3d p_C = X_NC.Inverse() * targets_[i].p_N();
    const auto uv = vision::Project(parameters_.camera, p_C);
    const bool in_view = uv && uv->x() > -0.5 && uv->y() > -0.5 &&
                         uv->x() < vision::WidthPx(parameters_.camera) - 0.5 &&
                         uv->y() < vision::HeightPx(parameters_.camera) - 0.5;
    t.targets.push_back({parameters_.targets[i].diameter_m, targets_[i].p_N(), targets_[i].v_N(),
                         control::LevelAhead(targets_[i].p_N(), X_NC.p, YawOf(t.X_NB.R)), in_view});
  }
  for (int c = 0; c < data_->ncon; ++c) {
    const mjContact& contact = data_->contact[c];
    if (contact.exclude == 0 && (model_->body_rootid[model_->geom_bodyid[contact.geom1]] == vehicle ||
                                 model_->body_rootid[model_->geom_bodyid[contact.geom2]] == vehicle)) {
      t.touching = true;
    }
  }
  return t;
}

// One step: wind, the forces it makes with the rotors, the physics, the sensors, the autopilot.
void Simulator::Step() {
  const double dt = model_->opt.timestep;
  const Truth before = truth_;
  wind_.Step(dt, before.X_NT.p.z() - before.X_NB.p.z(), before.v_N);
  if (!parameters_.actuators.faults.empty())
    SetConditions(vehicle_, ConditionsAt(parameters_.actuators.faults, before.t_s));
  Apply(vehicle_, data_.get(), dt, wind_.Velocity(), SurfaceBelow_m());
  MoveTargets();
  contact_search_->Set(model_.get(), data_.get());
  mj_step(model_.get(), data_.get());
  ++steps_;
  if (deck_) MoveDeck();
  if (carried_) Carry();
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_BADCTRL}) {
    if (data_->warning[warning].number > 0) {
      throw RunError(fmt::format("at {:.3f} s: the physical state of the aircraft is not a number ({})",
                                 before.t_s, mju_warningText(warning, data_->warning[warning].lastinfo)));
    }
  }
  if (platform_) {
    const control::VehicleState state = State();
    platform_->Step(dt, {state.R_NB, state.p_NB});
    X_BC_ = camera_error_.Of(platform_->X_BC());
  }
  truth_ = Look();
  if (instruments_) instruments_->Step(before, truth_, beam_);
  const Eigen::Vector3d specific_force_B =
      truth_.X_NB.R.conjugate() * ((truth_.v_N - before.v_N) / dt - Eigen::Vector3d(0, 0, kGravity_m_s2));
  SensorReadings readings = sensors_.Read(dt, truth_.X_NB, truth_.v_N, truth_.w_B, specific_force_B);
  Disturb(vehicle_, readings);
  sensor_faults_.Apply(truth_.t_s, readings);
  Actuation actuation = autopilot_->Step(dt, readings);
  if (external_ != nullptr) {
    const std::optional<Actuation> outside = external_->Step(dt, readings, truth_);
    ended_ = !outside;
    actuation = outside.value_or(Stopped(parameters_.vehicle));
  }
  Command(vehicle_, actuation);
  if (!State().R_NB.coeffs().allFinite() || !State().p_NB.allFinite()) {
    throw RunError(fmt::format("at {:.3f} s: the autopilot's estimate is not a number", truth_.t_s));
  }
  NoteChanges();
  airborne_ = airborne_ || truth_.X_NT.p.z() - truth_.X_NB.p.z() > kAirborne_m;
  if (!touch_ && airborne_ && truth_.touching && !before.touching && truth_.t_s > 0) touch_ = before;
}

void Simulator::ChangeDaylight(double daylight) { parameters_.render.daylight = daylight; }
void Simulator::Change(const WindParameters& wind) { wind_.Change(wind); }

void Simulator::Change(const std::vector<TargetParameters>& targets) {
  for (std::size_t i = 0; i < targets_.size(); ++i) targets_[i].Change(targets[i], truth_.t_s);
}

void Simulator::Change(const std::vector<CameraFault>& faults) {
  clock_.ChangeFaults({faults, parameters_.seed, parameters_.duration_s}, truth_.t_s);
}

void Simulator::Change(const std::vector<SensorFault>& faults, const std::vector<AttitudeFault>& attitude) {
  parameters_.sensors.faults = faults;
  parameters_.sensors.attitude_faults = attitude;
  sensor_faults_.Change(faults);
  autopilot_->ChangeFaults(attitude);
  ScheduleFaults();
}

void Simulator::Change(const ActuatorParameters& actuators) {
  parameters_.actuators = actuators;
  SetConditions(vehicle_, ConditionsAt(actuators.faults, truth_.t_s));
  ScheduleFaults();
}

// After a change of the faults.
void Simulator::ScheduleFaults() {
  std::map<std::string, std::string> is;
  for (const StateChange& change : state_changes_)
    if (change.what != kNavigation) is[change.what] = change.is;
  scheduled_ = ChangesOf(parameters_.sensors.faults, parameters_.actuators.faults, parameters_.vehicle);
  const auto later = std::find_if(scheduled_.begin(), scheduled_.end(),
                                  [&](const StateChange& change) { return change.t_s > truth_.t_s + 1e-9; });
  std::map<std::string, std::string> will_be;
  for (const auto& [what, state] : is) will_be[what] = "ok";
  for (auto past = scheduled_.begin(); past != later; ++past) will_be[past->what] = past->is;
  for (const auto& [what, state] : will_be)
    if (const auto before = is.find(what); state != (before == is.end() ? "ok" : before->second))
      state_changes_.push_back({truth_.t_s, what, state});
  scheduled_.erase(scheduled_.begin(), later);
  std::reverse(scheduled_.begin(), scheduled_.end());
}

void Simulator::NoteChanges() {
  for (; !scheduled_.empty() && scheduled_.back().t_s <= truth_.t_s + 1e-9; scheduled_.pop_back())
    state_changes_.push_back(scheduled_.back());
  const NavigationHealth health = autopilot_->Health();
  if (external_ != nullptr || health == health_) return;  // what does not fly navigates nobody
  health_ = health;
  state_changes_.push_back({truth_.t_s, kNavigation, NameOf(health)});
}

// To where they are after this step.
void Simulator::MoveTargets() {
  const double dt = model_->opt.timestep;
  for (std::size_t i = 0; i < targets_.size(); ++i) {
    targets_[i].Step(static_cast<double>(steps_ + 1) * dt, dt, wind_.Velocity());
    PlaceTarget(model_.get(), data_.get(), i, targets_[i]);
  }
}

// To where the hands have it after this step, whatever pushed it meanwhile.
void Simulator::Carry() {
  const double dt = model_->opt.timestep, t_s = static_cast<double>(steps_) * dt;
  const Pose before = carried_->X_NB(t_s - dt), after = carried_->X_NB(t_s + dt);
  PoseToMujoco(carried_->X_NB(t_s), data_->qpos);
  VectorToMujoco((after.p - before.p) / (2 * dt), data_->qvel);
  VectorToMujoco(LogRotation(before.R.conjugate() * after.R) / (2 * dt), data_->qvel + 3);
}

// To where it is after this step, whatever stood on it; and with it what it holds fast.
void Simulator::MoveDeck() {
  deck_->Step();
  PlaceDeck(model_.get(), data_.get(), deck_->now());
  if (parameters_.scene.deck->hold != "fixed") return;
  const DeckMotion& deck = deck_->now();
  const double t_s = static_cast<double>(steps_) * model_->opt.timestep;
  if (!touch_ || !truth_.touching) stands_since_s_ = t_s;
  if (!X_TB_fixed_ && t_s - stands_since_s_ >= kFixedAfter_s)
    X_TB_fixed_ = deck.X_NT.Inverse() * PoseFromMujoco(data_->qpos);
  if (!X_TB_fixed_) return;
  const Pose X_NB = deck.X_NT * *X_TB_fixed_;
  PoseToMujoco(X_NB, data_->qpos);
  VectorToMujoco(deck.v_N + deck.w_N.cross(X_NB.p - deck.X_NT.p), data_->qvel);
  VectorToMujoco(X_NB.R.conjugate() * deck.w_N, data_->qvel + 3);
}

// Of what makes the ground effect: the pad's plane, or off a deck's plate the ground.
double Simulator::SurfaceBelow_m() const {
  const double pad_m = -truth_.X_NT.p.z();
  if (!deck_) return pad_m;
  const Eigen::Vector3d p_TB = truth_.X_NT.Inverse() * truth_.X_NB.p;
  return p_TB.head<2>().cwiseAbs().maxCoeff() < parameters_.scene.deck->size_m / 2 ? pad_m : 0;
}

// Puts the sheet over the pad, or takes it away, when its time comes.
void Simulator::CoverPad() {
  const OcclusionParameters& o = parameters_.occlusion;
  if (o.share <= 0) return;
  const double wanted = truth_.t_s >= o.from_s && truth_.t_s < o.until_s ? o.share : 0;
  if (wanted != occluded_ || (deck_ && wanted > 0))
    PlaceOccluder(model_.get(), data_.get(), truth_.X_NT, wanted);
  occluded_ = wanted;
}

// What happens to the cameras at this instant.
void Simulator::RunCamera() {
  CoverPad();
  if (ground_) ground_->Step(data_.get(), steps_, parameters_.render.daylight);
  for (const auto& camera : cameras_)
    camera->Step(data_.get(), steps_, truth_.X_NB, parameters_.render.daylight);
  if (steps_ == clock_.TickStep()) {
    XXH3_64bits_update(hashes_->state, data_->qpos, sizeof(mjtNum) * model_->nq);
    XXH3_64bits_update(hashes_->state, data_->qvel, sizeof(mjtNum) * model_->nv);
  }
  if (events_ && steps_ >= 0) events_->Add(snapshot());
  if (clock_.Step(
          steps_, [&] { return snapshot(); }, renderer_.get()))
    exposures_.push_back(truth_);
}

Snapshot Simulator::snapshot() const {
  Snapshot now = SnapshotOf(model_.get(), data_.get(), truth_.t_s);
  now.daylight = parameters_.render.daylight;
  if (platform_) now.X_BC = X_BC_;
  return now;
}

void Simulator::AdvanceTo(std::int64_t step) {
  while (steps_ < step && !ended_) {
    Step();
    RunCamera();
  }
}

std::optional<vision::Frame> Simulator::Next() { return NextUntilStep(kNever); }

std::optional<vision::Frame> Simulator::NextUntil(double t_s) {
  // A time that is meant to be a step's own is not missed by rounding.
  return NextUntilStep(static_cast<std::int64_t>(std::floor(t_s / model_->opt.timestep + 1e-6)));
}

std::optional<vision::Frame> Simulator::NextUntilStep(std::int64_t last) {
  const auto start = std::chrono::steady_clock::now();
  while (!clock_.DueStep() && clock_.TickStep() <= last && clock_.TickStep() != kNever && !ended_)
    AdvanceTo(clock_.TickStep());
  const auto due_step = clock_.DueStep();
  const bool comes = due_step && *due_step <= last;
  if (comes) {
    AdvanceTo(*due_step);
  } else if (last != kNever) {
    AdvanceTo(last);
  }
  physics_s_ += SecondsSince(start);
  Gather();
  if (!comes || ended_) return std::nullopt;
  const CameraClock::Frame frame = clock_.Take();
  exposure_ = std::move(exposures_.front());
  exposures_.pop_front();
  timing_.physics_s.push_back(std::exchange(physics_s_, 0));
  picture_ = renderer_ ? renderer_->Next() : RenderedFrame{};
  timing_.render_s.push_back(picture_.render_s);
  timing_.sensor_s.push_back(picture_.sensor_s);
  XXH3_64bits_update(hashes_->image, picture_.image.data, picture_.image.total() * picture_.image.elemSize());
  return vision::Frame{picture_.image, camera_error_.Stamp(frame.t_s, frame.sequence), frame.sequence};
}

// What instruments and further cameras have given meanwhile.
void Simulator::Gather() {
  if (instruments_) readings_ = instruments_->Take(truth_.t_s);
  camera_frames_.clear();
  for (const auto& camera : cameras_)
    while (auto frame = camera->Take()) camera_frames_.push_back(std::move(*frame));
}

control::VehicleState Simulator::State() const {
  control::VehicleState state = autopilot_->State();
  if (external_ != nullptr) {  // its modes are its own affair
    state.mode = truth_.touching ? control::FlightMode::kStopped : control::FlightMode::kHold;
    state.landed = truth_.touching;
    state.saturated = false;
  }
  return state;
}

void Simulator::Send(const control::Setpoint& setpoint) { autopilot_->Send(setpoint); }
void Simulator::Aid(const control::AttitudeAid& aid) { autopilot_->Aid(aid); }
std::string Simulator::renderer_name() const { return renderer_ ? renderer_->renderer_name() : "none"; }
std::uint64_t Simulator::state_hash() const { return XXH3_64bits_digest(hashes_->state); }
std::uint64_t Simulator::image_hash() const { return XXH3_64bits_digest(hashes_->image); }

}  // namespace kestrel::sim
