// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <utility>
#include <vector>

namespace kestrel::vision {

// How much each of evenly spaced places of a path counts in the smooth path at one of them. The path is taken to be a
// process of white acceleration, of a spectrum (cutoff / 2f)^4, the shakes one of spectrum 1 from 2.5 cutoff on; the
// weights are those of the least mean square error (Wiener 1949, of a finite window) that leave a path as it is that
// goes on evenly. cutoff: cycles a place.
class PathWeights {
 public:
  // before, after: places beside the one that is asked for.
  PathWeights(int before, int after, double cutoff);

  // Of before + after + 1 weights, whose sum is 1, where so many places are known, at most as many as of the whole
  // window. What lies beyond the first `after` + 1 or the last `before` + 1 places of the window is taken to be what
  // these foretell, so that the same places give a path as smooth as the whole window does.
  const Eigen::VectorXd& Of(int before, int after);

 private:
  Eigen::MatrixXd Foretell(int known, const std::vector<int>& places) const;
  const Eigen::MatrixXd& Beyond(int known);

  int before_, after_;
  std::vector<double> shakes_, path_;  // autocovariances by the distance of two places
  Eigen::VectorXd whole_;
  std::map<int, Eigen::MatrixXd> beyond_;  // by the places known: row r is of the place -(r + 1)
  std::map<std::pair<int, int>, Eigen::VectorXd> parts_;
};

}  // namespace kestrel::vision
