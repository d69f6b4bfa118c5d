// `kd_tree`: a k-d tree of boxes, rebuilt every cycle. Space is split at the median of the lower
// corners of a sample, across the axis of greatest spread, until few boxes are left, which are
// tested with each other. A box on both sides of a split is in both subtrees.
//
// Source: Bentley, "Multidimensional binary search trees" (1975), cited by Woulfe & Manzke 2009.
// Cost: n log n if few boxes are split; in leaves that cannot be split further, all pairs are
// tested.
#include <algorithm>
#include <cmath>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"

namespace cdb::builtin {
namespace {

constexpr double Vec3::*kAxes[] = {&Vec3::x, &Vec3::y, &Vec3::z};
/// Cells with at most this number of bodies are leaves.
constexpr std::size_t kLeaf = 12;
constexpr int kDeepest = 64;
/// Bodies from which the cut is chosen, at most.
constexpr std::size_t kSample = 128;

class KdTree final : public Detector {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    scene_ = &scene;
    pairs_ = &pairs;
    bodies_.clear();
    for (Id id = 0; id < scene.size; ++id)
      if (Overlap(scene.boxes[id], scene.boxes[id])) bodies_.push_back({scene.boxes[id], id});
    constexpr Vec3 kLeast = {-INFINITY, -INFINITY, -INFINITY},
                   kMost = {INFINITY, INFINITY, INFINITY};
    Cut(0, {kLeast, kMost}, 0);
  }

 private:
  struct Body {
    Box box;  ///< a copy, so that the boxes of a cell are contiguous
    Id id;
  };

  /// Lists the pairs in `cell`. The bodies from `begin` to the end are those whose boxes reach into
  /// it.
  void Cut(std::size_t begin, const Box& cell, int depth) {
    const std::size_t end = bodies_.size();
    double Vec3::*axis = nullptr;
    double plane = 0;
    if (end - begin <= kLeaf || depth == kDeepest || !ChooseCut(begin, cell, axis, plane))
      return TestAll(begin, cell);
    const auto cut = [&](const Box& half, const auto& reaches) {
      for (std::size_t i = begin; i < end; ++i)
        if (reaches(bodies_[i].box)) bodies_.push_back(Body(bodies_[i]));
      Cut(end, half, depth + 1);
      bodies_.resize(end);
    };
    Box half = cell;
    half.upper.*axis = plane;
    cut(half, [&](const Box& box) { return box.lower.*axis < plane; });
    half = cell;
    half.lower.*axis = plane;
    cut(half, [&](const Box& box) { return box.upper.*axis >= plane; });
  }

  /// Cuts at the median along the axis of greatest spread. False if that would leave 90 % of the
  /// bodies or more on one side, or put half of them or more on both.
  bool ChooseCut(std::size_t begin, const Box& cell, double Vec3::*& best, double& plane) {
    const std::size_t all = bodies_.size() - begin, size = std::min(all, kSample);
    const auto corner_of = [&](std::size_t k, double Vec3::*axis) {
      const std::size_t i = begin + (size < all ? kernels::SampleIndex(k, all) : k);
      return std::max(bodies_[i].box.lower.*axis, cell.lower.*axis);
    };
    double widest = 0;
    for (const auto axis : kAxes) {
      double least = INFINITY, most = -INFINITY;
      for (std::size_t k = 0; k < size; ++k) {
        const double at = corner_of(k, axis);
        if (!std::isfinite(at)) continue;
        least = std::min(least, at);
        most = std::max(most, at);
      }
      if (!(most - least > widest)) continue;
      widest = most - least;
      best = axis;
    }
    if (best == nullptr) return false;
    corners_.clear();
    for (std::size_t k = 0; k < size; ++k) corners_.push_back(corner_of(k, best));
    const auto middle = corners_.begin() + static_cast<std::ptrdiff_t>(size / 2);
    std::ranges::nth_element(corners_, middle);
    plane = *middle;
    std::size_t left = 0, right = 0;
    for (std::size_t i = begin; i < bodies_.size(); ++i) {
      left += bodies_[i].box.lower.*best < plane;
      right += bodies_[i].box.upper.*best >= plane;
    }
    return left * 10 < all * 9 && right * 10 < all * 9 && 2 * (left + right) < 3 * all;
  }

  /// A pair belongs to the one leaf that contains the lower corner of the intersection of its
  /// boxes.
  void TestAll(std::size_t begin, const Box& cell) {
    for (std::size_t i = begin; i < bodies_.size(); ++i) {
      for (std::size_t j = i + 1; j < bodies_.size(); ++j) {
        const Body &a = bodies_[i], &b = bodies_[j];
        if (!Overlap(a.box, b.box) || !IsOf(cell, a.box, b.box)) continue;
        if (!scene_->MayCollide(a.id, b.id)) continue;
        pairs_->push_back({a.id, b.id});  // a.id < b.id, because cells keep the order of bodies
      }
    }
  }

  static bool IsOf(const Box& cell, const Box& a, const Box& b) {
    for (const auto axis : kAxes) {
      const double corner = std::max(a.lower.*axis, b.lower.*axis);
      if (corner < cell.lower.*axis) return false;
      if (corner >= cell.upper.*axis && cell.upper.*axis != INFINITY) return false;
    }
    return true;
  }

  const Scene* scene_ = nullptr;
  std::vector<Pair>* pairs_ = nullptr;
  std::vector<Body> bodies_;  ///< one list for each cell on the path from the root
  std::vector<double> corners_;
};

}  // namespace

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeKdTree(const Options&) { return new KdTree; }

}  // namespace cdb::builtin
