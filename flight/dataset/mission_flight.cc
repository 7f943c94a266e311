// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/mission_flight.h"

#include <unistd.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "base/nanoseconds.h"
#include "base/process/print_note.h"
#include "flight/dataset/boxes.h"
#include "flight/dataset/trajectory/conventions.h"
#include "flight/dataset/writers.h"
#include "flight/stepped/sim.h"

namespace kestrel::flight {
namespace {

// Gathers what comes from a flight. A frame is written once the flow from it is known, with the one after it.
class Gatherer {
 public:
  Gatherer(const DatasetPlan& plan, const Sim& sim, int threads, Journal& journal, Sequence& sequence)
      : plan_(plan),
        boxes_(sim.simulator().model()),
        journal_(journal),
        s_(sequence),
        last_(sequence.cameras.size()),
        writers_(threads) {
    const auto& cameras = sim.scenario().simulator.cameras;
    for (std::size_t i = 0; i < cameras.size(); ++i) number_[cameras[i].name] = i + 1;
  }

  void Take(const Sim& sim, const Observation& seen) {
    if (seen.frame) {
      const Truth& truth = sim.exposure();
      Add(0, seen.frame->image, seen.frame->t_s, truth.X_NC, seen.surfaces, seen.flow);
      exposures_.push_back({.stamp_ns = s_.frames[0].back().stamp_ns, .X_NB = truth.X_NB, .v_N = truth.v_N});
    }
    for (const sim::CameraFrame& f : sim.camera_frames())
      Add(number_.at(f.name), f.frame.image, f.frame.t_s, f.X_NC, f.surfaces, f.flow);
    const sim::Readings& readings = sim.readings();
    for (sim::ImuReading reading : readings.imu) {
      reading.t_ns += kBegin_ns;
      s_.imu.push_back(reading);
    }
    for (const sim::TruthSample& t : readings.truth)
      s_.truth.push_back({kBegin_ns + t.t_ns, t.X_NB, t.v_N, t.gyroscope_bias_I, t.accelerometer_bias_I});
  }

  void Finish() {
    for (auto& frame : last_)
      if (frame) Write(std::move(frame), {});
    writers_.Finish();
    MergeTruth(exposures_, s_);
  }

 private:
  void Add(std::size_t camera, const cv::Mat& image, double t_s, const Pose& X_NC,
           const sim::Surfaces& surfaces, const cv::Mat& flow_here) {
    std::vector<FrameRow>& rows = s_.frames[camera];
    auto frame = std::make_shared<SetFrame>();
    frame->index = static_cast<int>(rows.size());
    frame->camera = camera;
    frame->stamp_ns = kBegin_ns + Nanoseconds(t_s);
    frame->image = image;
    frame->surfaces = surfaces;
    if (s_.extras.boxes) frame->boxes = boxes_.Find(surfaces.geom);
    rows.push_back({frame->stamp_ns, X_NC, frame->boxes});
    std::swap(last_[camera], frame);
    if (frame) Write(std::move(frame), flow_here);
  }

  void Write(std::shared_ptr<SetFrame> frame, const cv::Mat& flow) {
    frame->flow = flow;
    const Journal::Key key(s_.number, frame->index, frame->camera);
    if (journal_.Find(key)) return;
    writers_.Do([this, key, frame = std::move(frame)] {
      journal_.Write(key, plan_.format->Pictures(s_, *frame), frame->boxes);
    });
  }

  const DatasetPlan& plan_;
  BoxFinder boxes_;
  Journal& journal_;
  Sequence& s_;
  std::map<std::string, std::size_t> number_;  // of the cameras beside the first
  std::vector<std::shared_ptr<SetFrame>> last_;
  std::vector<TruthRow> exposures_;
  Writers writers_;
};

}  // namespace

void FlyMission(const DatasetPlan& plan, std::uint64_t seed, int threads, Journal& journal, Sequence& s) {
  const DatasetArguments& a = plan.arguments;
  SimOptions options;
  options.seed = seed;
  options.overrides = plan.overrides;
  options.surfaces = s.extras.Surfaces();
  options.draw_beside = threads > 0;
  Sim sim(a.source, options);
  Observation seen = sim.Reset();
  Gatherer gatherer(plan, sim, threads, journal, s);
  gatherer.Take(sim, seen);
  const bool terminal = a.count == 1 && isatty(STDERR_FILENO);  // of several, InParallel tells
  const auto enough = [&] { return a.frames && s.frames[0].size() >= static_cast<std::size_t>(*a.frames); };
  while (!sim.done() && !enough()) {
    const mission::Decision& decision = sim.Decide();
    seen = sim.Step(decision.setpoint, decision.aid);
    gatherer.Take(sim, seen);
    if (terminal)
      PrintNote("\r\033[Kdata set: {} frames, {:.1f} s of the flight", s.frames[0].size(), sim.t_s());
  }
  gatherer.Finish();
}

}  // namespace kestrel::flight
