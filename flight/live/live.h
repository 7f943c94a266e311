// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "flight/live/feed.h"
#include "flight/live/live_options.h"
#include "flight/live/page_conversation.h"
#include "mission/log_row.h"
#include "records/mcap/flight_messages.h"
#include "records/page/flight_subject.h"
#include "records/recorder.h"

namespace kestrel::flight {

// What a flight makes of a change: from when it holds, or why it is refused.
struct LiveAnswer {
  std::string refused;  // empty: it is not
  double t_s = 0;
  std::string again;  // the command that flies it again now; empty: none does
};

// A flight that is watched.
struct LiveFlight {
  records::FlightSubject subject;
  std::string scene_glb;                                  // of its world; empty: there is none
  records::TelemetryOptions telemetry;                    // its columns
  std::optional<records::FlightMessageOptions> messages;  // for Foxglove; none: there are none
  LiveRefusals refusals;
  // In Wait; value: JSON. Null: every change is refused.
  std::function<LiveAnswer(const std::string& key, const std::string& value)> change;
};

// Shows flights to whoever opens its address, one after the other, while they fly: by a thread of its own. The
// flight never waits for a viewer; with none, slow ones or many it is the same to the last bit. All is called by the
// flight's thread, but that any may call url, viewers and Event, and another one WantsPicture and Show of its kind.
class Live {
 public:
  // Throws InputError: the port is in use.
  explicit Live(const LiveOptions& options);
  ~Live();

  std::string url() const;
  bool open_to_others() const;  // to more than this computer
  int viewers() const;

  void Begin(LiveFlight flight);
  // Whether a picture of now would be seen: some twenty times a second, four of a flight that goes as fast as it can,
  // while there is somebody who takes them.
  bool WantsPicture(Picture kind) const;
  bool WantsImage() const;  // the same of Row's
  // image: of the frame, as the camera gave it; not to be written to any more. Empty: none.
  void Row(const mission::LogRow& row, const cv::Mat& image = {});
  void Show(Picture kind, double t_s, const cv::Mat& bgr);  // the same
  void Event(double t_s, std::string_view what, std::string_view is);
  // After each frame: does what viewers ask for, and waits until the next frame is to be flown. go_on is asked
  // some twenty times a second. False: it said no.
  bool Wait(double t_s, const std::function<bool()>& go_on);
  void End(const records::Summary& summary);
  // Until the last viewer has gone. False: go_on said no.
  bool Linger(const std::function<bool()>& go_on);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kestrel::flight
