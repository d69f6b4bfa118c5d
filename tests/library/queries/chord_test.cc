// Closed forms of lines in solids, compared with functions of the solids that do not know lines:
// which points are inside, and how far the solid reaches along a direction.
#include "library/queries/chord.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "library/distributions/stream.h"
#include "library/objects/shapes/triangles.h"
#include "library/queries/line_shape.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Shape;
using objects::Solid;
using queries::Chord;

/// Chords of all pieces, by the order of the shape.
std::vector<Chord<double>> ChordsOf(const Solid& solid, const Vector3d& from,
                                    const Vector3d& along) {
  std::vector<Chord<double>> chords;
  queries::LineShape<double>(solid).ForEveryChord(
      from, along, [&](const Chord<double>& chord, double) { chords.push_back(chord); });
  return chords;
}

/// A line that passes near the solid, from outside or from inside of it.
std::pair<Vector3d, Vector3d> RandomLine(distributions::Stream& stream, const Solid& solid) {
  const double radius = solid.OuterRadius();
  const Vector3d target =
      radius * 0.6 * Vector3d(stream.Normal(), stream.Normal(), stream.Normal());
  const Vector3d along = RandomDirection(stream);
  return {target - stream.Uniform(-1, 4) * radius * along, along};
}

bool Contains(const Solid& solid, const Vector3d& point) {
  for (std::size_t piece = 0; piece < solid.PieceCount(); ++piece)
    if (solid.PieceContains(piece, point)) return true;
  return false;
}

/// The points of the line that are inside are those of its chords, but for their ends.
void ExpectInsideIsChord(const Solid& solid, const Vector3d& from, const Vector3d& along) {
  const auto chords = ChordsOf(solid, from, along);
  const double radius = solid.OuterRadius(), blur = 1e-9 * (radius + from.norm());
  const double middle = -from.dot(along);
  for (int i = 0; i <= 400; ++i) {
    const double t = middle + radius * (i - 200) / 190;
    bool is_near = false, is_inside = false;
    for (const auto& chord : chords) {
      is_near = is_near || std::fabs(t - chord.enter) < blur || std::fabs(t - chord.leave) < blur;
      is_inside = is_inside || (t > chord.enter && t < chord.leave);
    }
    if (is_near) continue;
    ASSERT_EQ(Contains(solid, from + t * along), is_inside) << t;
  }
}

/// The plane through the point of entry, across the normal, has the piece behind it.
void ExpectNormalSupports(const Solid& solid, const Vector3d& from, const Vector3d& along) {
  for (const auto& chord : ChordsOf(solid, from, along)) {
    const Vector3d point = from + chord.enter * along, normal = chord.normal.normalized();
    ASSERT_TRUE(normal.allFinite());
    EXPECT_LT(normal.dot(along), 1e-9) << "the line enters there";
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t piece = 0; piece < solid.PieceCount(); ++piece)
      nearest = std::min(nearest, std::fabs(normal.dot(solid.PieceSupport(piece, normal) - point)));
    EXPECT_LT(nearest, 1e-8 * (solid.OuterRadius() + from.norm()));
  }
}

class ChordOf : public testing::TestWithParam<Shape> {};

TEST_P(ChordOf, IsTheInsideOfTheSolid) {
  distributions::Stream stream(1 + static_cast<std::uint64_t>(GetParam()));
  int hits = 0;
  for (int i = 0; i < 300; ++i) {
    const Solid solid = RandomSolid(stream, GetParam(), 5);
    const auto [from, along] = RandomLine(stream, solid);
    ExpectInsideIsChord(solid, from, along);
    ExpectNormalSupports(solid, from, along);
    hits += !ChordsOf(solid, from, along).empty();
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(hits, 60);
  EXPECT_LT(hits, 290);
}

TEST_P(ChordOf, IsTheInsideAlongAxesToo) {
  distributions::Stream stream(99);
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0})
      for (int i = 0; i < 30; ++i) {
        const Solid solid = RandomSolid(stream, GetParam(), 5);
        Vector3d from = solid.HalfExtents().cwiseProduct(Vector3d(
            stream.Uniform(-1.2, 1.2), stream.Uniform(-1.2, 1.2), stream.Uniform(-1.2, 1.2)));
        from[axis] = -sign * 10;
        ExpectInsideIsChord(solid, from, sign * Vector3d::Unit(axis));
        if (HasFatalFailure()) return;
      }
}

TEST_P(ChordOf, KeepsItsDigitsFarAway) {
  distributions::Stream stream(7);
  for (int i = 0; i < 200; ++i) {
    const Solid solid = RandomSolid(stream, GetParam(), 3);
    const auto [from, along] = RandomLine(stream, solid);
    const double away = 1e4;
    const auto near = ChordsOf(solid, from, along),
               far = ChordsOf(solid, from - away * along, along);
    if (near.empty() || near[0].leave - near[0].enter < 0.1) continue;
    ASSERT_EQ(near.size(), far.size());
    for (std::size_t j = 0; j < near.size(); ++j)
      EXPECT_NEAR(far[j].enter - away, near[j].enter, 1e-10 * away);
  }
}

TEST_P(ChordOf, IsAboutTheSameInSinglePrecision) {
  distributions::Stream stream(11);
  for (int i = 0; i < 300; ++i) {
    const Solid solid = RandomSolid(stream, GetParam(), 3);
    const auto [from, along] = RandomLine(stream, solid);
    const auto exact = ChordsOf(solid, from, along);
    if (exact.empty() || exact[0].leave - exact[0].enter < 0.1) continue;
    int found = 0;
    queries::LineShape<float>(solid).ForEveryChord(from.cast<float>(), along.cast<float>(),
                                                   [&](const Chord<float>& chord, float) {
                                                     ++found;
                                                     EXPECT_NEAR(chord.enter, exact[0].enter, 5e-4);
                                                     EXPECT_NEAR(chord.leave, exact[0].leave, 5e-4);
                                                   });
    EXPECT_EQ(found, 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, ChordOf, testing::ValuesIn(objects::kClosedShapes),
                         [](const auto& shape) { return std::string(TypeOf(shape.param)); });

TEST(Chord, OfAnUnitBallIsKnown) {
  const Vector3d half = Vector3d::Constant(1);
  const auto chord = queries::EllipsoidChord(half, Vector3d(-5, 0, 0.6), Vector3d(1, 0, 0));
  EXPECT_NEAR(chord.enter, 4.2, 1e-15);
  EXPECT_NEAR(chord.leave, 5.8, 1e-15);
  EXPECT_TRUE(queries::EllipsoidChord(half, Vector3d(-5, 0, 1.1), Vector3d(1, 0, 0)).IsNone());
}

TEST(Chord, OfACuboidIsKnown) {
  const Vector3d half(1, 2, 3);
  const auto chord = queries::CuboidChord(half, Vector3d(0, -7, 1), Vector3d(0, 1, 0));
  EXPECT_EQ(chord.enter, 5);
  EXPECT_EQ(chord.leave, 9);
  EXPECT_EQ(chord.normal, Vector3d(0, -1, 0));
}

TEST(Chord, OfAConeEndsAtItsTip) {
  const Vector3d half(1, 2, 1);  // its tip is at y = 3, its base at y = -1
  const auto down = queries::ConeChord(half, Vector3d(0, 10, 0), Vector3d(0, -1, 0));
  EXPECT_NEAR(down.enter, 7, 1e-12);
  EXPECT_NEAR(down.leave, 11, 1e-12);
  EXPECT_TRUE(queries::ConeChord(half, Vector3d(-5, 3.5, 0), Vector3d(1, 0, 0)).IsNone())
      << "the mirror image of the cone above its tip";
}

TEST(Chord, OfATriangleIsSeenFromBothSides) {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  for (const double sign : {-1.0, 1.0}) {
    const auto chord =
        queries::TriangleChord(a, b, c, Vector3d(0.25, 0.25, -2 * sign), Vector3d(0, 0, sign));
    EXPECT_EQ(chord.enter, 2);
    EXPECT_GT(-sign * chord.normal.z(), 0);
    EXPECT_TRUE(
        queries::TriangleChord(a, b, c, Vector3d(0.75, 0.75, -2 * sign), Vector3d(0, 0, sign))
            .IsNone());
  }
}

TEST(Chord, OfACompoundIsThatOfItsPieces) {
  distributions::Stream stream(5);
  const Solid torus = Torus();
  for (int i = 0; i < 300; ++i) {
    const auto [from, along] = RandomLine(stream, torus);
    ExpectInsideIsChord(torus, from, along);
    ExpectNormalSupports(torus, from, along);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace cdb::tests
