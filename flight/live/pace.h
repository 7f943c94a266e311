// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace kestrel::flight {

// How fast a simulated flight goes for who watches it: paused, frame by frame, at some multiple of real time,
// or as fast as it goes. It is asked with the wall clock's time, any that runs in real time, and the flight's.
// What the machine is late by more than kCatchUp_s is given up; nothing is skipped.
class Pace {
 public:
  static constexpr double kAsFast = 0, kLeast = 0.1, kMost = 100;  // speeds, as multiples of real time
  static constexpr double kCatchUp_s = 0.05;

  static bool Valid(double speed);
  explicit Pace(double speed) : speed_(speed) {}

  void Pause();
  void Resume();
  void Step();  // one frame, and then paused
  void SetSpeed(double speed);

  // A frame of the flight is done, at t_s of it.
  void Flown(double wall_s, double t_s);
  // How long the next one must still wait; infinite: for a command.
  double Wait_s(double wall_s, double t_s);

  bool paused() const { return paused_; }
  double speed() const { return speed_; }
  // Of the last half second or more; 0 while paused.
  double real_time_factor() const { return paused_ ? 0 : factor_; }

 private:
  struct At {
    double wall_s, t_s;
  };

  double speed_;
  bool paused_ = false;
  int steps_ = 0;
  std::optional<At> zero_;   // from which the flight is timed
  std::optional<At> since_;  // from which its factor is measured
  double factor_ = 0;
};

}  // namespace kestrel::flight
