#include "library/detectors/builtin/octree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "library/detectors/kernels/finite_boxes.h"

namespace cdb::builtin {
namespace {

constexpr std::uint32_t kNone = ~0u;
/// Cubes are halved so often at most; what is smaller still shares one.
constexpr int kMostLevels = 20;

class Octree final : public kernels::FiniteBoxes {
 private:
  void Build(const Scene& scene, std::span<const Id>) override { next_.resize(scene.size); }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    nodes_.clear();
    if (bodies().empty()) return;
    SetRoot(scene);
    // Each looks at those before it, then joins them.
    for (const Id body : bodies()) {
      const Box& box = scene.boxes[body];
      Search(box, [&](Id other) {
        if (Overlap(box, scene.boxes[other]) && scene.MayCollide(other, body))
          pairs.push_back({other, body});
      });
      Insert(body, box);
    }
  }

  struct Node {
    Vec3 centre;
    double half;  ///< of the cube; its bodies reach no farther than twice that from the centre
    std::uint32_t first = kNone;
    std::array<std::uint32_t, 8> children = {kNone, kNone, kNone, kNone,
                                             kNone, kNone, kNone, kNone};
  };

  static Vec3 Centre(const Box& box) {
    return {box.lower.x + (box.upper.x - box.lower.x) / 2,
            box.lower.y + (box.upper.y - box.lower.y) / 2,
            box.lower.z + (box.upper.z - box.lower.z) / 2};
  }

  void SetRoot(const Scene& scene) {
    Vec3 lower = {INFINITY, INFINITY, INFINITY}, upper = {-INFINITY, -INFINITY, -INFINITY};
    for (const Id body : bodies()) {
      const Box& box = scene.boxes[body];
      lower = {std::min(lower.x, box.lower.x), std::min(lower.y, box.lower.y),
               std::min(lower.z, box.lower.z)};
      upper = {std::max(upper.x, box.upper.x), std::max(upper.y, box.upper.y),
               std::max(upper.z, box.upper.z)};
    }
    const Vec3 half = {upper.x / 2 - lower.x / 2, upper.y / 2 - lower.y / 2,
                       upper.z / 2 - lower.z / 2};
    nodes_.push_back({.centre = {lower.x + half.x, lower.y + half.y, lower.z + half.z},
                      .half = std::max({half.x, half.y, half.z})});
  }

  template <typename Test>
  void Search(const Box& box, const Test& test) {
    stack_.assign(1, 0);
    while (!stack_.empty()) {
      const Node& node = nodes_[stack_.back()];
      stack_.pop_back();
      for (std::uint32_t body = node.first; body != kNone; body = next_[body]) test(body);
      for (const std::uint32_t child : node.children)
        if (child != kNone && Reaches(nodes_[child], box)) stack_.push_back(child);
    }
  }

  static bool Reaches(const Node& node, const Box& box) {
    // A little more than twice: centres are rounded.
    const double reach = node.half * (2 + 1e-9);
    const Vec3& c = node.centre;
    const auto slack = [](double x) { return std::fabs(x) * 1e-12; };
    return box.lower.x <= c.x + reach + slack(c.x) && c.x - reach - slack(c.x) <= box.upper.x &&
           box.lower.y <= c.y + reach + slack(c.y) && c.y - reach - slack(c.y) <= box.upper.y &&
           box.lower.z <= c.z + reach + slack(c.z) && c.z - reach - slack(c.z) <= box.upper.z;
  }

  void Insert(Id body, const Box& box) {
    const Vec3 centre = Centre(box);
    const double half = std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y,
                                  box.upper.z - box.lower.z}) /
                        2;
    std::uint32_t at = 0;
    for (int level = 0; level < kMostLevels && nodes_[at].half / 2 >= half; ++level) {
      const Node parent = nodes_[at];
      const bool right = centre.x > parent.centre.x, above = centre.y > parent.centre.y,
                 behind = centre.z > parent.centre.z;
      const std::size_t place = (right ? 1 : 0) + (above ? 2 : 0) + (behind ? 4 : 0);
      if (parent.children[place] == kNone) {
        const double step = parent.half / 2;
        nodes_[at].children[place] = static_cast<std::uint32_t>(nodes_.size());
        nodes_.push_back({.centre = {parent.centre.x + (right ? step : -step),
                                     parent.centre.y + (above ? step : -step),
                                     parent.centre.z + (behind ? step : -step)},
                          .half = step});
      }
      at = nodes_[at].children[place];
    }
    next_[body] = nodes_[at].first;
    nodes_[at].first = body;
  }

  std::vector<Node> nodes_;           ///< the root first
  std::vector<std::uint32_t> next_;   ///< by body: the next in its node
  std::vector<std::uint32_t> stack_;  ///< of Search
};

}  // namespace

Detector* MakeOctree(const Options& options) { return kernels::MakeDetector<Octree>(options); }

}  // namespace cdb::builtin
