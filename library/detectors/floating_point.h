// Keeps the floating-point environment of a thread as it is around a call into foreign code.
#pragma once

#include <cfenv>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace cdb::detectors {

/// Remembers the environment, and restores it at the end of its scope: the rounding mode; on
/// x86-64 also how denormals are treated and which exceptions trap. Flags of exceptions that
/// occurred are not part of it. Threads: of the calling thread only.
class KeepsFloatingPoint {
 public:
  KeepsFloatingPoint() : saved_(Read()) {}
  ~KeepsFloatingPoint() {
    if (IsChanged()) Write(saved_);
  }
  KeepsFloatingPoint(const KeepsFloatingPoint&) = delete;
  KeepsFloatingPoint& operator=(const KeepsFloatingPoint&) = delete;

  bool IsChanged() const { return Read() != saved_; }

 private:
#if defined(__x86_64__)
  static constexpr unsigned kFlags = 0x3f;  ///< of MXCSR: exceptions that occurred
  static unsigned Read() { return _mm_getcsr() & ~kFlags; }
  static void Write(unsigned environment) { _mm_setcsr(environment); }
  const unsigned saved_;
#else
  static int Read() { return std::fegetround(); }
  static void Write(int environment) { std::fesetround(environment); }
  const int saved_;
#endif
};

}  // namespace cdb::detectors
