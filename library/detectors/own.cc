#include "library/detectors/own.h"

#include "library/detectors/auto.h"
#include "library/detectors/grid.h"
#include "library/detectors/kd_tree.h"
#include "library/detectors/levels.h"
#include "library/detectors/octree.h"
#include "library/detectors/skin.h"
#include "library/detectors/sweep.h"

namespace cdb::library {
namespace {

/// Finds nothing: what calling a detector costs.
class Null final : public Detector {};

using Maker = std::unique_ptr<Detector>(const Options& options, const Kernels& kernels);

template <Maker make>
Detector* Make(const Options& options) {
  return make(options, BestKernels()).release();
}

constexpr DetectorEntry kEntries[] = {
    {"auto", "skin, grid or sweep, as the scene moves", kBroad, 0, Make<MakeAuto>},
    {"skin", "a list of candidates that lasts for several cycles", kBroad, 0, Make<MakeSkin>},
    {"grid", "a uniform grid, rows of eight boxes at once", kBroad, 0, Make<MakeGrid>},
    {"hierarchical_grid", "a uniform grid for each size of box", kBroad, 0, Make<MakeLevels>},
    {"sweep", "sweep and prune along one axis, eight boxes at once", kBroad, 0, Make<MakeSweep>},
    {"octree", "a loose octree", kBroad, 0, MakeOctree},
    {"kd_tree", "a k-d tree", kBroad, 0, MakeKdTree},
    {"null", "finds nothing", kBroad, 0, [](const Options&) -> Detector* { return new Null; }},
};

}  // namespace

std::span<const DetectorEntry> OwnDetectors() { return kEntries; }

}  // namespace cdb::library
