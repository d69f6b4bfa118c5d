// The loops of kernels.h, for the CPU that the including file is compiled for. Each such file
// includes it once; no other file includes it.
#pragma once

#include "library/detectors/kernels/simd.h"

namespace cdb::kernels {
namespace {

constexpr float kMost = std::numeric_limits<float>::max();
constexpr float kLeast = std::numeric_limits<float>::denorm_min();
constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

/// Rounds outwards. The nearest float is within half a step, so one step further is outside. The
/// smallest float covers subnormals, whose step is not relative to their magnitude.
inline float Below(float x) {
  if (x > kMost) x = kMost;  // a double too large for a float
  return x - ((x < 0 ? -x : x) * 0x1p-23f + kLeast);
}
inline float Above(float x) { return -Below(-x); }

/// Writes box `i`; true if each of its numbers is a float, or it is left out.
inline bool NarrowOne(const Box& box, std::size_t i, const Columns& columns) {
  const double* at = &box.lower.x;
  bool is_exact = true, is_valid = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double lower = at[axis], upper = at[axis + 3];
    is_valid &= lower <= upper;
    float below = static_cast<float>(lower), above = static_cast<float>(upper);
    const bool fits = (static_cast<double>(below) == lower) & (static_cast<double>(above) == upper);
    is_exact &= fits | !(lower <= upper);
    columns.lower[axis][i] = fits ? below : Below(below);
    columns.upper[axis][i] = fits ? above : Above(above);
  }
  if (!is_valid) columns.lower[0][i] = kNotANumber;
  return is_exact;
}

#if defined(__SSE2__)
inline __m128 Below(__m128 x) {
  const __m128 held = _mm_min_ps(_mm_set1_ps(kMost), x);  // of NaN, kMost
  const __m128 size = _mm_andnot_ps(_mm_set1_ps(-0.0f), held);
  return _mm_sub_ps(held, _mm_add_ps(_mm_mul_ps(size, _mm_set1_ps(0x1p-23f)), _mm_set1_ps(kLeast)));
}
inline __m128 Above(__m128 x) {
  const __m128 sign = _mm_set1_ps(-0.0f);
  return _mm_xor_ps(Below(_mm_xor_ps(x, sign)), sign);
}

/// The columns of four boxes.
struct Four {
  __m128 low_x, low_y, low_z, high_x, high_y, high_z;
};

/// Rounds four boxes to the nearest floats and turns them from rows into columns, as the shuffles
/// are cheaper than single stores; true if nothing was rounded.
[[gnu::always_inline]] inline bool LoadFour(const Box* boxes, Four& four) {
  __m128 first[4], second[4];
#if defined(__AVX2__)
  __m256d changed = _mm256_setzero_pd();
#else
  __m128d changed = _mm_setzero_pd();
#endif
  for (std::size_t k = 0; k < 4; ++k) {
    const double* at = &boxes[k].lower.x;
#if defined(__AVX2__)
    const __m256d a = _mm256_loadu_pd(at), b = _mm256_loadu_pd(at + 2);
    first[k] = _mm256_cvtpd_ps(a);
    second[k] = _mm256_cvtpd_ps(b);
    changed = _mm256_or_pd(changed, _mm256_cmp_pd(_mm256_cvtps_pd(first[k]), a, _CMP_NEQ_UQ));
    changed = _mm256_or_pd(changed, _mm256_cmp_pd(_mm256_cvtps_pd(second[k]), b, _CMP_NEQ_UQ));
#else
    const __m128d a = _mm_loadu_pd(at), b = _mm_loadu_pd(at + 2), c = _mm_loadu_pd(at + 4);
    const __m128 x = _mm_cvtpd_ps(a), y = _mm_cvtpd_ps(b), z = _mm_cvtpd_ps(c);
    first[k] = _mm_movelh_ps(x, y);
    second[k] = _mm_movelh_ps(y, z);
    changed = _mm_or_pd(changed, _mm_cmpneq_pd(_mm_cvtps_pd(x), a));
    changed = _mm_or_pd(changed, _mm_cmpneq_pd(_mm_cvtps_pd(y), b));
    changed = _mm_or_pd(changed, _mm_cmpneq_pd(_mm_cvtps_pd(z), c));
#endif
  }
  _MM_TRANSPOSE4_PS(first[0], first[1], first[2], first[3]);      // lower, upper x
  _MM_TRANSPOSE4_PS(second[0], second[1], second[2], second[3]);  // lower z, upper
  four = {first[0], first[1], first[2], first[3], second[2], second[3]};
#if defined(__AVX2__)
  return _mm256_movemask_pd(changed) == 0;
#else
  return _mm_movemask_pd(changed) == 0;
#endif
}

[[gnu::always_inline]] inline void RoundOutwards(Four& four) {
  four.low_x = Below(four.low_x);
  four.low_y = Below(four.low_y);
  four.low_z = Below(four.low_z);
  four.high_x = Above(four.high_x);
  four.high_y = Above(four.high_y);
  four.high_z = Above(four.high_z);
}

/// Writes four boxes from `i` on.
[[gnu::always_inline]] inline void StoreFour(const Four& four, std::size_t i,
                                             const Columns& columns) {
  __m128 valid =
      _mm_and_ps(_mm_cmple_ps(four.low_x, four.high_x), _mm_cmple_ps(four.low_y, four.high_y));
  valid = _mm_and_ps(valid, _mm_cmple_ps(four.low_z, four.high_z));
  const __m128 all = _mm_castsi128_ps(_mm_set1_epi32(-1));
  _mm_storeu_ps(columns.lower[0] + i, _mm_or_ps(four.low_x, _mm_andnot_ps(valid, all)));
  _mm_storeu_ps(columns.lower[1] + i, four.low_y);
  _mm_storeu_ps(columns.lower[2] + i, four.low_z);
  _mm_storeu_ps(columns.upper[0] + i, four.high_x);
  _mm_storeu_ps(columns.upper[1] + i, four.high_y);
  _mm_storeu_ps(columns.upper[2] + i, four.high_z);
}
#endif

bool Narrow(const Box* boxes, std::size_t count, const Columns& columns) {
  bool is_exact = true;
  std::size_t i = 0;
#if defined(__SSE2__)
  for (; i + 4 <= count; i += 4) {
    Four four;
    if (!LoadFour(boxes + i, four)) {  // one of four: all are rounded
      is_exact = false;
      RoundOutwards(four);
    }
    StoreFour(four, i, columns);
  }
#endif
  for (; i < count; ++i)
    if (!NarrowOne(boxes[i], i, columns)) is_exact = false;
  return is_exact;
}

void Bin(const Columns& columns, std::size_t count, const GridShape& shape, std::uint32_t* cells) {
  const std::uint32_t too_long = shape.cells();
  for (std::size_t i = 0; i < count; i += kLanes) {
    std::uint32_t cell[3][kLanes];
    for (int axis = 0; axis < 3; ++axis)
      CellsAt(columns.lower[axis] + i, 0, shape.origin[axis], shape.inverse[axis], shape.last[axis],
              cell[axis]);
    bool fits[kLanes];
    for (std::size_t k = 0; k < kLanes; ++k)
      fits[k] = (columns.upper[0][i + k] - columns.lower[0][i + k] <= shape.reach[0]) &
                (columns.upper[1][i + k] - columns.lower[1][i + k] <= shape.reach[1]) &
                (columns.upper[2][i + k] - columns.lower[2][i + k] <= shape.reach[2]);
    for (std::size_t k = 0; k < kLanes; ++k) {
      const bool is_number = columns.lower[0][i + k] == columns.lower[0][i + k];
      const std::uint32_t at = (cell[2][k] * shape.n[1] + cell[1][k]) * shape.n[0] + cell[0][k];
      cells[i + k] = fits[k] ? at : too_long + !is_number;
    }
  }
}

class Scanner {
 public:
  Scanner(const Columns& columns, const Id* ids, bool anchored, PairSink& sink)
      : columns_(columns), ids_(ids), anchored_(anchored), sink_(sink) {}
  /// The boxes of `begin` to `end` that overlap the probe.
  void Scan(const Probe& probe, Id id, std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; at += kLanes) {
      unsigned mask = probe.Meets(columns_, at);
      if (end - at < kLanes) mask &= (1u << (end - at)) - 1;
      if (mask != 0) Put(mask, id, at);
    }
  }
  void Put(unsigned mask, Id id, std::size_t at) {
    if (sink_.end - sink_.at < static_cast<std::ptrdiff_t>(kLanes)) sink_.grow(sink_);
    sink_.at = Emit(sink_.at, mask, id, ids_ + at, anchored_);
  }

 private:
  const Columns columns_;
  const Id* ids_;
  const bool anchored_;
  PairSink& sink_;
};

Probe ProbeOf(const Columns& columns, std::size_t i) {
  const float lower[3] = {columns.lower[0][i], columns.lower[1][i], columns.lower[2][i]};
  const float upper[3] = {columns.upper[0][i], columns.upper[1][i], columns.upper[2][i]};
  return {lower, upper};
}

/// In whatever cell a box is, those that it meets have lower corners between its own less the reach
/// and its upper corner. Each pair is found by the one that comes first in the order: within its
/// row of cells, and in the rows after it.
void Query(const GridRows& rows, const GridShape& shape, std::size_t begin, std::size_t end,
           PairSink& sink) {
  Scanner scanner(rows.columns, rows.ids, false, sink);
  const std::size_t stride = shape.n[0], ny = shape.n[1];
  const auto cells = [&](const float* const columns[3], std::size_t at, int axis, float less,
                         std::uint32_t* out) {
    CellsAt(columns[axis] + at, less, shape.origin[axis], shape.inverse[axis], shape.last[axis],
            out);
  };
  const std::size_t gridded = end < rows.gridded ? end : rows.gridded;
  for (std::size_t block = begin; block < gridded; block += kLanes) {
    std::uint32_t x0[kLanes], x1[kLanes], y0[kLanes], y1[kLanes], y[kLanes], z[kLanes], z1[kLanes];
    cells(rows.columns.lower, block, 0, shape.reach[0], x0);
    cells(rows.columns.upper, block, 0, 0, x1);
    cells(rows.columns.lower, block, 1, shape.reach[1], y0);
    cells(rows.columns.lower, block, 1, 0, y);
    cells(rows.columns.upper, block, 1, 0, y1);
    cells(rows.columns.lower, block, 2, 0, z);
    cells(rows.columns.upper, block, 2, 0, z1);
    const std::size_t size = gridded - block < kLanes ? gridded - block : kLanes;
    for (std::size_t k = 0; k < size; ++k) {
      const std::size_t i = block + k;
      const Probe probe = ProbeOf(rows.columns, i);
      const Id id = rows.ids[i];
      const std::uint32_t* row = rows.starts + (z[k] * ny + y[k]) * stride;
      scanner.Scan(probe, id, i + 1, row[x1[k] + 1]);
      for (std::size_t u = y[k] + 1; u <= y1[k]; ++u) {
        row += stride;
        scanner.Scan(probe, id, row[x0[k]], row[x1[k] + 1]);
      }
      for (std::size_t w = z[k] + 1; w <= z1[k]; ++w) {
        row = rows.starts + (w * ny + y0[k]) * stride;
        for (std::size_t u = y0[k]; u <= y1[k]; ++u, row += stride)
          scanner.Scan(probe, id, row[x0[k]], row[x1[k] + 1]);
      }
    }
  }
  for (std::size_t i = begin > rows.gridded ? begin : rows.gridded; i < end; ++i)
    scanner.Scan(ProbeOf(rows.columns, i), rows.ids[i], 0, i);
}

void QueryOne(const GridRows& rows, const GridShape& shape, const float* lower, const float* upper,
              Id id, bool is_ordered, PairSink& sink) {
  Scanner scanner(rows.columns, rows.ids, !is_ordered, sink);
  const Probe probe(lower, upper);
  std::uint32_t from[3], to[3];
  for (int axis = 0; axis < 3; ++axis) {
    from[axis] = CellAt(lower[axis] - shape.reach[axis], shape.origin[axis], shape.inverse[axis],
                        shape.last[axis]);
    to[axis] = CellAt(upper[axis], shape.origin[axis], shape.inverse[axis], shape.last[axis]);
    // Boxes that grew are still where they were sorted.
    const std::uint32_t own =
        CellAt(lower[axis], shape.origin[axis], shape.inverse[axis], shape.last[axis]);
    const std::uint32_t least = own > shape.up[axis] ? own - shape.up[axis] : 0;
    from[axis] = least < from[axis] ? least : from[axis];
    const std::uint32_t room = shape.n[axis] - 1 - to[axis];
    to[axis] += shape.down[axis] < room ? shape.down[axis] : room;
  }
  for (std::size_t z = from[2]; z <= to[2]; ++z)
    for (std::size_t y = from[1]; y <= to[1]; ++y) {
      const std::uint32_t* row = rows.starts + (z * shape.n[1] + y) * shape.n[0];
      scanner.Scan(probe, id, row[from[0]], row[to[0] + 1]);
    }
  scanner.Scan(probe, id, rows.gridded, rows.count);
}

void Sweep(const Columns& columns, const Id* ids, std::size_t count, std::size_t begin,
           std::size_t end, PairSink& sink) {
  Scanner scanner(columns, ids, false, sink);
  for (std::size_t i = begin; i < end; ++i) {
    const Probe probe = ProbeOf(columns, i);
    for (std::size_t at = i + 1; at < count; at += kLanes) {
      const unsigned reach = probe.Reaches(columns, at);
      if (reach == 0) break;
      unsigned mask = probe.Meets(columns, at);
      if (count - at < kLanes) mask &= (1u << (count - at)) - 1;
      if (mask != 0) scanner.Put(mask, ids[i], at);
      if (reach != 255) break;  // sorted: no other begins before this one ends
    }
  }
}

std::size_t FindEscaped(const Box* boxes, const FatBox* fat, std::size_t count, Id* escaped) {
  std::size_t found = 0, i = 0;
  for (; i + 4 <= count; i += 4)
    for (unsigned mask = Escapes(boxes + i, fat + i); mask != 0; mask &= mask - 1)
      escaped[found++] = static_cast<Id>(i) + static_cast<Id>(__builtin_ctz(mask));
  for (; i < count; ++i)
    if (!LiesIn(boxes[i], fat[i])) escaped[found++] = static_cast<Id>(i);
  return found;
}

std::size_t FindOutside(const Box* boxes, std::size_t count, const Box& room, Id* outside) {
  const InnerProbe probe(room);
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {  // written always, kept if it is outside: no branch
    outside[found] = static_cast<Id>(i);
    found += !probe.Holds(boxes[i]);
  }
  return found;
}

void Filter(const Box* boxes, const Pair* pairs, std::size_t count, PairSink& sink) {
  constexpr std::size_t kBlock = 64;
  for (std::size_t begin = 0; begin < count; begin += kBlock) {
    const std::size_t end = begin + kBlock < count ? begin + kBlock : count;
    while (static_cast<std::size_t>(sink.end - sink.at) < kBlock) sink.grow(sink);
    Pair* out = sink.at;
    for (std::size_t i = begin; i < end; ++i) {  // written always, kept if they meet: no branch
      const Pair pair = pairs[i];
      *out = pair;
      out += Meet(boxes[pair.a], boxes[pair.b]);
    }
    sink.at = out;
  }
}

void MeetWall(const Box* boxes, std::size_t count, const Box& wall, Id first_wall,
              std::size_t walls, PairSink& sink) {
  const WideProbe probe(wall);
  for (std::size_t i = 0; i < count; ++i) {
    if (!probe.Meets(boxes[i])) continue;
    for (std::size_t k = 0; k < walls; ++k) {
      if (sink.at == sink.end) sink.grow(sink);
      *sink.at++ = {static_cast<Id>(i), first_wall + static_cast<Id>(k)};
    }
  }
}

constexpr Kernels MakeKernels(const char* name) {
  return {name, Narrow, Bin, Query, QueryOne, Sweep, FindEscaped, FindOutside, Filter, MeetWall};
}

}  // namespace
}  // namespace cdb::kernels
