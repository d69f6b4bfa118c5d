// Boxes that move like the objects of well-known scenes, without physics, for tests of detectors.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "library/detectors/detector.h"

namespace cdb::tests {

/// `sparse` (the cube of Woulfe & Manzke 2009, nearly no pairs), `dense` (15 % full, moving a tenth
/// of a size a cycle), `cluster` (normally distributed about 0), `swarms` (a quarter as in
/// `sparse`, the others in six clusters), `pile` (layers that jitter), `asleep` (the same at rest),
/// `shots` (the same, and one in fifty flies through it, up to half a size a cycle), `mixed` (sizes
/// 50 to 500 and rods of 1 : 1 : 50). Everything is drawn from `seed`.
class BoxScene {
 public:
  BoxScene(std::string_view name, std::size_t objects, bool walls = false, std::uint64_t seed = 1);

  /// Gives the walls, which must be six, the boxes of the half-spaces outside a cube that is
  /// slightly smaller than that of the objects.
  void CutWalls();

  /// The present state of the bodies; valid until Move or the end of this object.
  Scene View() const;
  /// Advances by one cycle. Objects bounce off the sides of their cube.
  void Move();

 private:
  double Uniform(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random_);
  }

  std::mt19937_64 random_;
  bool jitters_ = false;
  double half_side_ = 0, jitter_ = 0;
  std::vector<Vec3> half_, at_, step_;
  std::vector<Box> boxes_;
  std::vector<Filter> filters_;
  std::vector<std::uint8_t> is_asleep_;
};

/// The names of the scenes.
inline constexpr std::string_view kBoxScenes[] = {"sparse", "dense",  "cluster", "swarms",
                                                  "pile",   "asleep", "shots",   "mixed"};

/// Bodies whose boxes the test sets itself.
struct Boxes {
  Boxes() = default;
  explicit Boxes(std::vector<Box> of) : boxes(std::move(of)), filters(boxes.size()) {}

  void Add(const Box& box, const Filter& filter = {}) {
    boxes.push_back(box);
    filters.push_back(filter);
  }
  Scene View() const {
    return {.size = boxes.size(),
            .boxes = boxes,
            .filters = filters,
            .poses = {},
            .shapes = {},
            .is_asleep = {}};
  }

  std::vector<Box> boxes;
  std::vector<Filter> filters;
};

/// A cube about (x, y, z).
inline Box Cube(double x, double y, double z, double half) {
  return {{x - half, y - half, z - half}, {x + half, y + half, z + half}};
}

/// The pairs that the detector lists, in its order.
std::vector<Pair> Listed(Detector& detector, const Scene& scene);
std::vector<Pair> SortedPairs(Detector& detector, const Scene& scene);

/// Lists the sorted pairs that result from a detector's changes, and sometimes calls its FindPairs.
/// An impossible change fails the test.
class KeptPairs final : public Detector {
 public:
  explicit KeptPairs(std::unique_ptr<Detector> detector) : detector_(std::move(detector)) {}
  void Prepare(const Scene& scene) override { detector_->Prepare(scene); }
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override;

 private:
  std::unique_ptr<Detector> detector_;
  std::set<Pair> kept_;
  int calls_ = 0;
};

/// All overlapping pairs, found by testing every pair; exact_pairs.h must find the same.
std::vector<Pair> BruteForce(const Scene& scene);

}  // namespace cdb::tests
