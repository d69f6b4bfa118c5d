// Every kernel on random boxes with NaN, infinities and subnormals, compared with scalar loops.
// This program uses no test framework, because it is also built for other CPUs. Prints the faults,
// or a digest of all results, which must be the same on every CPU.

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::tests {
namespace {

using namespace cdb::kernels;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kPadding = 16;  // kernels read past the end

class Check {
 public:
  explicit Check(const Kernels& kernels) : kernels_(kernels) {}
  void Run() {
    for (std::size_t round = 0; round < 60; ++round) {
      DrawBoxes(round * 7 % 200, round % 4);
      CheckNarrow(round % 4 == 0);
      CheckWide();
      CheckGrid();
      CheckSweep();
    }
  }
  std::uint64_t digest() const { return digest_; }
  bool failed() const { return failed_; }

 private:
  void Expect(bool holds, const char* what) {
    if (holds) return;
    if (!failed_) std::printf("%s: wrong %s of %zu boxes\n", kernels_.name, what, boxes_.size());
    failed_ = true;
  }
  void Digest(std::uint64_t x) {
    digest_ = (digest_ ^ x) * 0x9e3779b97f4a7c15u;
    digest_ ^= digest_ >> 29;
  }
  void DigestFloat(float x) { Digest(x != x ? 1u : std::bit_cast<std::uint32_t>(x)); }

  /// Uniform in -8 .. 8.
  double Uniform() { return static_cast<double>(random_() >> 11) * 0x1p-49 - 8; }
  double Special() {
    constexpr double kSpecial[] = {std::numeric_limits<double>::quiet_NaN(),
                                   kInfinity,
                                   -kInfinity,
                                   0.0,
                                   -0.0,
                                   5e-324,
                                   -3e-310,
                                   1e-40,
                                   -1e-45,
                                   1e300,
                                   -1e300,
                                   3.5e38};
    return kSpecial[random_() % std::size(kSpecial)];
  }
  /// `kind`: 0 numbers that are floats, so that sides touch; 1 any numbers; 2 and 3 with special
  /// values.
  void DrawBoxes(std::size_t count, std::size_t kind) {
    boxes_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      double corner[6];
      for (std::size_t k = 0; k < 3; ++k) {
        corner[k] = Uniform();
        if (kind == 0) corner[k] = static_cast<int>(corner[k] * 4) / 4.;
        corner[k + 3] = corner[k] + (random_() % 16 == 0 ? 6 : 0.75);
      }
      if (kind >= 2 && random_() % 4 == 0) corner[random_() % 6] = Special();
      boxes_.push_back({{corner[0], corner[1], corner[2]}, {corner[3], corner[4], corner[5]}});
    }
  }

  void CheckNarrow(bool is_exact) {
    soa_.Reserve(boxes_.size());
    const Columns& columns = soa_.get();
    const bool exact = kernels_.narrow(boxes_.data(), boxes_.size(), columns);
    Expect(exact || !is_exact, "narrow: exactness");
    Digest(exact);
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const double* at = &boxes_[i].lower.x;
      bool is_valid = true, has_nan = false;
      for (std::size_t k = 0; k < 3; ++k) {
        is_valid &= at[k] <= at[k + 3];
        has_nan |= at[k] != at[k] || at[k + 3] != at[k + 3];
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const float lower = columns.lower[k][i], upper = columns.upper[k][i];
        DigestFloat(lower);
        DigestFloat(upper);
        if (!is_valid) continue;
        const bool holds =
            exact ? lower == at[k] && upper == at[k + 3] : lower <= at[k] && at[k + 3] <= upper;
        Expect(holds, "narrow: corner");
        // Two steps of a float, or of the smallest float.
        const auto near = [](double x, float y) {
          return std::abs(x) > 3e38 || std::abs(x - y) <= std::abs(x) * 0x1p-21 + 1e-44;
        };
        Expect(near(at[k], lower) && near(at[k + 3], upper), "narrow: distance");
      }
      if (has_nan) Expect(columns.lower[0][i] != columns.lower[0][i], "narrow: NaN");
    }
  }

  void ExpectIds(std::vector<Id> found, std::size_t count, const std::vector<Id>& expected,
                 const char* what) {
    found.resize(count);
    Expect(found == expected, what);
    for (const Id id : found) Digest(std::uint64_t{id});
  }
  void ExpectPairs(PairBuffer& pairs, std::vector<Pair> expected, bool in_order, const char* what) {
    std::vector<Pair> found(pairs.pairs().begin(), pairs.pairs().end());
    for (const Pair& pair : found) Digest(std::uint64_t{pair.a} << 32 | pair.b);
    if (!in_order) {
      std::ranges::sort(found);
      std::ranges::sort(expected);
    }
    Expect(found == expected, what);
    pairs.Clear();
  }

  /// Checks the kernels that read boxes of doubles.
  void CheckWide() {
    const std::size_t count = boxes_.size();
    std::vector<FatBox> fat(count);
    std::vector<Id> ids(count), escaped, outside;
    const Box room = {{-4, -5, -6}, {4, 5, kInfinity}};
    for (std::size_t i = 0; i < count; ++i) {
      const double* at = &boxes_[i].lower.x;
      bool lies = true, holds = true;
      for (std::size_t k = 0; k < 3; ++k) {
        fat[i].lower[k] = static_cast<float>(at[k]) - (random_() % 8 == 0 ? -1 : 1e-3f);
        fat[i].upper[k] = static_cast<float>(at[k + 3]) + (random_() % 8 == 0 ? 0 : 1e-3f);
        lies &= static_cast<double>(fat[i].lower[k]) <= at[k] &&
                at[k + 3] <= static_cast<double>(fat[i].upper[k]);
        holds &= (&room.lower.x)[k] < at[k] && at[k + 3] < (&room.upper.x)[k];
      }
      if (!lies) escaped.push_back(static_cast<Id>(i));
      if (!holds) outside.push_back(static_cast<Id>(i));
    }
    std::size_t found = kernels_.find_escaped(boxes_.data(), fat.data(), count, ids.data());
    ExpectIds(ids, found, escaped, "find_escaped");
    ids.resize(count);
    found = kernels_.find_outside(boxes_.data(), count, room, ids.data());
    ExpectIds(ids, found, outside, "find_outside");
    std::vector<Pair> candidates, expected;
    for (std::size_t i = 0; i < 5 * count; ++i) {
      const Pair pair = {static_cast<Id>(random_() % count), static_cast<Id>(random_() % count)};
      candidates.push_back(pair);
      if (Overlap(boxes_[pair.a], boxes_[pair.b])) expected.push_back(pair);
    }
    kernels_.filter(boxes_.data(), candidates.data(), candidates.size(), pairs_.sink());
    ExpectPairs(pairs_, expected, true, "filter");
    expected.clear();
    std::vector<std::uint64_t> met(candidates.size() / 64 + 1), meet(met.size());
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const bool did = random_() % 2 != 0;
      const bool does = Overlap(boxes_[candidates[i].a], boxes_[candidates[i].b]);
      met[i / 64] |= std::uint64_t{did} << i % 64;
      meet[i / 64] |= std::uint64_t{does} << i % 64;
      if (did != does) expected.push_back(candidates[i]);
    }
    kernels_.find_changed(boxes_.data(), candidates.data(), met.data(), candidates.size(),
                          pairs_.sink());
    ExpectPairs(pairs_, expected, true, "find_changed");
    Expect(met == meet, "flags of find_changed");
    expected.clear();
    const Box wall = {{-kInfinity, -2, -kInfinity}, {kInfinity, 1, kInfinity}};
    for (std::size_t i = 0; i < count; ++i)
      for (Id k = 0; Overlap(boxes_[i], wall) && k < 3; ++k)
        expected.push_back({static_cast<Id>(i), 1000 + k});
    kernels_.meet_wall(boxes_.data(), count, wall, 1000, 3, pairs_.sink());
    ExpectPairs(pairs_, expected, true, "meet_wall");
  }

  static bool Meet(const Columns& columns, std::size_t i, std::size_t k) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!(columns.lower[axis][i] <= columns.upper[axis][k] &&
            columns.lower[axis][k] <= columns.upper[axis][i]))
        return false;
    return true;
  }
  static void Copy(const Columns& from, std::size_t i, const Columns& to, std::size_t k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      to.lower[axis][k] = from.lower[axis][i];
      to.upper[axis][k] = from.upper[axis][i];
    }
  }
  /// The pairs of the columns of `rows`, whose order differs from that of the bodies.
  static std::vector<Pair> AllPairs(const Columns& columns, const std::vector<Id>& ids,
                                    std::size_t count) {
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = i + 1; k < count; ++k)
        if (Meet(columns, i, k))
          pairs.push_back({std::min(ids[i], ids[k]), std::max(ids[i], ids[k])});
    return pairs;
  }

  void CheckGrid() {
    GridShape shape = {};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      shape.n[axis] = static_cast<std::uint32_t>(5 - axis);
      shape.origin[axis] = -7.3f;
      shape.inverse[axis] = 0.3f;
      shape.last[axis] = static_cast<float>(shape.n[axis] - 1);
      shape.reach[axis] = 1.1f;
    }
    const std::uint32_t cells = shape.cells();
    std::vector<std::uint32_t> cell(boxes_.size() + kPadding);
    kernels_.bin(soa_.get(), boxes_.size(), shape, cell.data());
    std::vector<std::uint32_t> starts = {0};
    std::vector<Id> ids;
    SoaBoxes sorted;
    sorted.Reserve(boxes_.size());
    for (std::uint32_t at = 0; at <= cells; ++at) {
      for (std::size_t i = 0; i < boxes_.size(); ++i) {
        if (cell[i] != at) continue;
        Copy(soa_.get(), i, sorted.get(), ids.size());
        ids.push_back(static_cast<Id>(i));
      }
      starts.push_back(static_cast<std::uint32_t>(ids.size()));
    }
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      Digest(std::uint64_t{cell[i]});
      const bool is_number = soa_.get().lower[0][i] == soa_.get().lower[0][i];
      Expect(cell[i] <= cells || !is_number, "bin");
    }
    const std::size_t count = ids.size();
    ids.resize(count + kPadding);
    const GridRows rows = {sorted.get(), ids.data(), starts.data(), starts[cells], count};
    kernels_.query(rows, shape, 0, count, pairs_.sink());
    ExpectPairs(pairs_, AllPairs(sorted.get(), ids, count), false, "query");
    for (std::size_t i = 0; i < count; i += 9) CheckQueryOne(rows, shape, i);
  }
  void CheckQueryOne(const GridRows& rows, const GridShape& shape, std::size_t i) {
    const Columns& columns = rows.columns;
    const float lower[] = {columns.lower[0][i], columns.lower[1][i], columns.lower[2][i]};
    const float upper[] = {columns.upper[0][i], columns.upper[1][i], columns.upper[2][i]};
    std::vector<Pair> expected;
    for (std::size_t k = 0; k < rows.count; ++k)
      if (Meet(columns, i, k)) expected.push_back({100, rows.ids[k]});
    kernels_.query_one(rows, shape, lower, upper, 100, false, pairs_.sink());
    ExpectPairs(pairs_, expected, false, "query_one");
    for (Pair& pair : expected) pair = {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
    kernels_.query_one(rows, shape, lower, upper, 100, true, pairs_.sink());
    ExpectPairs(pairs_, expected, false, "query_one, ordered");
  }

  void CheckSweep() {
    std::vector<Id> ids;
    const Columns& from = soa_.get();
    for (std::size_t i = 0; i < boxes_.size(); ++i)
      if (from.lower[0][i] == from.lower[0][i]) ids.push_back(static_cast<Id>(i));
    std::ranges::sort(ids, {}, [&](Id id) { return std::pair(from.lower[0][id], id); });
    SoaBoxes sorted;
    sorted.Reserve(ids.size());
    for (std::size_t k = 0; k < ids.size(); ++k) Copy(from, ids[k], sorted.get(), k);
    const std::size_t count = ids.size();
    ids.resize(count + kPadding);
    kernels_.sweep(sorted.get(), ids.data(), count, 0, count, pairs_.sink());
    ExpectPairs(pairs_, AllPairs(sorted.get(), ids, count), false, "sweep");
  }

  const Kernels& kernels_;
  std::mt19937_64 random_{1};
  std::vector<Box> boxes_;
  SoaBoxes soa_;
  PairBuffer pairs_;
  std::uint64_t digest_ = 0;
  bool failed_ = false;
};

int Main() {
  bool failed = false;
  std::uint64_t digest = 0;
  for (const Kernels* kernels : {&PlainKernels(), Avx2Kernels()}) {
    if (kernels == nullptr) continue;
    Check check(*kernels);
    check.Run();
    failed |= check.failed();
    if (kernels != &PlainKernels() && check.digest() != digest) {
      std::printf("%s: other results than plain\n", kernels->name);
      failed = true;
    }
    digest = check.digest();
  }
  if (!failed) std::printf("%016llx\n", static_cast<unsigned long long>(digest));
  return failed ? 1 : 0;
}

}  // namespace
}  // namespace cdb::tests

int main() { return cdb::tests::Main(); }
