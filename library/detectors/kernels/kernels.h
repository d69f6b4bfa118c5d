// The loops that our detectors spend their time in, each once for every kind of CPU that it is
// compiled for. Plain pointers only: a file compiled for a newer CPU must not leave code behind
// that the linker could take for everybody.
//
// Units: metres. Errors: none. Threads: any, as nothing is kept.
#pragma once

#include <cstddef>
#include <cstdint>

#include "library/detectors/detector.h"

namespace cdb::kernels {

/// Boxes as columns of floats, rounded outwards, so that eight are tested at once. A box that is
/// not a number has a lower x that is none, which overlaps nothing. Each column may be read seven
/// floats past its end.
struct Columns {
  float* lower[3];
  float* upper[3];
};

/// Where pairs go. `grow` makes room, at least for eight more.
struct PairSink {
  Pair* at;
  Pair* end;
  void (*grow)(PairSink& sink);
};

/// How a grid divides space: cell = (x - origin) * inverse, held between 0 and last. That rises
/// with x, so a box that lies anywhere, even outside, is found in the cells between those of its
/// ends.
struct GridShape {
  float origin[3];
  float inverse[3];
  float last[3];       ///< the number of cells less one
  float reach[3];      ///< no box in a cell is longer
  std::uint32_t n[3];  ///< cells
  std::uint32_t cells() const { return n[0] * n[1] * n[2]; }
};

/// Boxes in the order of their lower corner's cell, x fastest; then those too long for the grid.
struct GridRows {
  Columns columns;
  const Id* ids;
  const std::uint32_t* starts;  ///< of each cell's boxes, and the end of the last
  std::size_t gridded, count;   ///< boxes in cells; with those too long
};

/// A box that others shall stay in.
struct FatBox {
  float lower[3], upper[3];
};

struct Kernels {
  const char* name;
  /// Fills the columns; true where each number is a float, so that nothing was rounded.
  bool (*narrow)(const Box* boxes, std::size_t count, const Columns& columns);
  /// The cell of each box, `cells()` for one too long, `cells() + 1` for one that is not a number.
  void (*bin)(const Columns& columns, std::size_t count, const GridShape& shape,
              std::uint32_t* cells);
  /// Pairs of the boxes at begin to end with those that come after them; of boxes too long with
  /// those before.
  void (*query)(const GridRows& rows, const GridShape& shape, std::size_t begin, std::size_t end,
                PairSink& sink);
  /// Pairs (id, other) of one box, rounded outwards, with all of the grid.
  void (*query_one)(const GridRows& rows, const GridShape& shape, const float* lower,
                    const float* upper, Id id, PairSink& sink);
  /// Pairs of the boxes at begin to end with those behind them, all sorted by columns.lower[0].
  /// Gives the number of tests, eight boxes each.
  std::size_t (*sweep)(const Columns& columns, const Id* ids, std::size_t count, std::size_t begin,
                       std::size_t end, PairSink& sink);
  /// Lists the boxes that do not lie in their fat ones; `strays` has room for all.
  std::size_t (*find_strays)(const Box* boxes, const FatBox* fat, std::size_t count, Id* strays);
  /// Those of the pairs whose boxes overlap. In double.
  void (*filter)(const Box* boxes, const Pair* pairs, std::size_t count, PairSink& sink);
  /// Pairs of boxes 0 to count with `walls` bodies from `first_wall` that share one box. In double.
  void (*meet_wall)(const Box* boxes, std::size_t count, const Box& wall, Id first_wall,
                    std::size_t walls, PairSink& sink);
};

/// For every CPU.
const Kernels& PlainKernels();
/// For CPUs with AVX2; null where this one has not, or the compiler knows none.
const Kernels* Avx2Kernels();
/// The fastest that this CPU runs.
const Kernels& BestKernels();

}  // namespace cdb::kernels
