#include "tests/library/detectors/box_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cdb::tests {
namespace {

constexpr double Vec3::*kAxes[] = {&Vec3::x, &Vec3::y, &Vec3::z};
/// The value in a worker of single precision.
double Rounded(double x) { return static_cast<double>(static_cast<float>(x)); }

}  // namespace

BoxScene::BoxScene(std::string_view name, std::size_t objects, bool walls, std::uint64_t seed)
    : random_(seed) {
  const auto n = static_cast<double>(objects);
  const double size = 50;
  double speed = 0;
  for (std::size_t i = 0; i < objects; ++i) {
    double side[3] = {size, size, size};
    if (name == "mixed") {
      side[0] = side[1] = side[2] = Uniform(50, 500);
      if (i % 2 == 0) {
        side[0] = side[1] = side[2] = 10;
        side[i / 2 % 3] = 500;
      }
    }
    half_.push_back({side[0] / 2, side[1] / 2, side[2] / 2});
  }
  if (name == "sparse") {
    half_side_ = size * n / 2;
    speed = 50 / 60.0;
  } else if (name == "dense") {
    half_side_ = std::cbrt(n * size * size * size / 0.15) / 2;
    speed = size / 10;
  } else if (name == "cluster") {
    half_side_ = 3 * std::cbrt(n) * size;
    speed = size / 100;
  } else if (name == "swarms") {
    half_side_ = size * n / 2;
    speed = size / 100;
  } else if (name == "mixed") {
    half_side_ = std::cbrt(n / 0.05) * 100;
    speed = 5;
  } else {
    jitters_ = name == "pile";
    half_side_ = std::cbrt(n) * size;
    jitter_ = size / 1000;
  }
  std::vector<Vec3> middles;
  if (name == "swarms")
    for (int swarm = 0; swarm < 8; ++swarm) {
      Vec3& middle = middles.emplace_back();
      for (const auto axis : kAxes) middle.*axis = Uniform(-half_side_ / 2, half_side_ / 2);
    }
  const auto row = static_cast<std::size_t>(std::ceil(std::cbrt(n)));
  for (std::size_t i = 0; i < objects; ++i) {
    Vec3 at = {}, step = {};
    for (int axis = 0; axis < 3; ++axis) {
      double& x = at.*kAxes[axis];
      if (name == "cluster") {
        x = std::normal_distribution<double>(0, half_side_ / 3)(random_);
      } else if (!middles.empty() && i % 4 != 0) {
        x = std::normal_distribution<double>(middles[i % 8].*kAxes[axis],
                                             std::cbrt(n / 8) * size)(random_);
      } else if (name == "pile" || name == "asleep" || name == "shots") {
        const std::size_t place = axis == 0 ? i % row : axis == 1 ? i / row % row : i / row / row;
        x = static_cast<double>(place) * size * 0.999 + Uniform(-0.02, 0.02) * size;
      } else {
        x = Uniform(-half_side_, half_side_);
      }
      const bool is_shot = name == "shots" && i % 50 == 0;
      step.*kAxes[axis] = is_shot ? Uniform(-size / 2, size / 2) : Uniform(-speed, speed);
    }
    at_.push_back(at);
    step_.push_back(step);
  }
  boxes_.resize(objects);
  filters_.resize(objects);
  is_asleep_.assign(objects, name == "asleep");
  if (walls) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    for (int wall = 0; wall < 6; ++wall) {
      boxes_.push_back({{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, kInfinite}});
      filters_.push_back({.group = 2, .mask = 1, .is_fixed = true});
      is_asleep_.push_back(1);
    }
  }
  Move();
}

void BoxScene::Move() {
  for (std::size_t i = 0; i < at_.size(); ++i) {
    for (const auto axis : kAxes) {
      double& x = at_[i].*axis;
      double& step = step_[i].*axis;
      x += step;
      if (std::fabs(x) > half_side_ && x * step > 0) step = -step;
      const double at = jitters_ ? x + Uniform(-jitter_, jitter_) : x;
      boxes_[i].lower.*axis = Rounded(at - half_[i].*axis);
      boxes_[i].upper.*axis = Rounded(at + half_[i].*axis);
    }
  }
}

void BoxScene::CutWalls() {
  for (std::size_t wall = 0; wall < 6; ++wall) {
    Box& box = boxes_[at_.size() + wall];
    const auto axis = kAxes[wall / 2];
    const double end = Rounded(0.9 * half_side_);
    if (wall % 2 == 0) box.upper.*axis = -end;
    if (wall % 2 == 1) box.lower.*axis = end;
  }
}

Scene BoxScene::View() const {
  return {.size = boxes_.size(),
          .boxes = boxes_,
          .filters = filters_,
          .poses = {},
          .shapes = {},
          .is_asleep = is_asleep_};
}

std::vector<Pair> Listed(Detector& detector, const Scene& scene) {
  std::vector<Pair> pairs;
  detector.FindPairs(scene, pairs);
  return pairs;
}

std::vector<Pair> SortedPairs(Detector& detector, const Scene& scene) {
  std::vector<Pair> pairs = Listed(detector, scene);
  std::ranges::sort(pairs);
  return pairs;
}

void KeptPairs::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  constexpr int kListed = 11;  // every 11th call uses FindPairs
  std::vector<Pair> came, went;
  bool are_changes = false;
  if (++calls_ % kListed == 0)
    detector_->FindPairs(scene, came);
  else
    are_changes = detector_->FindChanges(scene, came, went);
  const auto overlap = [&](const Pair& pair) {
    return Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
  };
  if (!are_changes) {
    EXPECT_TRUE(went.empty());
    kept_.clear();
  }
  for (const Pair& pair : went) {
    EXPECT_FALSE(overlap(pair));
    kept_.erase(pair);
  }
  for (const Pair& pair : came) EXPECT_TRUE(overlap(pair));
  kept_.insert(came.begin(), came.end());
  pairs.assign(kept_.begin(), kept_.end());
}

std::vector<Pair> BruteForce(const Scene& scene) {
  std::vector<Pair> pairs;
  for (Id a = 0; a < scene.size; ++a)
    for (Id b = a + 1; b < scene.size; ++b)
      if (scene.MayCollide(a, b) && Overlap(scene.boxes[a], scene.boxes[b]))
        pairs.push_back({a, b});
  return pairs;
}

}  // namespace cdb::tests
