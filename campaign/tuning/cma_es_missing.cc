// SPDX-License-Identifier: Apache-2.0
// In place of cma_es.cc where there is no pagmo: a plan that asks for CMA-ES is refused before (tune_plan.cc).
#include <stdexcept>

#include "campaign/tuning/search.h"

namespace kestrel::campaign {

struct CmaEs::State {
  std::vector<Point> asked;
};

CmaEs::CmaEs(const Point&, std::uint64_t) { throw std::logic_error("this build has no pagmo"); }
CmaEs::~CmaEs() = default;
CmaEs::CmaEs(CmaEs&&) noexcept = default;
CmaEs& CmaEs::operator=(CmaEs&&) noexcept = default;
const std::vector<Point>& CmaEs::Ask() { return state_->asked; }
void CmaEs::Tell(const std::vector<double>&) {}
const Point& CmaEs::Centre() const { return state_->asked.front(); }

}  // namespace kestrel::campaign
