// How many runs of a plan something is true of, for messages.
#pragma once

#include <cstddef>
#include <string>

namespace cdb::lints {

/// `2 of 6 runs`; where not all of them were looked at, `2 of the 100 runs that were looked at, of
/// 5000`.
std::string CountText(std::size_t count, std::size_t looked_at, std::size_t runs);

}  // namespace cdb::lints
