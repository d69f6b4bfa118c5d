// SIMD vectors, and the box tests that use them, for kernels_impl.h only.
//
// Uses the vector extensions of GCC and Clang, so that one source serves every CPU, and intrinsics
// only where these have no operator, or where GCC 12 generates more than one instruction. Neither
// Highway nor xsimd is used: as packaged in Debian 12, the former is scalar on an x86-64 without
// SSSE3, and the latter lacks the bits of a mask and conversions between floats and doubles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "library/detectors/kernels/kernels.h"

#if defined(__SSE2__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace cdb::kernels {
namespace {  // compiled for several CPUs: everything needs internal linkage

constexpr std::size_t kLanes = 8;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

#if defined(__AVX2__)
constexpr std::size_t kRegister = 32;  // bytes
#else
constexpr std::size_t kRegister = 16;
#endif

template <typename T, std::size_t bytes>
struct VectorOf {
  typedef T Type __attribute__((vector_size(bytes)));
};
/// One register of numbers. GCC splits wider vectors into scalars.
using Floats = VectorOf<float, kRegister>::Type;
using Doubles = VectorOf<double, kRegister>::Type;
constexpr std::size_t kFloats = kRegister / sizeof(float), kDoubles = kRegister / sizeof(double);
/// As many floats as a register holds doubles.
using HalfFloats = VectorOf<float, kRegister / 2>::Type;
using Float4 = VectorOf<float, 16>::Type;
using Double2 = VectorOf<double, 16>::Type;

/// The result of a comparison: all bits of a lane, or none.
template <typename V>
using Mask = decltype(V{} < V{});

template <typename V, typename T>
[[gnu::always_inline]] inline V Load(const T* at) {
  V to;
  std::memcpy(&to, at, sizeof to);
  return to;
}
template <typename V, typename T>
[[gnu::always_inline]] inline void Store(V from, T* at) {
  std::memcpy(at, &from, sizeof from);
}
template <typename V>
[[gnu::always_inline]] inline V Repeat(float x) {
  return x - V{};  // keeps the value, and the sign of a zero
}

#if defined(__SSE2__)
inline auto AtMost(__m128 a, __m128 b) { return Mask<Float4>(_mm_cmple_ps(a, b)); }
inline auto AtMost(__m128d a, __m128d b) { return Mask<Double2>(_mm_cmple_pd(a, b)); }
inline auto IsLess(__m128d a, __m128d b) { return Mask<Double2>(_mm_cmplt_pd(a, b)); }
inline auto Differs(__m128d a, __m128d b) { return Mask<Double2>(_mm_cmpneq_pd(a, b)); }
/// The smaller one, or `b` if one is NaN.
inline Float4 Least(Float4 a, Float4 b) { return _mm_min_ps(a, b); }
inline int BitsOf(Mask<Float4> mask) { return _mm_movemask_ps(__m128(mask)); }
inline int BitsOf(Mask<Double2> mask) { return _mm_movemask_pd(__m128d(mask)); }
#else
template <typename V>
inline Mask<V> AtMost(V a, V b) {
  return a <= b;
}
inline Mask<Double2> IsLess(Double2 a, Double2 b) { return a < b; }
inline Mask<Double2> Differs(Double2 a, Double2 b) { return a != b; }
inline Float4 Least(Float4 a, Float4 b) { return a < b ? a : b; }
inline int BitsOf(Mask<Float4> mask) {
  mask &= Mask<Float4>{1, 2, 4, 8};
#if defined(__aarch64__)
  return vaddvq_s32(mask);
#else
  return mask[0] | mask[1] | mask[2] | mask[3];
#endif
}
inline int BitsOf(Mask<Double2> mask) { return static_cast<int>((mask[0] & 1) | (mask[1] & 2)); }
#endif
#if defined(__AVX2__)
inline auto AtMost(__m256 a, __m256 b) { return Mask<Floats>(_mm256_cmp_ps(a, b, _CMP_LE_OQ)); }
inline auto AtMost(__m256d a, __m256d b) { return Mask<Doubles>(_mm256_cmp_pd(a, b, _CMP_LE_OQ)); }
inline auto Differs(__m256d a, __m256d b) {
  return Mask<Doubles>(_mm256_cmp_pd(a, b, _CMP_NEQ_UQ));
}
inline int BitsOf(Mask<Floats> mask) { return _mm256_movemask_ps(__m256(mask)); }
inline int BitsOf(Mask<Doubles> mask) { return _mm256_movemask_pd(__m256d(mask)); }
inline Doubles Widened(HalfFloats x) { return _mm256_cvtps_pd(x); }
#else
inline Doubles Widened(HalfFloats x) { return __builtin_convertvector(x, Doubles); }
#endif

inline std::uint32_t CellAt(float x, float origin, float inverse, float last) {
  const float cell = (x - origin) * inverse;
  return static_cast<std::uint32_t>(cell > 0 ? (cell < last ? cell : last) : 0);
}

/// The cells of the coordinates in a register.
[[gnu::always_inline]] inline void CellsAt(Floats x, float origin, float inverse, float last,
                                           Mask<Floats>& cells) {
  Floats cell = (x - origin) * inverse;
  const Floats most = Repeat<Floats>(last);
  cell = cell > Floats{} ? cell : Floats{};  // NaN becomes 0 as well
  cell = cell < most ? cell : most;
  cells = __builtin_convertvector(cell, Mask<Floats>);
}

/// The cells of eight coordinates, each reduced by `less`.
inline void CellsAt(const float* x, float less, float origin, float inverse, float last,
                    std::uint32_t* cells) {
  for (std::size_t k = 0; k < kLanes; k += kFloats) {
    Mask<Floats> these;
    CellsAt(Load<Floats>(x + k) - less, origin, inverse, last, these);
    Store(these, cells + k);
  }
}

/// A box that is tested with eight boxes of the columns at once.
class Probe {
 public:
  [[gnu::always_inline]] Probe(const float* lower, const float* upper) {
    for (int axis = 0; axis < 3; ++axis) {
      lower_[axis] = Repeat<Floats>(lower[axis]);
      upper_[axis] = Repeat<Floats>(upper[axis]);
    }
  }
  /// A bit for each of the eight boxes from `at` on that overlaps.
  unsigned Meets(const Columns& boxes, std::size_t at) const {
    int bits = 0;
    for (std::size_t k = 0; k < kLanes; k += kFloats) {
      auto all = AtMost(Load<Floats>(boxes.lower[0] + at + k), upper_[0]) &
                 AtMost(lower_[0], Load<Floats>(boxes.upper[0] + at + k));
      for (int axis = 1; axis < 3; ++axis)
        all &= AtMost(Load<Floats>(boxes.lower[axis] + at + k), upper_[axis]) &
               AtMost(lower_[axis], Load<Floats>(boxes.upper[axis] + at + k));
      bits |= BitsOf(all) << k;
    }
    return static_cast<unsigned>(bits);
  }
  /// A bit for each of the eight boxes that begins before this one ends, along x.
  unsigned Reaches(const Columns& boxes, std::size_t at) const {
    int bits = 0;
    for (std::size_t k = 0; k < kLanes; k += kFloats)
      bits |= BitsOf(AtMost(Load<Floats>(boxes.lower[0] + at + k), upper_[0])) << k;
    return static_cast<unsigned>(bits);
  }

 private:
  Floats lower_[3], upper_[3];
};

#if defined(__AVX2__)
/// The order that moves the pairs of the mask's bits to the front, for four pairs of ints.
alignas(32) constexpr std::int32_t kCompress[16][8] = {
    {0, 1, 2, 3, 4, 5, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {2, 3, 0, 1, 4, 5, 6, 7},
    {0, 1, 2, 3, 4, 5, 6, 7}, {4, 5, 0, 1, 2, 3, 6, 7}, {0, 1, 4, 5, 2, 3, 6, 7},
    {2, 3, 4, 5, 0, 1, 6, 7}, {0, 1, 2, 3, 4, 5, 6, 7}, {6, 7, 0, 1, 2, 3, 4, 5},
    {0, 1, 6, 7, 2, 3, 4, 5}, {2, 3, 6, 7, 0, 1, 4, 5}, {0, 1, 2, 3, 6, 7, 4, 5},
    {4, 5, 6, 7, 0, 1, 2, 3}, {0, 1, 4, 5, 6, 7, 2, 3}, {2, 3, 4, 5, 6, 7, 0, 1},
    {0, 1, 2, 3, 4, 5, 6, 7}};
#endif

/// Writes (a, ids[k]) for each bit k, the lower first unless `anchored`; has room for eight.
inline Pair* Emit(Pair* out, unsigned mask, Id a, const Id* ids, bool anchored) {
#if defined(__AVX2__)
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
#else
  for (; mask != 0; mask &= mask - 1) {
    const Id b = ids[__builtin_ctz(mask)];
    *out++ = anchored || a < b ? Pair{a, b} : Pair{b, a};
  }
#endif
  return out;
}

[[gnu::always_inline]] inline void Transpose(Float4 (&rows)[4]) {
  const Float4 a = __builtin_shufflevector(rows[0], rows[1], 0, 4, 1, 5);
  const Float4 b = __builtin_shufflevector(rows[0], rows[1], 2, 6, 3, 7);
  const Float4 c = __builtin_shufflevector(rows[2], rows[3], 0, 4, 1, 5);
  const Float4 d = __builtin_shufflevector(rows[2], rows[3], 2, 6, 3, 7);
  rows[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  rows[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  rows[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  rows[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/// Four doubles, or the masks of four, in one register or two.
template <typename V>
struct Four {
  static constexpr std::size_t kParts = 4 / kDoubles;
  V part[kParts];
  friend Four operator&(const Four& a, const Four& b) {
    Four to;
    for (std::size_t k = 0; k < kParts; ++k) to.part[k] = a.part[k] & b.part[k];
    return to;
  }
  friend Four operator|(const Four& a, const Four& b) {
    Four to;
    for (std::size_t k = 0; k < kParts; ++k) to.part[k] = a.part[k] | b.part[k];
    return to;
  }
  bool All() const {
    if constexpr (kParts == 1)
      return BitsOf(part[0]) == 15;
    else
      return BitsOf(part[0] & part[kParts - 1]) == 3;
  }
};
using Double4 = Four<Doubles>;
using Mask4 = Four<Mask<Doubles>>;

template <typename T>
[[gnu::always_inline]] inline Double4 Load4(const T* at) {
  Double4 to;
  for (Doubles& part : to.part) {
    if constexpr (sizeof *at == sizeof(float))
      part = Widened(Load<HalfFloats>(at));
    else
      part = Load<Doubles>(at);
    at += kDoubles;
  }
  return to;
}
template <typename V, typename T>
[[gnu::always_inline]] inline Four<V> Make4(T a, T b, T c, T d) {
#if defined(__AVX2__)
  return {V{a, b, c, d}};
#else
  return {V{a, b}, V{c, d}};
#endif
}
[[gnu::always_inline]] inline Mask4 AtMost(const Double4& a, const Double4& b) {
  Mask4 to;
  for (std::size_t k = 0; k < Mask4::kParts; ++k) to.part[k] = AtMost(a.part[k], b.part[k]);
  return to;
}

/// A box that is tested with others, in double. The first load of a box is its lower corner and
/// upper x, the second its lower z and upper corner; surplus lanes are compared with infinity.
class WideProbe {
 public:
  explicit WideProbe(const Box& box)
      : lower_(Make4<Doubles>(-kInfinity, box.lower.x, box.lower.y, box.lower.z)),
        upper_(Make4<Doubles>(box.upper.x, box.upper.y, box.upper.z, kInfinity)) {}
  bool Meets(const Box& box) const {
    const double* at = &box.lower.x;
    return (AtMost(Load4(at), upper_) & AtMost(lower_, Load4(at + 2))).All();
  }

 private:
  Double4 lower_, upper_;
};

inline bool Meet(const Box& a, const Box& b) {
#if defined(__AVX2__)
  const double *one = &a.lower.x, *other = &b.lower.x;
  // Moves the upper corners to the lanes of the lower ones; the fourth lane is ignored.
  const __m256d a_upper = _mm256_permute4x64_pd(_mm256_loadu_pd(one + 2), 0b111001);
  const __m256d b_upper = _mm256_permute4x64_pd(_mm256_loadu_pd(other + 2), 0b111001);
  // With this order of operands, the lower corners are read from memory.
  const __m256d in_a = _mm256_cmp_pd(a_upper, _mm256_loadu_pd(other), _CMP_GE_OQ);
  const __m256d in_b = _mm256_cmp_pd(b_upper, _mm256_loadu_pd(one), _CMP_GE_OQ);
  return (_mm256_movemask_pd(_mm256_and_pd(in_a, in_b)) & 7) == 7;
#else
  return WideProbe(a).Meets(b);
#endif
}

inline bool LiesIn(const Box& box, const FatBox& fat) {
  return (fat.lower[0] <= box.lower.x) & (fat.lower[1] <= box.lower.y) &
         (fat.lower[2] <= box.lower.z) & (box.upper.x <= fat.upper[0]) &
         (box.upper.y <= fat.upper[1]) & (box.upper.z <= fat.upper[2]);
}

/// A bit for each of four boxes that does not lie in its fat one.
[[gnu::always_inline]] inline unsigned Escapes(const Box* boxes, const FatBox* fat) {
  const Mask4 first = Make4<Mask<Doubles>>(-1, 0, 0, 0), last = Make4<Mask<Doubles>>(0, 0, 0, -1);
  Mask4 in[4];
  for (int k = 0; k < 4; ++k) {
    const double* box = &boxes[k].lower.x;
    const float* out = fat[k].lower;  // the upper corner follows
    in[k] =
        (AtMost(Load4(out), Load4(box)) | last) & (AtMost(Load4(box + 2), Load4(out + 2)) | first);
  }
  if ((in[0] & in[1] & in[2] & in[3]).All()) return 0;
  unsigned mask = 0;
  for (unsigned k = 0; k < 4; ++k)
    if (!in[k].All()) mask |= 1u << k;
  return mask;
}

/// A box that others lie inside without touching its sides, in double.
class InnerProbe {
 public:
  explicit InnerProbe(const Box& box)
      : lower_xy_{box.lower.x, box.lower.y},
        middle_{box.lower.z, -box.upper.x},
        upper_yz_{box.upper.y, box.upper.z} {}
  bool Holds(const Box& box) const {
    const double* at = &box.lower.x;
    return BitsOf(IsLess(middle_, Load<Double2>(at + 2) * Double2{1, -1}) &
                  IsLess(lower_xy_, Load<Double2>(at)) &
                  IsLess(Load<Double2>(at + 4), upper_yz_)) == 3;
  }

 private:
  Double2 lower_xy_, middle_, upper_yz_;
};

}  // namespace
}  // namespace cdb::kernels
