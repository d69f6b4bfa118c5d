// `batch` beside the exact contacts of random pairs: nothing is missed, and depths and normals are
// exact.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "library/detectors/narrow/batch.h"
#include "tests/library/detectors/narrow/pair_cases.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

/// Of each two types; CDB_NARROW_PAIRS asks for more.
int PairCount() {
  const char* asked = std::getenv("CDB_NARROW_PAIRS");
  return asked != nullptr ? std::atoi(asked) : Cases(1000);
}

bool IsCurved(Type type) { return type >= Type::kCylinder && type <= Type::kFlatCapsule; }

struct Types {
  Type a, b;
};

class NarrowTruth : public testing::TestWithParam<Types> {};

TEST_P(NarrowTruth, HoldsForRandomPairs) {
  distributions::Stream stream(7);
  std::vector<PairCase> pairs;
  std::vector<ExactContact> exact;
  for (int i = 0; i < PairCount(); ++i) {
    pairs.push_back(RandomPair(stream, GetParam().a, GetParam().b));
    exact.push_back(ExactOf(pairs.back()));
  }
  const std::unique_ptr<Detector> batch(narrow::MakeBatch({}));
  const Faults faults = Judge(*batch, pairs, exact);
  // The referee cannot prove its distance for a few.
  EXPECT_GE(faults.pairs, 0.9 * PairCount()) << "of which all are handled";
  EXPECT_EQ(faults.missed, 0);
  const bool are_balls = GetParam().a == Type::kBall && GetParam().b == Type::kBall;
  EXPECT_EQ(faults.missed_near, are_balls ? faults.near : 0);
  EXPECT_EQ(faults.phantom, 0);
  EXPECT_EQ(faults.invalid, 0);
  // In sizes of the smaller of two bodies, of which one may be a hundred times larger.
  if (IsCurved(GetParam().a) || IsCurved(GetParam().b)) {
    // Of two ways out that are about as long, the other one may be found.
    EXPECT_LE(faults.worst_relative, 0.01);
    EXPECT_LE(faults.inexact, 0.005 * PairCount());
    EXPECT_LE(faults.worst_surface, 0.01);
  } else {
    EXPECT_LE(faults.worst_depth, 1e-6);
    EXPECT_LE(faults.worst_excess, 1e-6);
    EXPECT_LE(faults.worst_normal, 1e-4);
    // The ends of capsules that are nearly parallel touch a little inside.
    const bool are_capsules = GetParam().a == Type::kCapsule && GetParam().b == Type::kCapsule;
    EXPECT_LE(faults.worst_surface, are_capsules ? 1e-3 : 1e-6);
  }
  if (testing::Test::HasFailure()) {
    const auto& worst =
        faults.worst_pair >= 0 ? pairs[static_cast<std::size_t>(faults.worst_pair)] : pairs[0];
    fmt::print(
        "{} {}: {} compared, overlaps {}, near {}; worst pair {}: sides {} {} {}, {} {} {}\n",
        NameOf(GetParam().a), NameOf(GetParam().b), faults.pairs, faults.overlaps, faults.near,
        faults.worst_pair, worst.a.sides.x(), worst.a.sides.y(), worst.a.sides.z(),
        worst.b.sides.x(), worst.b.sides.y(), worst.b.sides.z());
  }
}

std::vector<Types> AllTypes() {
  std::vector<Types> all;
  for (int i = 0; i < static_cast<int>(Type::kPlane); ++i)
    for (int j = 0; j <= static_cast<int>(Type::kPlane); ++j)
      if (const auto a = static_cast<Type>(i), b = static_cast<Type>(j);
          a != Type::kCompound || b != Type::kCompound)
        all.push_back({a, b});
  return all;
}

struct TypesName {
  template <typename Info>
  std::string operator()(const Info& types) const {
    return fmt::format("{}_{}", NameOf(types.param.a), NameOf(types.param.b));
  }
};

INSTANTIATE_TEST_SUITE_P(, NarrowTruth, testing::ValuesIn(AllTypes()), TypesName());

}  // namespace
}  // namespace cdb::tests
