// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace kestrel {

// Does pieces 0 .. count - 1, `jobs` at a time, in no promised order: each piece writes its own result. Progress
// is shown as "title: 3 of 20 unit". Once one has thrown no further ones are begun; throws what the
// first one threw.
void InParallel(std::size_t count, int jobs, const std::string& title, const std::string& unit,
                const std::function<void(std::size_t)>& piece);

}  // namespace kestrel
