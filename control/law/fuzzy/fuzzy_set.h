// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "base/yaml/fields.h"

namespace kestrel::control {

// A fuzzy set of numbers whose membership function is a trapezoid: 0 up to the first corner and from the last
// on, 1 between the second and the third, straight between. A triangle has its two middle corners alike, a
// shoulder the two at its end. Corners do not fall.
struct FuzzySet {
  Eigen::Vector4d corners{0, 0, 0, 0};
};

inline void Fields(FieldVisitor& v, FuzzySet& s) {
  v(Required(
        "corners",
        "where its membership function leaves 0, reaches 1, leaves 1 and reaches 0; of a triangle the two "
        "middle ones are alike"),
    s.corners, -1e6, 1e6);
}

// Of x in the set, 0 to 1; of what is no number 0.
double Membership(const FuzzySet& set, double x);

}  // namespace kestrel::control
