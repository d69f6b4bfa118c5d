// Passages compared with signed distances at many poses.
#include "library/exact/passage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "library/distributions/stream.h"
#include "library/exact/signed_distance.h"
#include "library/objects/distance.h"
#include "library/objects/solid_factory.h"
#include "tests/support/scene.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using exact::Motion;
using objects::Shape;
using objects::Solid;

struct Meeting {
  Solid a, b;
  Motion motion_a, motion_b;
  int cycles = 1;
};

bool Passes(const Meeting& meeting) {
  exact::Passage passage;
  bool passed = false;
  Motion a = meeting.motion_a, b = meeting.motion_b;
  for (Motion* motion : {&a, &b}) {
    motion->way /= meeting.cycles;
    motion->turn /= meeting.cycles;
  }
  for (int i = 0; i < meeting.cycles; ++i) {
    const exact::Passing passing = passage.Follow(meeting.a, a, meeting.b, b);
    EXPECT_NE(passing, exact::Passing::kUnknown);
    passed = passed || passing == exact::Passing::kPassed;
    a.from = a.At(1);
    b.from = b.At(1);
  }
  return passed;
}

Meeting Exchanged(const Meeting& meeting) {
  return {meeting.b, meeting.a, meeting.motion_b, meeting.motion_a, meeting.cycles};
}

Meeting Scaled(Meeting meeting, double factor) {
  meeting.a.sides *= factor;
  meeting.b.sides *= factor;
  for (Motion* motion : {&meeting.motion_a, &meeting.motion_b}) {
    motion->from.position *= factor;
    motion->way *= factor;
  }
  return meeting;
}

/// By the definition, from poses so dense that the depth changes little between them.
struct Dense {
  double deepest = 0;     ///< in least sides
  double cosine = 1;      ///< least, of overlaps that ended
  bool is_inside = true;  ///< apart at both ends
  explicit Dense(const Meeting& meeting) {
    const double side = 2 * std::min(meeting.a.LeastHalfExtent(), meeting.b.LeastHalfExtent());
    constexpr int kPoses = 300;
    bool overlaps = false;
    Vector3d last_a, last_b, in_a, in_b;
    for (int i = 0; i <= kPoses; ++i) {
      const double part = static_cast<double>(i) / kPoses;
      const objects::Pose pose_a = meeting.motion_a.At(part), pose_b = meeting.motion_b.At(part);
      const auto distance = exact::DistanceOf(meeting.a, pose_a, meeting.b, pose_b);
      const double depth = distance.Depth() / side;
      const Vector3d now_a = pose_a.orientation.conjugate() * distance.normal,
                     now_b = pose_b.orientation.conjugate() * distance.normal;
      deepest = std::max(deepest, depth);
      if (depth > 0 && !overlaps) {
        in_a = i > 0 ? last_a : now_a;
        in_b = i > 0 ? last_b : now_b;
      } else if (depth <= 0 && overlaps) {
        cosine = std::min(cosine, (in_a.dot(now_a) + in_b.dot(now_b)) / 2);
      }
      last_a = now_a;
      last_b = now_b;
      overlaps = depth > 0;
      if (overlaps && (i == 0 || i == kPoses)) is_inside = false;
    }
  }
};

Vector3d AnyVector(distributions::Stream& stream, double most) {
  return {stream.Uniform(-most, most), stream.Uniform(-most, most), stream.Uniform(-most, most)};
}

Meeting AnyMeeting(distributions::Stream& stream) {
  const auto solid = [&] {
    constexpr Shape kShapes[] = {Shape::kEllipsoid, Shape::kCuboid, Shape::kTetrahedron};
    Solid made{kShapes[static_cast<int>(stream.Uniform(0, 3))],
               Vector3d::Constant(stream.Uniform(0.4, 1))};
    if (made.shape != Shape::kEllipsoid) made.sides.y() *= stream.Uniform(1, 3);
    return made;
  };
  Meeting meeting{solid(), solid(), {}, {}, 1};
  const Vector3d at = AnyVector(stream, 1), way = AnyVector(stream, 3);
  meeting.motion_a.from.position = at - way / 2;
  meeting.motion_a.way = way;
  for (Motion* motion : {&meeting.motion_a, &meeting.motion_b}) {
    motion->turn = AnyVector(stream, 0.5);
    motion->from.orientation = Eigen::Quaterniond(
        Eigen::AngleAxisd(stream.Uniform(0, 6), AnyVector(stream, 1).normalized()));
  }
  return meeting;
}

TEST(Passage, AgreesWithItsDefinitionAtManyPoses) {
  distributions::Stream stream(1);
  int passes = 0, others = 0;
  for (int i = 0; i < 500; ++i) {
    Meeting meeting = AnyMeeting(stream);
    const Dense dense(meeting);
    meeting.cycles = 1 + i % 4;
    const bool is_whole = dense.is_inside && dense.deepest > 1.2 && meeting.cycles == 1;
    SCOPED_TRACE(testing::Message() << i << ": deepest " << dense.deepest << ", cosine "
                                    << dense.cosine << ", cycles " << meeting.cycles);
    // Close cases depend on the accuracy.
    const bool is_pass = dense.deepest > 0.32 && (dense.cosine < -0.3 || is_whole);
    const bool is_none = (dense.deepest < 0.2 || dense.cosine > 0.1) &&
                         (dense.deepest < 0.9 || meeting.cycles > 1 || !dense.is_inside);
    if (is_pass == is_none) continue;
    // Of slow ones, the contacts are asked.
    const double side = 2 * std::min(meeting.a.LeastHalfExtent(), meeting.b.LeastHalfExtent());
    if (is_pass && meeting.motion_a.way.norm() / meeting.cycles < 1.1 * side) continue;
    ++(is_pass ? passes : others);
    EXPECT_EQ(Passes(meeting), is_pass);
    EXPECT_EQ(Passes(Exchanged(meeting)), is_pass);
    EXPECT_EQ(Passes(Scaled(meeting, 1024)), is_pass);
    EXPECT_EQ(Passes(Scaled(meeting, 1.0 / 1024)), is_pass);
  }
  EXPECT_GT(passes, 50);
  EXPECT_GT(others, 50);
}

TEST(Passage, IsNoneIfTheyGoBack) {
  Meeting meeting{{Shape::kCuboid, {0.1, 4, 4}}, {Shape::kCuboid, {0.1, 4, 4}}, {}, {}, 1};
  meeting.motion_a = {{{-1, 3, 0}, Eigen::Quaterniond::Identity()}, {0.98, 0, 0}, {0, 0, 0}};
  exact::Passage passage;
  const auto follow = [&] {
    return passage.Follow(meeting.a, meeting.motion_a, meeting.b, meeting.motion_b);
  };
  EXPECT_EQ(follow(), exact::Passing::kNone);
  EXPECT_TRUE(passage.Overlaps());
  meeting.motion_a.from = meeting.motion_a.At(1);
  meeting.motion_a.way *= -1;
  EXPECT_EQ(follow(), exact::Passing::kNone);
  EXPECT_FALSE(passage.Overlaps());
  meeting.motion_a.from = meeting.motion_a.At(1);
  meeting.motion_a.way = {2, 0, 0};
  EXPECT_EQ(follow(), exact::Passing::kPassed);
}

// Three balls of an exploded chain, as they stood and as they would overlap.
TEST(Passage, IsUnknownBeyondRounding) {
  const Solid ball;
  for (const double far : {1e13, 1e150, 1e205}) {
    Motion a, b;
    a.from.position.y() = -8.3836289117976735 * far;
    a.way.y() = 64.132202357693378 * far;
    b.from.position.y() = 10.454214257396989 * far;
    b.way.y() = -79.971548276229771 * far;
    exact::Passage passage;
    EXPECT_EQ(passage.Follow(ball, a, ball, b), exact::Passing::kUnknown) << far;
    EXPECT_FALSE(passage.Overlaps());
  }
}

/// In least sides, of two tori on a straight way; infinite if they overlap at one of its ends.
double DeepestOfTori(const Solid& torus, const Motion& a, const Motion& b) {
  double deepest = 0;
  constexpr int kPoses = 60;
  for (int i = 0; i <= kPoses; ++i) {
    const double part = static_cast<double>(i) / kPoses;
    const auto distance = exact::DistanceOf(torus, a.At(part), torus, b.At(part), 0);
    if (!(distance.upper < 0)) continue;
    if (i == 0 || i == kPoses) return INFINITY;
    deepest = std::max(deepest, distance.Depth() / (2 * torus.LeastHalfExtent()));
  }
  return deepest;
}

// The differences of their pieces have many corners in one plane, where a polytope may fold, and
// their normals where they part do not depend on those where they meet.
TEST(Passage, OfToriIsSeen) {
  distributions::Stream stream(3);
  objects::SolidFactory maker;
  const Solid torus = maker.Make(Word("torus"), Vector3d::Ones(), Vector3d::Ones());
  int passes = 0, others = 0;
  for (int i = 0; i < 60; ++i) {
    Meeting meeting{torus, torus, {}, {}, 1 + i % 2};
    Motion &a = meeting.motion_a, &b = meeting.motion_b;
    a.way = 3.3 * AnyVector(stream, 1).normalized();
    a.from = {AnyVector(stream, 0.5) - a.way / 2, stream.Turn()};
    // Every second time with parallel axes.
    b.from.orientation = i % 4 < 2 ? a.from.orientation : stream.Turn();
    const double deepest = DeepestOfTori(torus, a, b);
    if (std::isinf(deepest)) continue;
    const bool passed = Passes(meeting);
    passes += deepest > 0.4;
    others += deepest < 0.2;
    if (deepest > 0.4) {
      EXPECT_TRUE(passed) << i << ", deepest " << deepest;
    }
    if (deepest < 0.2) {
      EXPECT_FALSE(passed) << i << ", deepest " << deepest;
    }
    // There and back again.
    exact::Passage passage;
    a.way *= 0.5;
    if (passage.Follow(torus, a, torus, b) == exact::Passing::kPassed) continue;  // half of it
    a.from = a.At(1);
    a.way *= -1;
    EXPECT_EQ(passage.Follow(torus, a, torus, b), exact::Passing::kNone) << i;
  }
  EXPECT_GT(passes, 20);
  EXPECT_GT(others, 3);
}

TEST(Passage, FollowsSeveralTurns) {
  // The blade sweeps over the ball, and is back where it was at the end.
  Meeting meeting{
      {Shape::kCuboid, {10, 0.5, 0.1}}, {Shape::kEllipsoid, {0.2, 0.2, 0.2}}, {}, {}, 1};
  meeting.motion_b.from.position = {0, 0, 4};
  for (const double turns : {0.125, 1.0, 2.0}) {
    meeting.motion_a.turn = {0, 2 * std::numbers::pi * turns, 0};
    EXPECT_EQ(Passes(meeting), turns >= 1) << turns;
  }
  meeting.motion_b.from.position = {0, 0, 5.2};
  EXPECT_FALSE(Passes(meeting)) << "beyond its end";
}

}  // namespace
}  // namespace cdb::tests
