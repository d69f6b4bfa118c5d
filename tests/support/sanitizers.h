// The sanitizer that the tests are built with: GCC defines a macro, Clang has a feature test.
#pragma once

#include <set>
#include <string>

#ifndef __has_feature
#define __has_feature(name) 0
#endif

namespace cdb::tests {

#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)
inline constexpr bool kAddressSanitizer = true;
#else
inline constexpr bool kAddressSanitizer = false;
#endif

#if defined(__SANITIZE_THREAD__) || __has_feature(thread_sanitizer)
inline constexpr bool kThreadSanitizer = true;
#else
inline constexpr bool kThreadSanitizer = false;
#endif

inline constexpr bool kAnySanitizer = kAddressSanitizer || kThreadSanitizer;

/// The number of random cases to try. A sanitizer checks the memory accesses and arithmetic of
/// each, and slows it down 30 times; the plain build tries all.
constexpr int Cases(int all) { return kAddressSanitizer ? (all + 9) / 10 : all; }

/// Chooses from a list of cases: the plain build tries all, a sanitizer the first of each kind and
/// every tenth of all.
class Sample {
 public:
  bool Takes(const std::string& kind) {
    const bool is_first = kinds_.insert(kind).second;
    return !kAddressSanitizer || is_first || ++index_ % 10 == 0;
  }

 private:
  std::set<std::string> kinds_;
  int index_ = 0;
};

}  // namespace cdb::tests
