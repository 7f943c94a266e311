// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/exposure.h"

#include <algorithm>
#include <cmath>

namespace kestrel::sim {
namespace {

constexpr double kDarkest_grey = 0.25;  // a black image asks for more light, but not for endlessly more

}  // namespace

ExposureControl::ExposureControl(const ExposureParameters& exposure, const AutoExposureParameters& automatic,
                                 double gain, double gamma)
    : exposure_(exposure), automatic_(automatic), gamma_(gamma), exposure_value_(gain) {
  const double time_s = exposure.time_s;
  lowest_ = time_s > 0 ? automatic.shortest_s / time_s : 1 / automatic.highest_gain;
  highest_ = (time_s > 0 ? automatic.longest_s / time_s : 1) * automatic.highest_gain;
  if (this->automatic()) exposure_value_ = std::clamp(gain, lowest_, highest_);
}

ExposureSetting ExposureControl::setting() const {
  if (!automatic()) return {exposure_.time_s, 1, exposure_value_};
  if (exposure_.time_s <= 0) {
    const double iris = std::min(exposure_value_, 1.0);
    return {0, iris, exposure_value_ / iris};
  }
  const double time_s = std::min(exposure_value_ * exposure_.time_s, automatic_.longest_s);
  const double light = time_s / exposure_.time_s;
  return {time_s, light, exposure_value_ / light};
}

void ExposureControl::Meter(double mean_grey, double t_s) {
  if (!automatic()) return;
  const double dt_s = metered_s_ ? t_s - *metered_s_ : 0;
  metered_s_ = t_s;
  // A grey level is light to the power of 1 / gamma.
  const double wanted = gamma_ * std::log(automatic_.target_grey / std::max(mean_grey, kDarkest_grey));
  const double share = automatic_.lag_s > 0 ? -std::expm1(-dt_s / automatic_.lag_s) : 1;
  exposure_value_ = std::clamp(exposure_value_ * std::exp(share * wanted), lowest_, highest_);
}

}  // namespace kestrel::sim
