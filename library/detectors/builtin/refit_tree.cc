// `refit_tree`: a binary tree of boxes that keeps its bodies. Each cycle, the boxes of its nodes
// are refitted from the leaves up, and the tree is compared with itself. It is built again, by
// medians along the longest axis, when the surface of all nodes has grown to twice that at the last
// build: bodies that were close have gone apart.
//
// Sources: van den Bergen, "Efficient collision detection of complex deformable models using AABB
// trees", Journal of Graphics Tools 2(4), 1997; Larsson, Akenine-Möller, "Collision detection for
// continuously deforming bodies", Eurographics 2001, and "A dynamic bounding volume hierarchy for
// generalized collision detection", Computers & Graphics 30(3), 2006. Cost: n to refit, and the
// pairs of nodes that overlap.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::builtin {
namespace {

/// The most bodies of a leaf.
constexpr std::uint32_t kBodiesOfLeaf = 4;
/// The surface at which the tree is built again, relative to that at the last build.
constexpr double kWorn = 2;

Box Around(const Box& a, const Box& b) {
  return {{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y),
           std::min(a.lower.z, b.lower.z)},
          {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y),
           std::max(a.upper.z, b.upper.z)}};
}

/// Half the surface.
double SurfaceOf(const Box& box) {
  const double x = box.upper.x - box.lower.x, y = box.upper.y - box.lower.y,
               z = box.upper.z - box.lower.z;
  return x * y + y * z + z * x;
}

class RefitTree final : public kernels::FiniteBoxes {
 private:
  void Build(const Scene& scene, std::span<const Id> bodies) override {
    order_.assign(bodies.begin(), bodies.end());
    Rebuild(scene);
  }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    Refit(scene);
    if (!(surface_ <= kWorn * built_surface_)) Rebuild(scene);
    scene_ = &scene;
    pairs_ = &pairs;
    MeetItself(0);
  }

  struct Node {
    Box box;
    /// Of a leaf: its bodies, in order_. Of another node: `end` is its second child; the first is
    /// the node after it.
    std::uint32_t begin, end;
    bool is_leaf;
  };

  void Rebuild(const Scene& scene) {
    nodes_.clear();
    if (order_.empty()) return;
    boxes_.resize(scene.size);
    std::ranges::copy(scene.boxes, boxes_.begin());
    BuildNode(0, static_cast<std::uint32_t>(order_.size()));
    Refit(scene);
    built_surface_ = surface_;
  }

  /// The bodies of `order_` from `begin` to `end`. They are halved at each step, so that the depth
  /// is that of a balanced tree.
  void BuildNode(std::uint32_t begin, std::uint32_t end) {
    const auto node = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({.box = {}, .begin = begin, .end = end, .is_leaf = true});
    if (end - begin <= kBodiesOfLeaf) return;
    const auto part = std::span(order_).subspan(begin, end - begin);
    const double Vec3::*axis = LongestAxis(part);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::ranges::nth_element(part, part.begin() + (middle - begin), {}, [&](Id id) {
      return boxes_[id].lower.*axis / 2 + boxes_[id].upper.*axis / 2;
    });
    BuildNode(begin, middle);
    nodes_[node].is_leaf = false;
    nodes_[node].end = static_cast<std::uint32_t>(nodes_.size());
    BuildNode(middle, end);
  }

  const double Vec3::*LongestAxis(std::span<const Id> part) const {
    Box all = boxes_[part[0]];
    for (const Id id : part) all = Around(all, boxes_[id]);
    const double x = all.upper.x - all.lower.x, y = all.upper.y - all.lower.y,
                 z = all.upper.z - all.lower.z;
    return x >= y && x >= z ? &Vec3::x : y >= z ? &Vec3::y : &Vec3::z;
  }

  /// Copies the boxes into the order of the leaves, and bounds each node. Children stand after
  /// their parents.
  void Refit(const Scene& scene) {
    boxes_.resize(order_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) boxes_[i] = scene.boxes[order_[i]];
    surface_ = 0;
    for (std::size_t i = nodes_.size(); i-- > 0;) {
      Node& node = nodes_[i];
      if (node.is_leaf) {
        node.box = boxes_[node.begin];
        for (std::uint32_t body = node.begin + 1; body < node.end; ++body)
          node.box = Around(node.box, boxes_[body]);
      } else {
        node.box = Around(nodes_[i + 1].box, nodes_[node.end].box);
      }
      surface_ += SurfaceOf(node.box);
    }
  }

  void MeetItself(std::uint32_t at) {
    const Node& node = nodes_[at];
    if (node.is_leaf) {
      for (std::uint32_t i = node.begin; i < node.end; ++i)
        for (std::uint32_t k = i + 1; k < node.end; ++k) Test(i, k);
      return;
    }
    MeetItself(at + 1);
    MeetItself(node.end);
    Meet(at + 1, node.end);
  }

  /// Two nodes without a body in common: descends into the larger one.
  void Meet(std::uint32_t a, std::uint32_t b) {
    const Node &first = nodes_[a], &second = nodes_[b];
    if (!Overlap(first.box, second.box)) return;
    if (first.is_leaf && second.is_leaf) {
      for (std::uint32_t i = first.begin; i < first.end; ++i)
        if (Overlap(boxes_[i], second.box))
          for (std::uint32_t k = second.begin; k < second.end; ++k) Test(i, k);
    } else if (second.is_leaf ||
               (!first.is_leaf && SurfaceOf(first.box) >= SurfaceOf(second.box))) {
      Meet(a + 1, b);
      Meet(first.end, b);
    } else {
      Meet(a, b + 1);
      Meet(a, second.end);
    }
  }

  void Test(std::uint32_t i, std::uint32_t k) {
    if (Overlap(boxes_[i], boxes_[k]) && scene_->MayCollide(order_[i], order_[k]))
      pairs_->push_back(Ordered(order_[i], order_[k]));
  }

  std::vector<Node> nodes_;  ///< the root first
  std::vector<Id> order_;    ///< the bodies of the leaves, one leaf after the other
  std::vector<Box> boxes_;   ///< of order_; while the tree is built, by body
  double surface_ = 0, built_surface_ = 0;
  const Scene* scene_ = nullptr;
  std::vector<Pair>* pairs_ = nullptr;
};

}  // namespace

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeRefitTree(const Options& options) {
  return kernels::MakeDetector<RefitTree>(options);
}

}  // namespace cdb::builtin
