// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "flight/lockstep/image_memory.h"
#include "flight/lockstep/lockstep_request.h"
#include "flight/lockstep/recorded_flight.h"
#include "flight/stepped/sim.h"

namespace kestrel::flight {

struct LockstepOptions {
  std::string scenario;  // a name or a file
  SimOptions sim = {};   // images and surfaces are what the client asks for
  // Where the records of a flight of this seed go.
  std::function<std::filesystem::path(std::uint64_t seed)> folder;
  bool video = true;
  std::function<void(const std::string&)> say;  // what who watches should know, as it happens
};

// What one client of the lockstep protocol asks for and is answered, flight after flight, whatever the bytes
// come by. Nothing that it is sent makes it throw.
class LockstepSession {
 public:
  // loaded: of these options.
  LockstepSession(const LockstepOptions& options, const LoadedScenario& loaded);
  ~LockstepSession();

  struct Reply {
    std::string json;
    std::vector<cv::Mat> pictures;  // behind it, as CopyPictures has them
    bool last = false;              // the client has said farewell
  };
  Reply Answer(std::string_view request);
  // What is wrong with a message that could not be read. The flight is as before.
  Reply Refuse(const char* kind, const std::string& what,
               std::optional<std::uint64_t> answers = std::nullopt) const;
  // The client is gone, or is sent away: a flight that is under way broke off so.
  void Leave(const std::string& why);

  bool introduced() const { return token_ > 0; }
  const std::optional<records::Summary>& summary() const {
    return summary_;
  }  // of the last flight that ended

 private:
  void RequireToken(const LockstepRequest& request) const;
  nlohmann::ordered_json Do(const HelloRequest& request);
  nlohmann::ordered_json Do(const ResetRequest& request);
  nlohmann::ordered_json Do(const StepRequest& request);
  nlohmann::ordered_json Do(const AdvanceRequest& request);
  nlohmann::ordered_json Do(const DecideRequest& request);
  nlohmann::ordered_json Do(const TruthRequest& request);
  nlohmann::ordered_json Do(const SummaryRequest& request);
  nlohmann::ordered_json Do(const FinishRequest& request);
  nlohmann::ordered_json Do(const ByeRequest& request);
  Sim& Flight();
  nlohmann::ordered_json Observed(const Observation& observation);
  nlohmann::ordered_json FrameJson(const vision::Frame& frame, const sim::Surfaces& surfaces,
                                   const cv::Mat& flow);
  void BeginRecords(const Observation& first);
  void End(const std::string& error);  // of the flight that is under way

  const LockstepOptions& options_;
  const LoadedScenario& loaded_;
  SimOptions sim_options_;
  std::unique_ptr<Sim> sim_;  // null: no flight was begun
  std::optional<RecordedFlight> recorded_;
  std::filesystem::path folder_;  // of the last flight; empty: it is not recorded
  bool under_way_ = false;
  std::optional<records::Summary> summary_;
  std::uint64_t token_ = 0;  // that the next request must have; 0: it is to be the first, hello
  std::string client_;
  bool inline_images_ = false;
  ImageMemory memory_;
  std::vector<cv::Mat> pictures_;  // of the reply that is being made
  double simulator_s_ = 0;         // of real time, that the simulator took for it
  bool farewell_ = false;
};

}  // namespace kestrel::flight
