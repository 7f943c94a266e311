// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

// What samples come to, for tables. Of no samples: not a number.
namespace kestrel {

double Mean(const std::vector<double>& values);
double Rms(const std::vector<double>& values);
double Largest(const std::vector<double>& values);
// q in [0, 1], between the two nearest samples in proportion; 0.5 is the median.
double Quantile(std::vector<double> values, double q);

}  // namespace kestrel
