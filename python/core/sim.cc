// SPDX-License-Identifier: Apache-2.0
#include "flight/stepped/sim.h"

#include <fmt/format.h>
#include <pthread.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <atomic>
#include <utility>

#include "base/yaml/yaml_fields.h"
#include "control/autopilot.h"
#include "python/core/given.h"
#include "python/core/instruments.h"
#include "python/core/module.h"
#include "python/core/one_thread.h"
#include "python/core/overrides.h"
#include "records/summary.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

// How many forks lie between the process that loaded this module and this one. (getpid() is a system call.)
std::atomic<int> forks = 0;

// A Sim and who may use it: one thread at a time, of the process that made it.
class StepSim {
 public:
  StepSim(const std::filesystem::path& scenario, std::optional<std::uint64_t> seed,
          const py::object& overrides, bool images, bool depth, bool segmentation, bool flow,
          bool draw_beside, bool events)
      : depth_(depth), segmentation_(segmentation), flow_(flow) {
    if (!images && (depth || segmentation || flow))
      throw py::value_error("a Sim without images has no depth, segmentation or flow");
    SimOptions options;
    options.seed = seed;
    options.overrides = OverridesOf(overrides);
    options.images = images;
    options.surfaces = depth || segmentation || flow;
    options.draw_beside = draw_beside;
    options.imu = true;
    options.events = events;
    const py::gil_scoped_release others_run;
    sim_ = std::make_unique<Sim>(scenario.string(), options);
    const std::string& backend = sim_->scenario().simulator.render.backend;
    if (flow && (backend == "osmesa" || backend == "egl"))
      throw InputError("flow", "render.backend is " + backend,
                       "valid: ray, which alone gives the optical flow");
  }
  ~StepSim() {
    // The threads of a Sim do not follow into a forked process, so it cannot be taken down there.
    if (forks != process_)
      (void)sim_.release();
    else if (sim_) {
      const py::gil_scoped_release others_run;
      sim_.reset();
    }
  }
  StepSim(const StepSim&) = delete;
  StepSim& operator=(const StepSim&) = delete;

  // What a function makes of the Sim, while nobody else uses it. Let others run: without Python's lock.
  template <class Function>
  auto Use(Function function) const {
    const InUse use(*this);
    return function(*sim_);
  }
  template <class Function>
  auto LetOthersRun(Function function) const {
    const InUse use(*this);
    const py::gil_scoped_release others_run;
    return function(*sim_);
  }

  py::tuple Give(Observation o) const {
    py::object frame = py::none();
    if (o.frame) frame = py::cast(Shown(std::move(*o.frame), o.surfaces, o.flow, sim_->exposure().X_NC));
    return py::make_tuple(std::move(frame), py::cast(std::move(o.state)));
  }

  // The frames of the cameras beside the one that is flown by: a list for each, by its name.
  py::dict GiveCameras() const {
    const InUse use(*this);
    py::dict all;
    for (const auto& camera : sim_->scenario().simulator.cameras) all[py::str(camera.name)] = py::list();
    for (const sim::CameraFrame& f : sim_->camera_frames())
      all[py::str(f.name)].cast<py::list>().append(Shown(f.frame, f.surfaces, f.flow, f.X_NC));
    return all;
  }

 private:
  ShownFrame Shown(vision::Frame frame, const sim::Surfaces& surfaces, const cv::Mat& flow,
                   const Pose& X_NC) const {
    return {std::move(frame), depth_ ? surfaces.depth_m : cv::Mat(),
            segmentation_ ? surfaces.geom : cv::Mat(), flow_ ? flow : cv::Mat(), X_NC};
  }

  struct InUse {
    explicit InUse(const StepSim& sim) : use(sim.one_thread_) {
      if (forks != sim.process_)
        throw SimError("this Sim was made in another process; let each process make its own");
    }
    OneThread::Use use;
  };

  bool depth_, segmentation_, flow_;
  int process_ = forks;
  OneThread one_thread_{"Sim"};
  std::unique_ptr<Sim> sim_;
};

struct Command {
  std::optional<control::Setpoint> setpoint;
  std::optional<control::AttitudeAid> aid;
};

Command CommandOf(const py::object& given) {
  if (given.is_none()) return {};
  if (py::isinstance<control::VelocitySetpoint>(given)) return {given.cast<control::VelocitySetpoint>(), {}};
  if (py::isinstance<OwnedDecision>(given)) {
    const auto& decision = given.cast<const OwnedDecision&>().decision;
    return {decision.setpoint, decision.aid};
  }
  if (py::isinstance<control::PositionSetpoint>(given)) return {given.cast<control::PositionSetpoint>(), {}};
  if (py::isinstance<control::AttitudeSetpoint>(given)) return {given.cast<control::AttitudeSetpoint>(), {}};
  if (py::isinstance<control::RateSetpoint>(given)) return {given.cast<control::RateSetpoint>(), {}};
  throw py::type_error(fmt::format(
      "a setpoint is a Velocity, Position, Attitude, Rates or Decision of kestrel, or None, and not {}",
      std::string(py::repr(given))));
}

std::vector<std::string> GeomNames(const Sim& sim) {
  const mjModel* model = sim.simulator().model();
  std::vector<std::string> names;
  for (int i = 0; i < model->ngeom; ++i) {
    const char* name = mj_id2name(model, mjOBJ_GEOM, i);
    names.emplace_back(name ? name : "");
  }
  return names;
}

}  // namespace

void BindSim(py::module_& m) {
  pthread_atfork(nullptr, nullptr, [] { ++forks; });
  using S = StepSim;
  py::class_<S>(
      m, "Sim",
      R"(A scenario's aircraft, world and camera, in lockstep: the world stands still but in step() and advance().

scenario: a name in scenarios/, or a YAML file. seed: in place of the scenario's. overrides: a dict of "key.path" and
value, or a list of "key.path=value". images: False draws nothing, and frames have no image. depth, segmentation, flow:
what comes with each frame. draw_beside: images are drawn on a thread of their own; False: all is on the caller's.
events: of the scenario's event camera, behind the same lens.

The same scenario, seed and setpoints give the same flight as `kestrel run`, bit for bit. Of one Sim only one thread at
a time; several Sims may be used beside each other, and Python's lock is released while they work. Raises InputError
with every mistake of the scenario.)")
      .def(py::init<const std::filesystem::path&, std::optional<std::uint64_t>, const py::object&, bool, bool,
                    bool, bool, bool, bool>(),
           "scenario"_a, "seed"_a = py::none(), "overrides"_a = py::dict(), "images"_a = true,
           "depth"_a = false, "segmentation"_a = false, "flow"_a = false, "draw_beside"_a = true,
           "events"_a = false)
      .def(
          "reset",
          [](S& s, std::optional<std::uint64_t> seed) {
            return s.Give(s.LetOthersRun([&](Sim& sim) { return sim.Reset(seed); }));
          },
          "seed"_a = py::none(),
          "Begins the flight, also one that is under way. seed: from now on, in place of the one before. "
          "Returns the "
          "first Frame and the State.")
      .def(
          "step",
          [](S& s, const py::object& setpoint) {
            const Command command = CommandOf(setpoint);
            return s.Give(s.LetOthersRun([&](Sim& sim) { return sim.Step(command.setpoint, command.aid); }));
          },
          "setpoint"_a = py::none(),
          "Sends the setpoint, if any, and lets time go on until the next frame has come. Without one the "
          "last stands "
          "until it is stale. Returns (Frame, State); at the end of the flight the frame is None. Raises "
          "SimError "
          "before reset() and after the end.")
      .def(
          "advance",
          [](S& s, double seconds, const py::object& setpoint) {
            const Command command = CommandOf(setpoint);
            if (!(seconds > 0) || !std::isfinite(seconds))
              throw py::value_error(fmt::format("seconds: {}; valid: a positive number", seconds));
            bool interrupted = false;
            const auto go_on = [&] {
              const py::gil_scoped_acquire python;
              interrupted = PyErr_CheckSignals() != 0;
              return !interrupted;
            };
            Observation o =
                s.LetOthersRun([&](Sim& sim) { return sim.Advance(seconds, command.setpoint, go_on); });
            if (interrupted) throw py::error_already_set();
            return s.Give(std::move(o));
          },
          "seconds"_a, "setpoint"_a = py::none(),
          "The same, but time goes on by so many seconds, to the nearest step of dt, whatever the camera "
          "gives; "
          "what is left over counts for the next advance(). The frame is the last that has come meanwhile, "
          "or "
          "None. The setpoint is sent once, and after autopilot.command_timeout_s, 0.5 s, the aircraft holds "
          "its "
          "place. Raises ValueError of a time that is not positive.")
      .def(
          "_repeat",
          [](S& s, int times, const py::object& setpoint, std::optional<double> seconds) {
            const Command command = CommandOf(setpoint);
            s.LetOthersRun([&](Sim& sim) {
              for (int i = 0; i < times && !sim.done(); ++i)
                seconds ? sim.Advance(*seconds, command.setpoint) : sim.Step(command.setpoint, command.aid);
            });
          },
          "times"_a, "setpoint"_a = py::none(), "seconds"_a = py::none(),
          "For kestrel.bench: so many step(setpoint) or advance(seconds, setpoint) in C++.")
      .def(
          "decide", [](S& s) { return OwnedDecision(s.LetOthersRun([](Sim& sim) { return sim.Decide(); })); },
          "What the scenario's own mission decides on the frame that step() gave last: a Decision, which "
          "step() takes.")
      .def(
          "change",
          [](S& s, const std::string& key, const py::object& value) {
            const std::string yaml = YamlOf(key, value);
            s.Use([&](Sim& sim) { sim.Change(key, yaml); });
          },
          "key"_a, "value"_a,
          "Changes a key that the scenario lets change in flight (its `changeable`), from now on. Raises "
          "SimError that says why it cannot be done.")
      .def(
          "finish", [](S& s, const std::string& outcome) { s.Use([&](Sim& sim) { sim.Finish(outcome); }); },
          "outcome"_a, "Ends the flight. outcome: for the summary, such as 'landed'.")
      .def_property_readonly(
          "done", [](const S& s) { return s.Use([](const Sim& sim) { return sim.done(); }); },
          "No flight is under way: none has begun, time is up, or it was ended.")
      .def_property_readonly(
          "outcome", [](const S& s) { return s.Use([](const Sim& sim) { return sim.outcome(); }); },
          "How the flight ended; empty until then.")
      .def_property_readonly(
          "t", [](const S& s) { return s.Use([](const Sim& sim) { return sim.t_s(); }); },
          "Time of the flight, s.")
      .def_property_readonly(
          "dt", [](const S& s) { return s.Use([](const Sim& sim) { return sim.dt_s(); }); },
          "Step of the physics, s.")
      .def_property_readonly(
          "truth", [](const S& s) { return s.Use([](const Sim& sim) { return sim.truth(); }); },
          "The Truth now.")
      .def_property_readonly(
          "exposure_truth", [](const S& s) { return s.Use([](const Sim& sim) { return sim.exposure(); }); },
          "The Truth at the exposure of the frame given last.")
      .def_property_readonly(
          "geom_names", [](const S& s) { return s.Use(&GeomNames); },
          "Names of what Frame.segmentation counts; empty of what has none.")
      .def_property_readonly(
          "scenario",
          [](const S& s) { return s.Use([](const Sim& sim) { return ToYaml(sim.scenario().scenario); }); },
          "The whole scenario with its overrides, as YAML.")
      .def_property_readonly(
          "cameras", &S::GiveCameras,
          "Of each camera beside the one that is flown by (the scenario's key cameras) the list of "
          "Frames that have come since step(), advance() or reset() was called last, by its name.")
      .def_property_readonly(
          "imu", [](const S& s) { return s.Use(&ImuOf); },
          "(n,) structured, every sample since step(), advance() or reset() was called last: t_ns "
          "int64, ns; gyro (3,), rad/s; accel (3,), m/s^2. Of the scenario's instruments.imu, or where it "
          "has "
          "none of one by that key's defaults, which steers nothing.")
      .def_property_readonly(
          "imu_truth", [](const S& s) { return s.Use(&ImuTruthOf); },
          "(n,) structured, the truth at the instants of imu: t_ns, ns; position (3,), m; attitude (4,) "
          "w, x, y, z; velocity (3,), m/s; rates (3,), rad/s; gyro_bias (3,), rad/s; accel_bias (3,), "
          "m/s^2.")
      .def_property_readonly(
          "gps", [](const S& s) { return s.Use(&GpsOf); },
          "(n,) structured, as imu: t_ns, ns; position (3,), m; velocity (3,), m/s; north, east, down.")
      .def_property_readonly(
          "barometer", [](const S& s) { return s.Use(&BarometerOf); },
          "(n,) structured, as imu: t_ns, ns; height, m; pressure, Pa.")
      .def_property_readonly(
          "magnetometer", [](const S& s) { return s.Use(&MagnetometerOf); },
          "(n,) structured, as imu: t_ns, ns; field (3,), T, in the body.")
      .def_property_readonly(
          "rangefinder", [](const S& s) { return s.Use(&RangefinderOf); },
          "(n,) structured, as imu: t_ns, ns; range, m; infinite: nothing is within the longest, minus "
          "infinite: nearer than the shortest.")
      .def_property_readonly(
          "events", [](const S& s) { return s.Use(&EventsOf); },
          "(n,) structured, of the event camera, since step(), advance() or reset() was called last: t_ns, "
          "ns; x, y, "
          "px; on: brighter. They come up to some 10 ms late, the last when the flight ends. Raises SimError "
          "without "
          "events=True.")
      .def(
          "summary",
          [](const S& s) {
            const std::string json =
                s.LetOthersRun([](const Sim& sim) { return records::ToJson(sim.Summarise()); });
            return py::dict(py::module_::import("json").attr("loads")(json));
          },
          "Outcome, metrics, criteria and hashes of the flight so far, as in summary.json of `kestrel run`.");
}

}  // namespace kestrel::python
