// Tests of eight floats, or of the six doubles of a box, at once: with AVX2, SSE2 or scalar code,
// depending on how the including file is compiled. For kernels_impl.h only.
#pragma once

#include <cstdint>
#include <cstring>
#include <limits>

#include "library/detectors/kernels/kernels.h"

#if defined(__AVX2__)
#include <immintrin.h>
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace cdb::kernels {
namespace {  // compiled for several CPUs: nothing here may have a name outside its file

constexpr std::size_t kLanes = 8;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline std::uint32_t CellAt(float x, float origin, float inverse, float last) {
  const float cell = (x - origin) * inverse;
  return static_cast<std::uint32_t>(cell > 0 ? (cell < last ? cell : last) : 0);
}

inline bool LiesIn(const Box& box, const FatBox& fat) {
  return (fat.lower[0] <= box.lower.x) & (fat.lower[1] <= box.lower.y) &
         (fat.lower[2] <= box.lower.z) & (box.upper.x <= fat.upper[0]) &
         (box.upper.y <= fat.upper[1]) & (box.upper.z <= fat.upper[2]);
}

#if defined(__AVX2__)

/// One box, against eight of the columns.
class Probe {
 public:
  Probe(const float* lower, const float* upper)
      : lower_{_mm256_set1_ps(lower[0]), _mm256_set1_ps(lower[1]), _mm256_set1_ps(lower[2])},
        upper_{_mm256_set1_ps(upper[0]), _mm256_set1_ps(upper[1]), _mm256_set1_ps(upper[2])} {}
  /// A bit for each of the eight from `at` that overlaps.
  unsigned Meets(const Columns& boxes, std::size_t at) const {
    __m256 all = _mm256_and_ps(AtMost(Load(boxes.lower[0] + at), upper_[0]),
                               AtMost(lower_[0], Load(boxes.upper[0] + at)));
    for (int axis = 1; axis < 3; ++axis)
      all = _mm256_and_ps(all, _mm256_and_ps(AtMost(Load(boxes.lower[axis] + at), upper_[axis]),
                                             AtMost(lower_[axis], Load(boxes.upper[axis] + at))));
    return static_cast<unsigned>(_mm256_movemask_ps(all));
  }
  /// A bit for each of the eight that begins before this one ends, along x.
  unsigned Reaches(const Columns& boxes, std::size_t at) const {
    return static_cast<unsigned>(_mm256_movemask_ps(AtMost(Load(boxes.lower[0] + at), upper_[0])));
  }

 private:
  static __m256 Load(const float* at) { return _mm256_loadu_ps(at); }
  static __m256 AtMost(__m256 a, __m256 b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
  __m256 lower_[3], upper_[3];
};

/// Which of four pairs of ints go first: those of the mask's bits, in order.
alignas(32) constexpr std::int32_t kCompress[16][8] = {
    {0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {2, 3, 0, 1, 4, 5, 6, 7},
    {0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 0, 1, 2, 3, 6, 7}, {0, 1, 4, 5, 2, 3, 6, 7},
    {2, 3, 4, 5, 0, 1, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {6, 7, 0, 1, 2, 3, 4, 5},
    {0, 1, 6, 7, 2, 3, 4, 5}, {2, 3, 6, 7, 0, 1, 4, 5}, {0, 1, 2, 3, 6, 7, 4, 5},
    {4, 5, 6, 7, 0, 1, 2, 3}, {0, 1, 4, 5, 6, 7, 2, 3}, {2, 3, 4, 5, 6, 7, 0, 1},
    {0, 1, 2, 3, 4, 5, 6, 7}};

/// Writes (a, ids[k]) for each bit k, the lower first unless `anchored`; has room for eight.
inline Pair* Emit(Pair* out, unsigned mask, Id a, const Id* ids, bool anchored) {
  const __m256i other = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(ids));
  const __m256i one = _mm256_set1_epi32(static_cast<int>(a));
  const __m256i first = anchored ? one : _mm256_min_epu32(one, other);
  const __m256i second = anchored ? other : _mm256_max_epu32(one, other);
  const __m256i low = _mm256_unpacklo_epi32(first, second);   // 0 1 4 5
  const __m256i high = _mm256_unpackhi_epi32(first, second);  // 2 3 6 7
  const unsigned halves[2] = {mask & 15, mask >> 4};
  const __m256i pairs[2] = {_mm256_permute2x128_si256(low, high, 0x20),
                            _mm256_permute2x128_si256(low, high, 0x31)};
  for (int half = 0; half < 2; ++half) {
    const __m256i order =
        _mm256_load_si256(reinterpret_cast<const __m256i*>(kCompress[halves[half]]));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(out),
                        _mm256_permutevar8x32_epi32(pairs[half], order));
    out += __builtin_popcount(halves[half]);
  }
  return out;
}

/// The cells of eight numbers less `less`.
inline void CellsAt(const float* x, float less, float origin, float inverse, float last,
                    std::uint32_t* cells) {
  const __m256 from = _mm256_sub_ps(_mm256_loadu_ps(x), _mm256_set1_ps(less));
  __m256 cell = _mm256_mul_ps(_mm256_sub_ps(from, _mm256_set1_ps(origin)), _mm256_set1_ps(inverse));
  // In this order what is not a number becomes 0.
  cell = _mm256_min_ps(_mm256_max_ps(cell, _mm256_setzero_ps()), _mm256_set1_ps(last));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(cells), _mm256_cvttps_epi32(cell));
}

/// One box against others, in double. The first load of a box is its lower corner and upper x, the
/// second its lower z and upper corner; what is too much meets infinity.
class WideProbe {
 public:
  explicit WideProbe(const Box& box)
      : lower_(_mm256_setr_pd(-kInfinity, box.lower.x, box.lower.y, box.lower.z)),
        upper_(_mm256_setr_pd(box.upper.x, box.upper.y, box.upper.z, kInfinity)) {}
  bool Meets(const Box& box) const {
    const double* at = &box.lower.x;
    const __m256d below = _mm256_cmp_pd(_mm256_loadu_pd(at), upper_, _CMP_LE_OQ);
    const __m256d above = _mm256_cmp_pd(lower_, _mm256_loadu_pd(at + 2), _CMP_LE_OQ);
    return _mm256_movemask_pd(_mm256_and_pd(below, above)) == 15;
  }

 private:
  __m256d lower_, upper_;
};

inline bool Meet(const Box& a, const Box& b) {
  const double *one = &a.lower.x, *other = &b.lower.x;
  // The upper corners moved down to where the lower ones stand; the fourth is not looked at.
  const __m256d a_upper = _mm256_permute4x64_pd(_mm256_loadu_pd(one + 2), 0b111001);
  const __m256d b_upper = _mm256_permute4x64_pd(_mm256_loadu_pd(other + 2), 0b111001);
  const __m256d below = _mm256_cmp_pd(_mm256_loadu_pd(other), a_upper, _CMP_LE_OQ);
  const __m256d above = _mm256_cmp_pd(_mm256_loadu_pd(one), b_upper, _CMP_LE_OQ);
  return (_mm256_movemask_pd(_mm256_and_pd(below, above)) & 7) == 7;
}

/// A bit for each of four boxes that does not lie in its fat one.
inline unsigned Escapes(const Box* boxes, const FatBox* fat) {
  const __m256d first = _mm256_castsi256_pd(_mm256_setr_epi64x(-1, 0, 0, 0));
  const __m256d last = _mm256_castsi256_pd(_mm256_setr_epi64x(0, 0, 0, -1));
  __m256d in[4];
  for (int k = 0; k < 4; ++k) {
    const double* box = &boxes[k].lower.x;
    const float* out = fat[k].lower;
    const __m256d lower =
        _mm256_cmp_pd(_mm256_cvtps_pd(_mm_loadu_ps(out)), _mm256_loadu_pd(box), _CMP_LE_OQ);
    const __m256d upper =
        _mm256_cmp_pd(_mm256_loadu_pd(box + 2), _mm256_cvtps_pd(_mm_loadu_ps(out + 2)), _CMP_LE_OQ);
    in[k] = _mm256_and_pd(_mm256_or_pd(lower, last), _mm256_or_pd(upper, first));
  }
  const __m256d all = _mm256_and_pd(_mm256_and_pd(in[0], in[1]), _mm256_and_pd(in[2], in[3]));
  if (_mm256_movemask_pd(all) == 15) return 0;
  unsigned mask = 0;
  for (unsigned k = 0; k < 4; ++k)
    if (_mm256_movemask_pd(in[k]) != 15) mask |= 1u << k;
  return mask;
}

#else

/// One box, against eight of the columns.
class Probe {
 public:
  Probe(const float* lower, const float* upper) {
    for (int axis = 0; axis < 3; ++axis) {
#if defined(__SSE2__)
      lower_[axis] = _mm_set1_ps(lower[axis]);
      upper_[axis] = _mm_set1_ps(upper[axis]);
#else
      lower_[axis] = lower[axis];
      upper_[axis] = upper[axis];
#endif
    }
  }
  /// A bit for each of the eight from `at` that overlaps.
  unsigned Meets(const Columns& boxes, std::size_t at) const {
#if defined(__SSE2__)
    return Four(boxes, at) | Four(boxes, at + 4) << 4;
#else
    unsigned mask = 0;
    for (std::size_t k = 0; k < kLanes; ++k) {
      bool meets = true;
      for (int axis = 0; axis < 3; ++axis)
        meets = meets & (boxes.lower[axis][at + k] <= upper_[axis]) &
                (lower_[axis] <= boxes.upper[axis][at + k]);
      mask |= static_cast<unsigned>(meets) << k;
    }
    return mask;
#endif
  }
  /// A bit for each of the eight that begins before this one ends, along x.
  unsigned Reaches(const Columns& boxes, std::size_t at) const {
#if defined(__SSE2__)
    const float* x = boxes.lower[0] + at;
    return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(_mm_loadu_ps(x), upper_[0])) |
                                 _mm_movemask_ps(_mm_cmple_ps(_mm_loadu_ps(x + 4), upper_[0]))
                                     << 4);
#else
    unsigned mask = 0;
    for (std::size_t k = 0; k < kLanes; ++k)
      mask |= static_cast<unsigned>(boxes.lower[0][at + k] <= upper_[0]) << k;
    return mask;
#endif
  }

 private:
#if defined(__SSE2__)
  unsigned Four(const Columns& boxes, std::size_t at) const {
    __m128 all = _mm_cmple_ps(_mm_loadu_ps(boxes.lower[0] + at), upper_[0]);
    all = _mm_and_ps(all, _mm_cmple_ps(lower_[0], _mm_loadu_ps(boxes.upper[0] + at)));
    for (int axis = 1; axis < 3; ++axis) {
      all = _mm_and_ps(all, _mm_cmple_ps(_mm_loadu_ps(boxes.lower[axis] + at), upper_[axis]));
      all = _mm_and_ps(all, _mm_cmple_ps(lower_[axis], _mm_loadu_ps(boxes.upper[axis] + at)));
    }
    return static_cast<unsigned>(_mm_movemask_ps(all));
  }
  __m128 lower_[3], upper_[3];
#else
  float lower_[3], upper_[3];
#endif
};

/// Writes (a, ids[k]) for each bit k, the lower first unless `anchored`; has room for eight.
inline Pair* Emit(Pair* out, unsigned mask, Id a, const Id* ids, bool anchored) {
  for (; mask != 0; mask &= mask - 1) {
    const Id b = ids[__builtin_ctz(mask)];
    *out++ = anchored || a < b ? Pair{a, b} : Pair{b, a};
  }
  return out;
}

/// The cells of eight numbers less `less`.
inline void CellsAt(const float* x, float less, float origin, float inverse, float last,
                    std::uint32_t* cells) {
  for (std::size_t k = 0; k < kLanes; ++k) cells[k] = CellAt(x[k] - less, origin, inverse, last);
}

/// One box against others, in double.
class WideProbe {
 public:
#if defined(__SSE2__)
  explicit WideProbe(const Box& box)
      : upper_xy_(_mm_setr_pd(box.upper.x, box.upper.y)),
        upper_z_(_mm_setr_pd(box.upper.z, kInfinity)),
        lower_x_(_mm_setr_pd(-kInfinity, box.lower.x)),
        lower_yz_(_mm_setr_pd(box.lower.y, box.lower.z)) {}
  bool Meets(const Box& box) const {
    const double* at = &box.lower.x;
    const __m128d middle = _mm_loadu_pd(at + 2);  // lower z, upper x
    const __m128d first =
        _mm_and_pd(_mm_cmple_pd(_mm_loadu_pd(at), upper_xy_), _mm_cmple_pd(middle, upper_z_));
    const __m128d second =
        _mm_and_pd(_mm_cmple_pd(lower_x_, middle), _mm_cmple_pd(lower_yz_, _mm_loadu_pd(at + 4)));
    return _mm_movemask_pd(_mm_and_pd(first, second)) == 3;
  }

 private:
  __m128d upper_xy_, upper_z_, lower_x_, lower_yz_;
#else
  explicit WideProbe(const Box& box) : box_(box) {}
  bool Meets(const Box& box) const { return Overlap(box_, box); }

 private:
  Box box_;
#endif
};

inline bool Meet(const Box& a, const Box& b) { return WideProbe(a).Meets(b); }

/// A bit for each of four boxes that does not lie in its fat one.
inline unsigned Escapes(const Box* boxes, const FatBox* fat) {
  unsigned mask = 0;
  for (unsigned k = 0; k < 4; ++k) mask |= static_cast<unsigned>(!LiesIn(boxes[k], fat[k])) << k;
  return mask;
}

#endif

/// A box that others lie inside without touching its sides, in double.
class InnerProbe {
 public:
#if defined(__SSE2__)
  explicit InnerProbe(const Box& box)
      : lower_xy_(_mm_setr_pd(box.lower.x, box.lower.y)),
        middle_(_mm_setr_pd(box.lower.z, -box.upper.x)),
        upper_yz_(_mm_setr_pd(box.upper.y, box.upper.z)) {}
  bool Holds(const Box& box) const {
    const double* at = &box.lower.x;
    const __m128d middle = _mm_xor_pd(_mm_loadu_pd(at + 2), _mm_setr_pd(0, -0.0));
    const __m128d all = _mm_and_pd(_mm_cmplt_pd(middle_, middle),
                                   _mm_and_pd(_mm_cmplt_pd(lower_xy_, _mm_loadu_pd(at)),
                                              _mm_cmplt_pd(_mm_loadu_pd(at + 4), upper_yz_)));
    return _mm_movemask_pd(all) == 3;
  }

 private:
  __m128d lower_xy_, middle_, upper_yz_;
#else
  explicit InnerProbe(const Box& box) : box_(box) {}
  bool Holds(const Box& box) const {
    return (box_.lower.x < box.lower.x) & (box_.lower.y < box.lower.y) &
           (box_.lower.z < box.lower.z) & (box.upper.x < box_.upper.x) &
           (box.upper.y < box_.upper.y) & (box.upper.z < box_.upper.z);
  }

 private:
  Box box_;
#endif
};

}  // namespace
}  // namespace cdb::kernels
