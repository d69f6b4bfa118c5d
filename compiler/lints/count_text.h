// Counts of runs, as text for messages.
#pragma once

#include <cstddef>
#include <string>

namespace cdb::lints {

/// `2 of 6 runs`; if not all of them were checked, `2 of the 100 runs that were looked at, of
/// 5000`.
std::string CountText(std::size_t count, std::size_t looked_at, std::size_t runs);

}  // namespace cdb::lints
