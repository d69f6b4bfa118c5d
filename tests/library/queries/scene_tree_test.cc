// Answers of the tree compared with brute force, for scenes that move.
#include "library/queries/scene_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <set>

#include "library/distributions/stream.h"
#include "library/objects/surface.h"
#include "library/queries/exact_queries.h"
#include "tests/library/objects/random_solids.h"

namespace cdb::tests {
namespace {

using Eigen::Vector3d;
using objects::Pose;
using queries::ExactHit;
using queries::ExactQueries;
using queries::Hits;
using queries::SceneTree;

/// The triangles of a torus, as a surface without an inside.
objects::Solid TorusSurface() {
  static const objects::Solid surface = [] {
    const meshes::Mesh mesh = meshes::TorusMesh(1.5, 0.5, 32, meshes::kTorusCorners);
    const auto form =
        std::make_shared<const objects::ConvexDecomposition>(objects::MakeSurface("ring", mesh));
    objects::Solid solid{objects::Shape::kCompound, {4, 1, 4}};
    solid.compound = std::make_shared<const objects::Compound>(form, solid.sides);
    return solid;
  }();
  return surface;
}

/// Random bodies of every shape in a cube, in a tree and by brute force.
template <typename Real>
class Answerers {
 public:
  Answerers(int count, double side, std::uint64_t seed) : stream_(seed), side_(side) {
    for (int i = 0; i < count; ++i) {
      const objects::Shape shape =
          objects::kClosedShapes[static_cast<std::size_t>(i) % objects::kClosedShapes.size()];
      const objects::Solid solid = i % 20 == 19   ? Torus()
                                   : i % 20 == 18 ? TorusSurface()
                                                  : RandomSolid(stream_, shape, 3);
      tree_.Add(solid, i);
      exact_.Add({solid, {}, i});
      poses_.emplace_back();
    }
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d normal = -Vector3d::Unit(axis);
      tree_.AddHalfSpace(normal.cast<Real>(), static_cast<Real>(-side / 2), count + axis);
      exact_.AddHalfSpace(normal, -side / 2, count + axis);
    }
    for (Pose& pose : poses_) pose.position = Place();
    Move(0);
  }

  /// Moves each body by up to `way`, and turns it.
  void Move(double way) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      Pose& pose = poses_[i];
      pose.position += way * RandomDirection(stream_);
      pose.orientation = stream_.Turn();
      const Eigen::Matrix<Real, 3, 3> axes =
          pose.orientation.toRotationMatrix().template cast<Real>();
      tree_.Move(i, pose.position.template cast<Real>(), axes);
      // The same numbers for both.
      exact_.Move(i, {pose.position.template cast<Real>().template cast<double>(),
                      Eigen::Quaterniond(axes.template cast<double>()).normalized()});
    }
    tree_.Update();
  }

  queries::Ray<double> RandomRay() {
    const Vector3d along = RandomDirection(stream_).template cast<Real>().template cast<double>();
    return {Place().template cast<Real>().template cast<double>(), along,
            static_cast<double>(static_cast<Real>(stream_.Uniform(0.1, 1) * side_))};
  }

  std::vector<queries::Hit<Real>> Cast(const queries::Ray<double>& ray, Hits hits) const {
    std::vector<queries::Hit<Real>> found;
    tree_.Cast({ray.from.cast<Real>(), ray.along.cast<Real>(), static_cast<Real>(ray.length)}, hits,
               found);
    return found;
  }
  std::vector<ExactHit> Truth(const queries::Ray<double>& ray) const { return exact_.Find(ray, 0); }
  const SceneTree<Real>& tree() const { return tree_; }
  const ExactQueries& exact() const { return exact_; }

 private:
  Vector3d Place() {
    const double half = side_ / 2;
    const double x = stream_.Uniform(-half, half), y = stream_.Uniform(-half, half);
    return {x, y, stream_.Uniform(-half, half)};
  }

  distributions::Stream stream_;
  const double side_;
  SceneTree<Real> tree_;
  ExactQueries exact_;
  std::vector<Pose> poses_;
};

/// In double precision, the tree finds what brute force does, whatever it stands on.
TEST(SceneTree, FindsWhatBruteForceFinds) {
  for (const int count : {0, 1, 2, 5, 40, 400}) {
    Answerers<double> both(count, 40, 3 + static_cast<std::uint64_t>(count));
    int hits = 0;
    for (int cycle = 0; cycle < 4; ++cycle) {
      for (int i = 0; i < 300; ++i) {
        const auto ray = both.RandomRay();
        const auto truth = both.Truth(ray);
        const auto closest = both.Cast(ray, Hits::kClosest), any = both.Cast(ray, Hits::kAny),
                   all = both.Cast(ray, Hits::kAll);
        ASSERT_EQ(closest.size(), truth.empty() ? 0u : 1u);
        ASSERT_EQ(any.size(), closest.size());
        std::set<std::int32_t> bodies, expected;
        for (const auto& hit : all) EXPECT_TRUE(bodies.insert(hit.body).second) << "twice";
        for (const ExactHit& hit : truth) expected.insert(hit.body);
        ASSERT_EQ(bodies, expected);
        if (truth.empty()) continue;
        ++hits;
        EXPECT_EQ(closest[0].body, truth[0].body);
        EXPECT_NEAR(closest[0].distance, truth[0].distance, 1e-9);
        EXPECT_NEAR((closest[0].normal - truth[0].normal).norm(), 0, 1e-6);
        EXPECT_TRUE(expected.contains(any[0].body));
      }
      // First a little, so that the tree is refitted; then so far that it is built anew.
      both.Move(cycle == 0 ? 0.1 : 20);
    }
    EXPECT_GT(hits, 20) << count;
  }
}

template <typename Hit>
std::set<std::int32_t> BodiesOf(const std::vector<Hit>& hits) {
  std::set<std::int32_t> bodies;
  for (const Hit& hit : hits) bodies.insert(hit.body);
  return bodies;
}

TEST(SceneTree, FindsWhatBruteForceFindsForShapes) {
  for (const int count : {0, 3, 150}) {
    Answerers<double> both(count, 30, 21);
    int swept = 0, overlapping = 0;
    for (int cycle = 0; cycle < 3; ++cycle) {
      for (int i = 0; i < 100; ++i) {
        const auto ray = both.RandomRay();
        const objects::Solid shape{objects::kClosedShapes[static_cast<std::size_t>(i) % 6],
                                   Vector3d(1, 1.5, 0.7)};
        const queries::Placed at = {shape, ray.from};
        std::vector<queries::Hit<double>> found;

        both.tree().Sweep(at, ray.along, ray.length, Hits::kClosest, found);
        const auto sweeps = both.exact().FindSwept(at, ray.along, ray.length);
        ASSERT_EQ(found.size(), sweeps.empty() ? 0u : 1u);
        if (!sweeps.empty()) {
          EXPECT_NEAR(found[0].distance, sweeps[0].distance, 1e-9);
        }
        swept += !sweeps.empty();
        found.clear();
        both.tree().Sweep(at, ray.along, ray.length, Hits::kAll, found);
        ASSERT_EQ(BodiesOf(found), BodiesOf(sweeps));

        found.clear();
        both.tree().Overlap(at, Hits::kAll, found);
        const auto overlaps = both.exact().FindOverlaps(at);
        ASSERT_EQ(BodiesOf(found), BodiesOf(overlaps));
        overlapping += !overlaps.empty();

        found.clear();
        both.tree().Nearest(at, ray.length, found);
        const auto near = both.exact().FindNear(at, ray.length);
        ASSERT_EQ(found.size(), near.empty() ? 0u : 1u);
        if (!near.empty()) {
          EXPECT_NEAR(found[0].distance, near[0].distance, 1e-10);
        }
      }
      both.Move(cycle == 0 ? 0.1 : 10);
    }
    EXPECT_GT(swept, 20);
    if (count > 100) {
      EXPECT_GT(overlapping, 20);
    }
  }
}

TEST(SceneTree, FindsAlmostTheSameInSinglePrecision) {
  Answerers<float> both(300, 40, 17);
  int compared = 0, differing = 0;
  for (int cycle = 0; cycle < 3; ++cycle) {
    for (int i = 0; i < 1000; ++i) {
      const auto ray = both.RandomRay();
      const auto truth = both.Truth(ray);
      const auto closest = both.Cast(ray, Hits::kClosest);
      // Rays that hardly touch a body, or that end at one, may go either way.
      const bool is_plain = !truth.empty() && truth[0].inside > 1e-2 && truth[0].margin > 1e-3 &&
                            truth[0].distance > 1e-3 && truth[0].distance < ray.length - 1e-3;
      if (!is_plain) continue;
      ++compared;
      ASSERT_EQ(closest.size(), 1u);
      differing += closest[0].body != truth[0].body;
      if (closest[0].body != truth[0].body) continue;
      EXPECT_NEAR(static_cast<double>(closest[0].distance), truth[0].distance, 2e-3);
    }
    both.Move(1);
  }
  EXPECT_GT(compared, 500);
  EXPECT_LT(differing, compared / 100) << "a body that is grazed before the first";
}

TEST(SceneTree, AnswersTheSameToTheBit) {
  Answerers<float> one(200, 30, 5), other(200, 30, 5);
  for (int cycle = 0; cycle < 3; ++cycle) {
    for (int i = 0; i < 200; ++i) {
      const auto ray = one.RandomRay();
      other.RandomRay();
      const auto a = one.Cast(ray, Hits::kAll), b = other.Cast(ray, Hits::kAll);
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t j = 0; j < a.size(); ++j) {
        EXPECT_EQ(a[j].body, b[j].body);
        EXPECT_EQ(a[j].distance, b[j].distance);
      }
    }
    one.Move(0.5);
    other.Move(0.5);
  }
}

TEST(SceneTree, DoesNotHitASolidThatARayStartsIn) {
  SceneTree<double> tree;
  const objects::Solid ball{objects::Shape::kEllipsoid, Vector3d::Constant(2)};
  tree.Move(tree.Add(ball, 0), Vector3d::Zero(), Eigen::Matrix3d::Identity());
  tree.Move(tree.Add(ball, 1), Vector3d(5, 0, 0), Eigen::Matrix3d::Identity());
  tree.Update();
  std::vector<queries::Hit<double>> found;
  tree.Cast({Vector3d::Zero(), Vector3d::UnitX(), 10}, Hits::kAll, found);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].body, 1);
  EXPECT_NEAR(found[0].distance, 4, 1e-12);
}

}  // namespace
}  // namespace cdb::tests
