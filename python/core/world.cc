// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "base/file/model_files.h"
#include "flight/simulated/scenario.h"
#include "python/core/arrays.h"
#include "python/core/camera.h"
#include "python/core/given.h"
#include "python/core/module.h"
#include "python/core/one_thread.h"
#include "python/core/overrides.h"
#include "python/core/poses.h"
#include "sim/camera/renderer.h"
#include "sim/world/frames.h"
#include "sim/world/scene.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

namespace fs = std::filesystem;

// A scenario's world at rest, with the aircraft out of sight.
class World {
 public:
  World(const fs::path& name, std::optional<std::uint64_t> seed, const py::object& overrides) {
    std::vector<std::string> all = OverridesOf(overrides);
    if (seed) all.push_back(fmt::format("seed={}", *seed));
    std::string scenario = name.string();
    const std::vector<std::string> worlds = ModelNames(Model::kWorld), scenarios = ScenarioNames();
    if (std::count(worlds.begin(), worlds.end(), scenario) &&
        !std::count(scenarios.begin(), scenarios.end(), scenario))
      all.insert(all.begin(), "world=" + std::exchange(scenario, "hover"));
    const py::gil_scoped_release others_run;
    const flight::LoadedScenario loaded = flight::LoadScenario(scenario, all, false);
    camera_ = loaded.simulator.camera;
    options_ = loaded.simulator.render;
    model_ = sim::MakeModel(loaded.simulator.scene);
    data_ = sim::MakeData(model_.get());
    sim::PoseToMujoco({Eigen::Quaterniond::Identity(), {0, 0, 1e4}}, data_->qpos);
    mj_forward(model_.get(), data_.get());
  }

  ShownFrame Render(const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation,
                    const py::object& camera, bool depth, bool segmentation) {
    const OneThread::Use use(one_thread_);
    const Pose X_NC = PoseOf(position, rotation);
    const vision::CameraModel seen_by = camera.is_none() ? camera_ : CameraOf(camera);
    const std::string described = vision::NameOf(seen_by) + std::to_string(vision::WidthPx(seen_by)) + "x" +
                                  std::to_string(vision::HeightPx(seen_by));
    const py::gil_scoped_release others_run;
    const Eigen::VectorXd parameters = vision::Parameters(seen_by);
    if (!renderer_ || described != described_ || parameters != parameters_) {
      renderer_.reset();
      renderer_ = std::make_unique<sim::Renderer>(model_.get(), seen_by, options_);
      described_ = described;
      parameters_ = parameters;
    }
    ShownFrame shown;
    shown.X_NC = X_NC;
    shown.frame.image = renderer_->Render(data_.get(), X_NC);
    if (depth || segmentation) {
      const sim::Surfaces surfaces = renderer_->Trace(data_.get(), X_NC);
      if (depth) shown.depth = surfaces.depth_m;
      if (segmentation) shown.segmentation = surfaces.geom;
    }
    return shown;
  }

  Camera camera() const { return {camera_}; }
  Pose pad() const { return sim::PadPose(model_.get(), data_.get()); }
  std::vector<std::string> geom_names() const {
    std::vector<std::string> names;
    for (int i = 0; i < model_->ngeom; ++i) {
      const char* name = mj_id2name(model_.get(), mjOBJ_GEOM, i);
      names.emplace_back(name ? name : "");
    }
    return names;
  }

 private:
  OneThread one_thread_{"World"};
  vision::CameraModel camera_;
  sim::RenderOptions options_;
  sim::ModelPtr model_;
  sim::DataPtr data_;
  std::unique_ptr<sim::Renderer> renderer_;  // for the camera that was asked for last
  std::string described_;
  Eigen::VectorXd parameters_;
};

}  // namespace

void BindWorld(py::module_& m) {
  py::class_<World>(
      m, "World",
      "A scenario's world at rest, to be drawn without a flight; the aircraft is out of sight. Not for "
      "several threads at a time.")
      .def(py::init<const fs::path&, std::optional<std::uint64_t>, const py::object&>(), "scenario"_a,
           "seed"_a = py::none(), "overrides"_a = py::dict(),
           "scenario: a name in scenarios/ or models/worlds, or a scenario's file; seed, overrides: as of "
           "Sim. Raises "
           "InputError.")
      .def("render", &World::Render, "position"_a, "rotation"_a, "camera"_a = py::none(), "depth"_a = false,
           "segmentation"_a = false,
           "What a camera sees: a Frame. position (3,): of the camera, north, east, down, m. rotation (3, "
           "3): turns vectors "
           "of the camera (right, down, forward) into north-east-down. camera: a Camera, or the name or the "
           "file of one; "
           "None: the scenario's. The image is as the lens gives it, without the sensor's noise.")
      .def_property_readonly("camera", &World::camera, "The scenario's Camera.")
      .def_property_readonly(
          "pad_position", [](const World& w) { return w.pad().p; },
          "(3,) of its centre: north, east, down, m.")
      .def_property_readonly(
          "pad_rotation", [](const World& w) { return w.pad().R.toRotationMatrix(); },
          "(3, 3) turns vectors of the pad (x along its long side, z down) into north-east-down.")
      .def_property_readonly("geom_names", &World::geom_names, "Names of what Frame.segmentation counts.");
}

}  // namespace kestrel::python
