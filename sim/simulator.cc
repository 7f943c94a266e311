// SPDX-License-Identifier: Apache-2.0
#include "sim/simulator.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <future>
#include <mutex>
#include <numbers>
#include <queue>
#include <thread>
#include <utility>

#include "geometry/tait_bryan.h"
#include "sim/frames.h"

namespace kestrel {
namespace {

constexpr double kAirborne_m = 0.3;

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

SceneParameters WithOccluder(SceneParameters scene, const OcclusionParameters& occlusion) {
  scene.occluder = occlusion.share > 0;
  return scene;
}

}  // namespace

Pose MountPose(const CameraMount& mount) {
  Eigen::Matrix3d R_BD;  // D: looking down, the top of the image forward
  R_BD << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Matrix3d turn =
      RotationFromTaitBryan({Radians(mount.yaw_deg), Radians(mount.pitch_deg), Radians(mount.roll_deg)});
  return {Eigen::Quaterniond(Eigen::Matrix3d(turn * R_BD)), mount.position_m};
}

// Draws snapshots in their order, on a thread of its own that holds the OpenGL context.
class Simulator::Studio {
 public:
  struct Picture {
    cv::Mat image;
    double render_s = 0, sensor_s = 0;
  };
  struct Snapshot {
    std::vector<mjtNum> qpos, mocap_pos, mocap_quat;
    Pose X_NC;
    std::int64_t sequence = 0;
  };

  Studio(const mjModel* model, const SimulatorParameters& p)
      : model_(model), sensor_(p.image, p.seed), camera_(p.camera), options_(p.render) {
    std::promise<std::string> ready;
    std::future<std::string> name = ready.get_future();
    thread_ = std::thread([this, ready = std::move(ready)]() mutable { Work(std::move(ready)); });
    try {
      name_ = name.get();
    } catch (...) {
      thread_.join();
      throw;
    }
  }
  ~Studio() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
  }

  void Submit(Snapshot snapshot) {
    std::packaged_task<Picture()> task([this, s = std::move(snapshot)] { return Draw(s); });
    pictures_.push_back(task.get_future());
    {
      const std::lock_guard lock(mutex_);
      tasks_.push(std::move(task));
    }
    wake_.notify_one();
  }
  Picture Take() {
    Picture picture = pictures_.front().get();
    pictures_.pop_front();
    return picture;
  }
  const std::string& name() const { return name_; }

 private:
  void Work(std::promise<std::string> ready) {
    try {
      renderer_ = std::make_unique<Renderer>(model_, camera_, options_);
      data_ = MakeData(model_);
      ready.set_value(renderer_->name());
    } catch (...) {
      renderer_.reset();
      ready.set_exception(std::current_exception());
      return;
    }
    for (;;) {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stop_ || !tasks_.empty(); });
      if (stop_) break;
      std::packaged_task<Picture()> task = std::move(tasks_.front());
      tasks_.pop();
      lock.unlock();
      task();
    }
    renderer_.reset();  // on the thread of its context
  }

  Picture Draw(const Snapshot& s) {
    Picture picture;
    auto start = std::chrono::steady_clock::now();
    std::copy(s.qpos.begin(), s.qpos.end(), data_->qpos);
    std::copy(s.mocap_pos.begin(), s.mocap_pos.end(), data_->mocap_pos);
    std::copy(s.mocap_quat.begin(), s.mocap_quat.end(), data_->mocap_quat);
    mj_kinematics(model_, data_.get());
    mj_camlight(model_, data_.get());
    const cv::Mat bgr = renderer_->Render(data_.get(), s.X_NC);
    picture.render_s = SecondsSince(start);
    start = std::chrono::steady_clock::now();
    picture.image = sensor_.Expose(bgr, s.sequence);
    picture.sensor_s = SecondsSince(start);
    return picture;
  }

  const mjModel* model_;
  ImageSensor sensor_;
  CameraModel camera_;
  RenderOptions options_;
  std::unique_ptr<Renderer> renderer_;
  DataPtr data_;
  std::string name_;
  std::deque<std::future<Picture>> pictures_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::queue<std::packaged_task<Picture()>> tasks_;
  bool stop_ = false;
  std::thread thread_;
};

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
    : parameters_(parameters),
      model_(MakeModel(WithOccluder(parameters.scene, parameters.occlusion))),
      data_(MakeData(model_.get())),
      vehicle_(parameters.vehicle, model_.get()),
      wind_(parameters.wind, parameters.seed),
      sensors_(parameters.sensors, parameters.seed),
      X_BC_(MountPose(parameters.mount)),
      studio_(std::make_unique<Studio>(model_.get(), parameters)),
      hashes_(std::make_unique<Hashes>()) {
  mj_forward(model_.get(), data_.get());
  const Pose X_NT = PadPose(model_.get(), data_.get());
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
  PoseToMujoco(X_NB, data_->qpos);
  mj_forward(model_.get(), data_.get());

  // The gyroscopes' bias, averaged over two seconds at rest before the flight.
  Sensors at_rest = sensors_;
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  constexpr int kSamples = 1000;
  const double dt = model_->opt.timestep;
  for (int i = 0; i < kSamples; ++i) {
    bias +=
        at_rest.Read(dt, X_NB, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), {0, 0, -9.80665}).imu.w_B /
        kSamples;
  }
  autopilot_ = std::make_unique<EmulatedAutopilot>(parameters.autopilot, parameters.sensors,
                                                   parameters.vehicle, X_NB, !start.on_ground, bias);
  steps_ = -std::lround(start.settle_s / dt);
  autopilot_->SetClock(static_cast<double>(steps_) * dt);
  truth_ = Look();
  airborne_ = !start.on_ground;
  AdvanceTo(0);
  Expose();
}

Simulator::~Simulator() = default;

Truth Simulator::Look() const {
  Truth t;
  t.t_s = static_cast<double>(steps_) * model_->opt.timestep;
  t.X_NB = PoseFromMujoco(data_->qpos);
  t.v_N = VectorFromMujoco(data_->qvel);
  t.w_B = VectorFromMujoco(data_->qvel + 3);
  t.wind_N = wind_.Velocity();
  t.X_NT = PadPose(model_.get(), data_.get());
  const int vehicle = mj_name2id(model_.get(), mjOBJ_BODY, "vehicle");
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
  vehicle_.Apply(data_.get(), dt, wind_.Velocity(), -before.X_NT.p.z());
  mj_step(model_.get(), data_.get());
  ++steps_;
  for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC, mjWARN_BADCTRL}) {
    if (data_->warning[warning].number > 0) {
      throw RunError(fmt::format("at {:.3f} s: the physical state of the aircraft is not a number ({})",
                                 before.t_s, mju_warningText(warning, data_->warning[warning].lastinfo)));
    }
  }
  truth_ = Look();
  const Eigen::Vector3d specific_force_B =
      truth_.X_NB.R.conjugate() * ((truth_.v_N - before.v_N) / dt - Eigen::Vector3d(0, 0, 9.80665));
  const SensorReadings readings = sensors_.Read(dt, truth_.X_NB, truth_.v_N, truth_.w_B, specific_force_B);
  vehicle_.Command(autopilot_->Step(dt, readings));
  if (!State().R_NB.coeffs().allFinite() || !State().p_NB.allFinite()) {
    throw RunError(fmt::format("at {:.3f} s: the autopilot's estimate is not a number", truth_.t_s));
  }
  airborne_ = airborne_ || truth_.X_NT.p.z() - truth_.X_NB.p.z() > kAirborne_m;
  if (!touch_ && airborne_ && truth_.touching && !before.touching && truth_.t_s > 0) touch_ = before;
}

// Takes the picture of this instant, to be drawn on the other thread.
void Simulator::Expose() {
  const OcclusionParameters& o = parameters_.occlusion;
  if (o.share > 0) {
    const double wanted = truth_.t_s >= o.from_s && truth_.t_s < o.until_s ? o.share : 0;
    if (wanted != occluded_ || exposures_ == 0) PlaceOccluder(model_.get(), data_.get(), wanted);
    occluded_ = wanted;
  }
  Studio::Snapshot s;
  s.qpos.assign(data_->qpos, data_->qpos + model_->nq);
  s.mocap_pos.assign(data_->mocap_pos, data_->mocap_pos + 3 * model_->nmocap);
  s.mocap_quat.assign(data_->mocap_quat, data_->mocap_quat + 4 * model_->nmocap);
  s.X_NC = truth_.X_NB * X_BC_;
  s.sequence = exposures_++;
  XXH3_64bits_update(hashes_->state, data_->qpos, sizeof(mjtNum) * model_->nq);
  XXH3_64bits_update(hashes_->state, data_->qvel, sizeof(mjtNum) * model_->nv);
  exposed_.push_back(truth_);
  studio_->Submit(std::move(s));
}

// Steps to a time, exposing on the way whatever falls due.
void Simulator::AdvanceTo(double t_s) {
  const double dt = model_->opt.timestep;
  const std::int64_t last = std::llround(t_s / dt);
  while (steps_ < last) {
    Step();
    const double due_s = static_cast<double>(exposures_) / parameters_.image.rate_hz;
    if (steps_ > 0 && steps_ >= std::llround(due_s / dt) && due_s <= parameters_.duration_s) Expose();
  }
}

std::optional<Frame> Simulator::Next() {
  const double due_s = static_cast<double>(delivered_) / parameters_.image.rate_hz;
  if (due_s > parameters_.duration_s) return std::nullopt;
  const auto start = std::chrono::steady_clock::now();
  AdvanceTo(due_s + parameters_.image.latency_s);
  timing_.physics_s.push_back(SecondsSince(start));
  Studio::Picture picture = studio_->Take();
  timing_.render_s.push_back(picture.render_s);
  timing_.sensor_s.push_back(picture.sensor_s);
  exposure_ = exposed_.front();
  exposed_.pop_front();
  XXH3_64bits_update(hashes_->image, picture.image.data, picture.image.total() * picture.image.elemSize());
  return Frame{picture.image, exposure_.t_s, delivered_++};
}

VehicleState Simulator::State() const { return autopilot_->State(); }
void Simulator::Send(const Setpoint& setpoint) { autopilot_->Send(setpoint); }
std::string Simulator::renderer_name() const { return studio_->name(); }
std::uint64_t Simulator::state_hash() const { return XXH3_64bits_digest(hashes_->state); }
std::uint64_t Simulator::image_hash() const { return XXH3_64bits_digest(hashes_->image); }

}  // namespace kestrel
