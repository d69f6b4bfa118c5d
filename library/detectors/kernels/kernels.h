// The inner loops of cdb's detectors, each compiled for several kinds of CPU. Plain pointers only:
// a file compiled for a newer CPU must not emit inline functions that the linker could pick for
// all.
//
// Units: metres. Errors: none. Threads: any; the functions have no state.
#pragma once

#include <cstddef>
#include <cstdint>

#include "library/detectors/detector.h"

namespace cdb::kernels {

/// Boxes as columns of floats (SoA), rounded outwards, so that eight are tested at once. A box with
/// a NaN has NaN as its lower x, and overlaps nothing. Each column may be read seven floats past
/// its end.
struct Columns {
  float* lower[3];
  float* upper[3];
};

/// Output of pairs. `grow` makes room for at least eight more.
struct PairSink {
  Pair* at;
  Pair* end;
  void (*grow)(PairSink& sink);
};

/// The cells of a grid: cell = (x - origin) * inverse, clamped to 0 .. last. This is monotonic in
/// x, so that any box, even outside the grid, is found in the cells between those of its corners.
struct GridShape {
  float origin[3];
  float inverse[3];
  float last[3];       ///< number of cells minus one
  float reach[3];      ///< maximum extent of the boxes in cells
  std::uint32_t n[3];  ///< number of cells
  /// By how many cells boxes that grew reach beyond the cell of their lower corner when they were
  /// sorted: downwards, and upwards from it. Zero while none grew.
  std::uint32_t down[3], up[3];
  std::uint32_t cells() const { return n[0] * n[1] * n[2]; }
};

/// Boxes in the order of the cell of their lower corner, x fastest; then the oversized ones.
struct GridRows {
  Columns columns;
  const Id* ids;
  const std::uint32_t* starts;  ///< of the boxes of each cell, and the end of the last
  std::size_t gridded, count;   ///< boxes in cells; all boxes
};

/// An enlarged box that a body is expected to stay in.
struct FatBox {
  float lower[3], upper[3];
};

/// How a body is expected to move: its velocity, per cycle, and a margin for the rest, in m.
struct BodyMotion {
  double velocity[3], margin;
};

/// Terms from which motions are learnt. Times in cycles; zero where nothing is known.
struct MotionTerms {
  double predicted;                ///< cycles for which boxes kept their velocity
  double per_age, per_recent_age;  ///< 1 / time since `past`, since `marks`
  double margin, most_margin;      ///< of a body
};

/// Terms by which boxes are enlarged: the displacements from `from` to `to` cycles from now, each
/// at most `most_displacement`, and `margin` times the body's margin.
struct FatteningTerms {
  double from, to, most_displacement, margin;
};

/// Bits in an element of `met` of find_changed.
inline constexpr std::size_t kMetBits = 64;

struct Kernels {
  const char* name;
  /// Fills the columns; true if every number is representable as float, so that nothing was
  /// rounded.
  bool (*narrow)(const Box* boxes, std::size_t count, const Columns& columns);
  /// The cell of each box; `cells()` if oversized, `cells() + 1` if a coordinate is NaN.
  void (*bin)(const Columns& columns, std::size_t count, const GridShape& shape,
              std::uint32_t* cells);
  /// Pairs of the boxes `begin` to `end` with those that follow; of oversized boxes with those that
  /// precede.
  void (*query)(const GridRows& rows, const GridShape& shape, std::size_t begin, std::size_t end,
                PairSink& sink);
  /// Pairs (id, other) of a box, rounded outwards, with all boxes of the grid; the lower id first
  /// if `is_ordered`.
  void (*query_one)(const GridRows& rows, const GridShape& shape, const float* lower,
                    const float* upper, Id id, bool is_ordered, PairSink& sink);
  /// Pairs of the boxes `begin` to `end` with those that follow, sorted by columns.lower[0].
  void (*sweep)(const Columns& columns, const Id* ids, std::size_t count, std::size_t begin,
                std::size_t end, PairSink& sink);
  /// Learns the motions of `count` bodies. A body that is further than the margin from its
  /// predicted position has turned round: its velocity is measured since `marks`, if they are
  /// known.
  void (*learn)(const Box* boxes, const Box* past, const Box* marks, std::size_t count,
                const MotionTerms& terms, BodyMotion* motions);
  /// Enlarges `count` boxes, rounded outwards, into `fat` and the columns, and copies them to
  /// `past`.
  void (*fatten)(const Box* boxes, const BodyMotion* motions, std::size_t count,
                 const FatteningTerms& terms, FatBox* fat, const Columns& columns, Box* past);
  /// Lists the boxes that have left their fat boxes; `escaped` has room for all.
  std::size_t (*find_escaped)(const Box* boxes, const FatBox* fat, std::size_t count, Id* escaped);
  /// Lists the boxes that do not lie inside `room`, without touching its sides; `outside` has room
  /// for all.
  std::size_t (*find_outside)(const Box* boxes, std::size_t count, const Box& room, Id* outside);
  /// The pairs whose boxes overlap, in double.
  void (*filter)(const Box* boxes, const Pair* pairs, std::size_t count, PairSink& sink);
  /// The pairs for which `met` differs from whether their boxes overlap, in double. Updates `met`:
  /// a bit for each pair, kMetBits in an element, lowest first; bits beyond the last pair are zero.
  void (*find_changed)(const Box* boxes, const Pair* pairs, std::uint64_t* met, std::size_t count,
                       PairSink& sink);
  /// Pairs of the boxes 0 to `count` with `walls` bodies that share a box, from the id `first_wall`
  /// on; in double.
  void (*meet_wall)(const Box* boxes, std::size_t count, const Box& wall, Id first_wall,
                    std::size_t walls, PairSink& sink);
};

/// For every CPU.
const Kernels& PlainKernels();
/// For CPUs with AVX2; null if this CPU or the compiler does not support it.
const Kernels* Avx2Kernels();
/// The fastest kernels that this CPU supports.
const Kernels& BestKernels();

}  // namespace cdb::kernels
