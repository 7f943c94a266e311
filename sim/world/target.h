// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "base/random.h"
#include "base/yaml/fields.h"

// What flies besides the aircraft: a balloon on its string, or one that is carried about, or another aircraft
// by its coloured hull. All are spheres, which touch nothing and make no wind.
namespace kestrel::sim {

struct TargetParameters {
  double diameter_m = 0.5;
  Eigen::Vector3d colour{0.85, 0.10, 0.10};  // red, green, blue, 0 to 1
  // Of its centre at time 0, or where it hangs in a calm: north and east of the origin of N, and its height
  // above the ground.
  Eigen::Vector3d position_m{5, 0, 4};
  // How it moves, one of these three; none: not at all.
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // from time 0 on: north, east, up
  double string_m = 0;        // over 0: on a string of this length, from its lowest point straight down
  double roam_m_s = 0;        // over 0: on a random smooth path, up to this speed, with stops and reversals
  double roam_within_m = 12;  // of where it began, in the horizontal
  bool operator==(const TargetParameters&) const = default;
};

inline void Fields(FieldVisitor& v, TargetParameters& p) {
  v({"diameter_m", "diameter of the sphere"}, p.diameter_m, 0.05, 20.0);
  v({"colour", "red, green and blue, from 0 to 1"}, p.colour, 0.0, 1.0);
  v({"position_m", "north and east of the origin of N, and height of the centre above the ground, at time 0"},
    p.position_m, -2000.0, 2000.0);
  v({"velocity_m_s", "constant velocity from time 0 on: north, east, up"}, p.velocity_m_s, -30.0, 30.0);
  v({"string_m", "length of the string on which a balloon floats in the wind; 0: no string"}, p.string_m, 0.0,
    100.0);
  v({"roam_m_s", "maximum speed on a random smooth path; 0: no such path"}, p.roam_m_s, 0.0, 10.0);
  v({"roam_within_m", "horizontal distance from its start within which a random path stays"}, p.roam_within_m,
    1.0, 1000.0);
}

// The path of one target, step by step. On its string it is a pendulum upside down: a helium balloon with the
// drag of a sphere (C_D 0.47), of which lift, mass and the mass of the air it moves all follow from its
// volume. On a random path it holds a velocity for 1 to 4 s, then goes over to the next by a quintic, at 1.5
// m/s^2 at most: one in five is a stop, one in five the reverse of the last, the others go anywhere, slower
// upwards and downwards; near the limits of its place they lead back.
class TargetPath {
 public:
  // index: which of the targets.
  TargetPath(const TargetParameters& parameters, std::uint64_t seed, std::size_t index);

  // To the next instant, t_s, which may lie before 0: only the wind moves anything then.
  void Step(double t_s, double dt_s, const Eigen::Vector3d& wind_N);

  // From t_s on, where it is, it moves by these: other velocity_m_s or another random path.
  void Change(const TargetParameters& parameters, double t_s);

  const Eigen::Vector3d& p_N() const { return p_N_; }            // m, of its centre
  const Eigen::Vector3d& v_N() const { return v_N_; }            // m/s
  const Eigen::Vector3d& anchor_N() const { return anchor_N_; }  // of its string

 private:
  void Sway(double dt_s, const Eigen::Vector3d& wind_N);
  void Roam(double t_s, double dt_s);
  void NextVelocity(double t_s);

  TargetParameters parameters_;
  RandomStream random_;
  Eigen::Vector3d begin_N_, anchor_N_, p_N_, v_N_ = Eigen::Vector3d::Zero();
  // Of the random path: from one velocity to the next between two times, kept until a third.
  Eigen::Vector3d from_N_ = Eigen::Vector3d::Zero(), to_N_ = Eigen::Vector3d::Zero();
  double leaves_s_ = 0, arrives_s_ = 0, holds_until_s_ = 0;
};

}  // namespace kestrel::sim
