// `octree`: a loose octree, rebuilt every cycle. Each body is in a cube of at least its own size
// that contains its centre, and is tested with the bodies of all cubes that its box reaches. A cube
// is split if more than eight of its bodies would fit into its halves. Bodies are inserted in
// Morton order, so that those of a cube are close in memory.
//
// Source: Ulrich, "Loose octrees", Game Programming Gems 1 (2000); Woulfe & Manzke 2009, section 2,
// lists octrees. Cost: n log n for evenly distributed bodies; bodies in the same place are all
// tested with each other.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::builtin {
namespace {

constexpr std::uint32_t kNone = ~0u;
/// The deepest level; all smaller bodies share its cubes.
constexpr int kMostLevels = 40;
/// A cube is halved when it holds more bodies than this that fit into its halves.
constexpr std::uint32_t kMostInLeaf = 8;

class Octree final : public kernels::FiniteBoxes {
 private:
  void Build(const Scene& scene, std::span<const Id>) override { sorted_.reserve(scene.size); }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    nodes_.clear();
    if (bodies().empty()) return;
    SetRoot(scene);
    Sort(scene);
    // Each body is tested with those already inserted, and is then inserted itself.
    for (std::uint32_t body = 0; body < sorted_.size(); ++body) {
      const Body& own = sorted_[body];
      Search(own.box, [&](std::uint32_t other) {
        const Body& met = sorted_[other];
        if (Overlap(own.box, met.box) && scene.MayCollide(own.id, met.id))
          pairs.push_back(Ordered(own.id, met.id));
      });
      Insert(body);
    }
  }

  /// Sorted along a space-filling curve, so that bodies close to each other are close in memory.
  struct Body {
    std::uint64_t place;  ///< position on the curve
    Box box;
    Id id;
  };
  struct Node {
    Vec3 centre;
    double half;  ///< half side; bodies extend no farther than twice this from the centre
    int level;
    bool is_leaf = true;
    std::uint32_t small = 0;  ///< bodies of a leaf that fit into its halves
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
                      .half = std::max({half.x, half.y, half.z}),
                      .level = 0});
  }

  /// Morton order: the bits of the three coordinates interleaved.
  void Sort(const Scene& scene) {
    constexpr int kBits = 21;
    const Node& root = nodes_[0];
    const double scale = root.half > 0 ? (1 << kBits) / (2 * root.half) : 0;
    const auto spread = [&](double x, double centre) {
      const double cell = std::clamp((x - (centre - root.half)) * scale, 0., (1 << kBits) - 1.);
      auto bits = static_cast<std::uint64_t>(cell);
      bits = (bits | bits << 32) & 0x1f00000000ffff;
      bits = (bits | bits << 16) & 0x1f0000ff0000ff;
      bits = (bits | bits << 8) & 0x100f00f00f00f00f;
      bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
      return (bits | bits << 2) & 0x1249249249249249;
    };
    sorted_.clear();
    for (const Id id : bodies()) {
      const Vec3 at = Centre(scene.boxes[id]);
      const std::uint64_t place = spread(at.x, root.centre.x) | spread(at.y, root.centre.y) << 1 |
                                  spread(at.z, root.centre.z) << 2;
      sorted_.push_back({place, scene.boxes[id], id});
    }
    std::ranges::sort(sorted_, {}, [](const Body& body) { return std::pair(body.place, body.id); });
    next_.resize(sorted_.size());
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
    // Slightly more than twice, because centres are rounded.
    const double reach = node.half * (2 + 1e-9);
    const Vec3& c = node.centre;
    const auto slack = [](double x) { return std::fabs(x) * 1e-12; };
    return box.lower.x <= c.x + reach + slack(c.x) && c.x - reach - slack(c.x) <= box.upper.x &&
           box.lower.y <= c.y + reach + slack(c.y) && c.y - reach - slack(c.y) <= box.upper.y &&
           box.lower.z <= c.z + reach + slack(c.z) && c.z - reach - slack(c.z) <= box.upper.z;
  }

  static double HalfOf(const Box& box) {
    return std::max(
               {box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z}) /
           2;
  }

  void Insert(std::uint32_t body) {
    const Vec3 centre = Centre(sorted_[body].box);
    const double half = HalfOf(sorted_[body].box);
    std::uint32_t at = 0;
    while (!nodes_[at].is_leaf && Halves(nodes_[at], half)) at = Child(at, centre);
    Put(at, body, half);
    if (nodes_[at].is_leaf && nodes_[at].small > kMostInLeaf) Split(at);
  }

  static bool Halves(const Node& node, double half) {
    return node.level < kMostLevels && node.half / 2 >= half;
  }

  void Put(std::uint32_t node, std::uint32_t body, double half) {
    next_[body] = std::exchange(nodes_[node].first, body);
    nodes_[node].small += Halves(nodes_[node], half);
  }

  /// Moves the bodies that fit into the halves to the children. A child that receives all of them
  /// is split at the next insertion.
  void Split(std::uint32_t node) {
    nodes_[node].is_leaf = false;
    std::uint32_t body = std::exchange(nodes_[node].first, kNone);
    while (body != kNone) {
      const std::uint32_t next = next_[body];
      const Box& box = sorted_[body].box;
      const double half = HalfOf(box);
      Put(Halves(nodes_[node], half) ? Child(node, Centre(box)) : node, body, half);
      body = next;
    }
  }

  /// The child that contains this point; created if missing.
  std::uint32_t Child(std::uint32_t at, const Vec3& point) {
    const Node parent = nodes_[at];
    const bool right = point.x > parent.centre.x, above = point.y > parent.centre.y,
               behind = point.z > parent.centre.z;
    const std::size_t place = (right ? 1 : 0) + (above ? 2 : 0) + (behind ? 4 : 0);
    if (parent.children[place] != kNone) return parent.children[place];
    const double step = parent.half / 2;
    const auto child = static_cast<std::uint32_t>(nodes_.size());
    nodes_[at].children[place] = child;
    nodes_.push_back({.centre = {parent.centre.x + (right ? step : -step),
                                 parent.centre.y + (above ? step : -step),
                                 parent.centre.z + (behind ? step : -step)},
                      .half = step,
                      .level = parent.level + 1});
    return child;
  }

  std::vector<Node> nodes_;  ///< the root first
  std::vector<Body> sorted_;
  std::vector<std::uint32_t> next_;   ///< for each body in sorted_, the next one in its node
  std::vector<std::uint32_t> stack_;  ///< of Search
};

}  // namespace

/// Exact pairs, each listed once. Threads: only the caller's.
Detector* MakeOctree(const Options& options) { return kernels::MakeDetector<Octree>(options); }

}  // namespace cdb::builtin
