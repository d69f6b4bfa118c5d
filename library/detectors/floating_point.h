// Preserves the floating-point environment of a thread across a call into foreign code.
#pragma once

#include <cfenv>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

namespace cdb::detectors {

/// Saves the environment, and restores it at the end of its scope: the rounding mode and, on
/// x86-64, the treatment of denormals and the exceptions that trap. Flags of exceptions that
/// occurred are not included. Threads: affects the calling thread only.
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
