// Assertions that stay on in release builds. Never for invalid input; never inside timed code.
#pragma once

namespace cdb::text {

/// Prints the failed condition and its location, and ends the process.
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);

}  // namespace cdb::text

#define CDB_CHECK(condition) \
  ((condition) ? void(0) : ::cdb::text::CheckFailed(#condition, __FILE__, __LINE__))
