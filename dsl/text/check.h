// A check for our own mistakes that stays on in release builds. Never for bad input; never inside
// timed code.
#pragma once

namespace cdb::text {

/// Prints what failed and where, and ends the process.
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);

}  // namespace cdb::text

#define CDB_CHECK(condition) \
  ((condition) ? void(0) : ::cdb::text::CheckFailed(#condition, __FILE__, __LINE__))
