// The loops by which `skin` learns how boxes move and enlarges them, for kernels_impl.h only.
#pragma once

#include "library/detectors/kernels/simd.h"

namespace cdb::kernels {
namespace {

/// The x, y and z of a body, and an unused lane. The compiler splits it for CPUs with smaller
/// registers.
using Lanes4 = VectorOf<double, 32>::Type;
using Bits4 = Mask<Lanes4>;

/// The margin of a body that deviated more than most, as a multiple of its deviation.
constexpr double kOwnMarginFactor = 2;

/// Returns by reference, because a vector wider than the CPU's registers cannot be returned by
/// value.
template <typename T>
[[gnu::always_inline]] inline void Load(const T* at, Lanes4& to) {
  std::memcpy(&to, at, sizeof to);
}
[[gnu::always_inline]] inline void LowerOf(const Box& box, Lanes4& lower) {
  Load(&box.lower.x, lower);
}
/// The upper corner, preceded by the lower z.
[[gnu::always_inline]] inline void LastOf(const Box& box, Lanes4& last) {
  Load(&box.lower.x + 2, last);
}
/// The displacement of the centre of a box.
[[gnu::always_inline]] inline void ShiftOf(const Box& from, const Box& to, Lanes4& shift) {
  Lanes4 lower, past_lower, last, past_last;
  LowerOf(to, lower);
  LowerOf(from, past_lower);
  LastOf(to, last);
  LastOf(from, past_last);
  const Lanes4 upper = __builtin_shufflevector(last, last, 1, 2, 3, 0);
  const Lanes4 past_upper = __builtin_shufflevector(past_last, past_last, 1, 2, 3, 0);
  shift = (lower - past_lower + upper - past_upper) * 0.5;
}

[[gnu::always_inline]] inline double LongestOf(const Lanes4& displacement) {
  const Bits4 magnitude = Bits4{} + std::numeric_limits<std::int64_t>::max();
  const Lanes4 size = Lanes4(Bits4(displacement) & magnitude);
  const double longer = size[0] < size[1] ? size[1] : size[0];
  return longer < size[2] ? size[2] : longer;
}

void Learn(const Box* boxes, const Box* past, const Box* marks, std::size_t count,
           const MotionTerms& terms, BodyMotion* motions) {
  for (std::size_t i = 0; i < count; ++i) {
    Lanes4 shift, last_velocity;
    ShiftOf(past[i], boxes[i], shift);
    Load(motions + i, last_velocity);
    const Lanes4 rest = shift - last_velocity * terms.predicted;
    const double deviation = LongestOf(rest);
    double per_age = terms.per_age;
    if (terms.per_recent_age > 0 && deviation > terms.margin) {
      ShiftOf(marks[i], boxes[i], shift);
      per_age = terms.per_recent_age;
    }
    const Lanes4 velocity = shift * per_age;
    // Zero if a component is infinite or NaN.
    const Lanes4 none = velocity - velocity;
    const double sum = none[0] + none[1] + none[2];
    const Bits4 finite = Bits4{} - static_cast<std::int64_t>(sum == 0);
    const Bits4 kept = Bits4(velocity) & finite;
    std::memcpy(motions + i, &kept, sizeof kept);
    const double own = kOwnMarginFactor * deviation;
    const double held = own < terms.most_margin ? own : terms.most_margin;  // a NaN is ignored
    motions[i].margin = terms.margin < held ? held : terms.margin;
  }
}

/// Rounds outwards to floats: upwards, or downwards with `sign` -1. The term added exceeds the
/// rounding error of a normal float. Infinity is unchanged.
[[gnu::always_inline]] inline void Outwards(const Lanes4& x, double sign, Float4& to) {
  const Bits4 magnitude = Bits4{} + std::numeric_limits<std::int64_t>::max();
  const Lanes4 size = Lanes4(Bits4(x) & magnitude);
  const Bits4 is_finite = size < Lanes4{} + kInfinity;
  to = __builtin_convertvector(x + Lanes4(Bits4(size * (sign * 0x1p-23)) & is_finite), Float4);
}

/// Enlarges a box. `first` and `last` are the first and the last four floats of its fat box.
[[gnu::always_inline]] inline void FattenOne(const Box& box, const BodyMotion& motion,
                                             const FatteningTerms& terms, Float4& first,
                                             Float4& last) {
  Lanes4 velocity;
  Load(&motion, velocity);
  const Lanes4 most = Lanes4{} + terms.most_displacement,
               least = Lanes4{} - terms.most_displacement;
  Lanes4 begin = velocity * terms.from, end = velocity * terms.to;
  begin = begin < least ? least : begin;
  begin = most < begin ? most : begin;
  end = end < least ? least : end;
  end = most < end ? most : end;
  const Lanes4 low = end < begin ? end : begin, high = begin < end ? end : begin;
  const double margin = terms.margin * motion.margin;
  Lanes4 lower, upper;
  LowerOf(box, lower);
  LastOf(box, upper);
  upper = __builtin_shufflevector(upper, upper, 1, 2, 3, 0);
  Float4 to_lower, to_upper;
  Outwards(lower + low - margin, -1, to_lower);
  Outwards(upper + high + margin, 1, to_upper);
  first = __builtin_shufflevector(to_lower, to_upper, 0, 1, 2, 4);
  last = __builtin_shufflevector(to_lower, to_upper, 2, 4, 5, 6);
}

void Fatten(const Box* boxes, const BodyMotion* motions, std::size_t count,
            const FatteningTerms& terms, FatBox* fat, const Columns& columns, Box* past) {
  Float4 first[4], last[4];
  const auto fatten = [&](std::size_t i, std::size_t k) __attribute__((always_inline)) {
    FattenOne(boxes[i], motions[i], terms, first[k], last[k]);
    Store(first[k], fat + i);
    Store(last[k], fat[i].lower + 2);
    std::memcpy(past + i, boxes + i, sizeof(Box));
  };
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    for (std::size_t k = 0; k < 4; ++k) fatten(i + k, k);
    Transpose(first);  // lower, upper x
    Transpose(last);   // lower z, upper
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Store(first[axis], columns.lower[axis] + i);
      Store(last[axis + 1], columns.upper[axis] + i);
    }
  }
  for (; i < count; ++i) {
    fatten(i, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      columns.lower[axis][i] = fat[i].lower[axis];
      columns.upper[axis][i] = fat[i].upper[axis];
    }
  }
}

}  // namespace
}  // namespace cdb::kernels
