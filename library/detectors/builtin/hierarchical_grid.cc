// `hierarchical_grid`: a uniform grid for each range of box sizes.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::builtin {
namespace {

/// The first level holds boxes shorter than 4^-9 m, the last those of 4^10 m or longer.
constexpr int kLevels = 21;

int LevelOf(const Box& box) {
  const double longest =
      std::max({box.upper.x - box.lower.x, box.upper.y - box.lower.y, box.upper.z - box.lower.z});
  if (!(longest > 0)) return 0;  // or NaN: any level will do
  return static_cast<int>(std::clamp(std::floor(std::log2(longest) / 2) + kLevels / 2, 0.,
                                     static_cast<double>(kLevels - 1)));
}

class Levels final : public Detector {
 public:
  explicit Levels(const kernels::Kernels& kernels) : kernels_(kernels) {
    for (int level = 0; level < kLevels; ++level) levels_.emplace_back(kernels);
  }

  void Prepare(const Scene& scene) override { bodies_.Learn(scene); }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    bodies_.LearnOnce(scene);
    for (Level& level : levels_) {
      level.ids.clear();
      level.boxes.clear();
    }
    for (Id id = 0; id < bodies_.movers(); ++id) {
      Level& level = levels_[static_cast<std::size_t>(LevelOf(scene.boxes[id]))];
      level.ids.push_back(id);
      level.boxes.push_back(scene.boxes[id]);
    }
    bool is_exact = true;
    for (Level& level : levels_)
      if (!level.ids.empty()) is_exact &= level.grid.Build(level.boxes.data(), level.boxes.size());
    found_.Clear();
    for (std::size_t own = 0; own < levels_.size(); ++own) {
      const Level& level = levels_[own];
      if (level.ids.empty()) continue;
      const std::size_t before = found_.size();
      level.grid.QueryPart(0, 1, found_.sink());
      Rename(found_.pairs().subspan(before), level.ids, level.ids);
      for (std::size_t other = own + 1; other < levels_.size(); ++other) {
        const Level& larger = levels_[other];
        if (larger.ids.empty()) continue;
        const std::size_t begin = found_.size();
        for (Id i = 0; i < level.ids.size(); ++i)
          larger.grid.QueryOne(kernels::Around(level.boxes[i], kernels_), i, found_.sink());
        Rename(found_.pairs().subspan(begin), level.ids, larger.ids);
      }
    }
    bodies_.Sieve(scene, is_exact, found_);
    bodies_.MeetWalls(scene, kernels_, found_);
    pairs.insert(pairs.end(), found_.pairs().begin(), found_.pairs().end());
  }

 private:
  struct Level {
    explicit Level(const kernels::Kernels& kernels) : grid(kernels) {}
    kernels::BoxGrid grid;
    std::vector<Id> ids;
    std::vector<Box> boxes;
  };

  /// Replaces indices within levels by body ids.
  static void Rename(std::span<Pair> pairs, const std::vector<Id>& first,
                     const std::vector<Id>& second) {
    for (Pair& pair : pairs) {
      const Id a = first[pair.a], b = second[pair.b];
      pair = {std::min(a, b), std::max(a, b)};
    }
  }

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  std::vector<Level> levels_;  ///< from the smallest
  kernels::PairBuffer found_;
};

}  // namespace

/// Exact pairs. Method: boxes of similar length, within a factor of four, share a grid
/// (box_grid.h). Pairs are found within each grid, and by querying the grids of all larger boxes.
/// Suits sizes that span several orders of magnitude, for which `grid` has to test the larger boxes
/// with all others. Cost: bodies times the number of larger grids, plus the pairs. Memory: about
/// 130 bytes a body. Errors: bad_alloc. Threads: only the caller's. Source: Ericson, Real-Time
/// Collision Detection, section 7.2; Woulfe & Manzke 2009, section 2.
std::unique_ptr<Detector> MakeHierarchicalGrid(const Options&, const kernels::Kernels& kernels) {
  return std::make_unique<Levels>(kernels);
}

}  // namespace cdb::builtin
