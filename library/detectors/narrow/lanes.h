// Three or four doubles that are computed with at once: one for each axis of a box.
#pragma once

#include "library/detectors/kernels/simd.h"
#include "library/detectors/narrow/vectors.h"

namespace cdb::narrow {
namespace {  // as simd.h

using kernels::Doubles;

struct Lanes {
  static constexpr std::size_t kParts = 4 / kernels::kDoubles;
  Doubles part[kParts];

  [[gnu::always_inline]] friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return Each([&](std::size_t k) { return a.part[k] + b.part[k]; });
  }
  [[gnu::always_inline]] friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return Each([&](std::size_t k) { return a.part[k] - b.part[k]; });
  }
  [[gnu::always_inline]] friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return Each([&](std::size_t k) { return a.part[k] * b.part[k]; });
  }
  [[gnu::always_inline]] friend Lanes operator*(double s, const Lanes& a) {
    return Each([&](std::size_t k) { return s * a.part[k]; });
  }
  template <typename Of>
  [[gnu::always_inline]] static Lanes Each(const Of& of) {
    Lanes to;
    for (std::size_t k = 0; k < kParts; ++k) to.part[k] = of(k);
    return to;
  }
};

[[gnu::always_inline]] inline Lanes Make(double a, double b, double c) {
#if defined(__AVX2__)
  return {Doubles{a, b, c, 0}};
#else
  return {Doubles{a, b}, Doubles{c, 0}};
#endif
}
[[gnu::always_inline]] inline Lanes Abs(const Lanes& a) {
  using Bits = kernels::Mask<Doubles>;
  return Lanes::Each(
      [&](std::size_t k) { return Doubles(Bits(a.part[k]) & (Bits{} + 0x7fffffffffffffff)); });
}
/// The lanes 1, 2, 0, 3.
[[gnu::always_inline]] inline Lanes Next(const Lanes& a) {
#if defined(__AVX2__)
  return {__builtin_shufflevector(a.part[0], a.part[0], 1, 2, 0, 3)};
#else
  return {__builtin_shufflevector(a.part[0], a.part[1], 1, 2),
          __builtin_shufflevector(a.part[0], a.part[1], 0, 3)};
#endif
}
[[gnu::always_inline]] inline void Store(const Lanes& a, double* to) {
  for (std::size_t k = 0; k < Lanes::kParts; ++k)
    kernels::Store(a.part[k], to + k * kernels::kDoubles);
}
/// A bit for each of the first three lanes that holds.
template <typename Test>
[[gnu::always_inline]] inline unsigned Bits(const Test& test) {
  int bits = 0;
  for (std::size_t k = 0; k < Lanes::kParts; ++k)
    bits |= kernels::BitsOf(test(k)) << (k * kernels::kDoubles);
  return static_cast<unsigned>(bits) & 7;
}

}  // namespace
}  // namespace cdb::narrow
