#include "library/detectors/own.h"

#include "library/detectors/kd_tree.h"
#include "library/detectors/octree.h"

namespace cdb::library {
namespace {

/// Finds nothing: what calling a detector costs.
class Null final : public Detector {};

template <typename T>
Detector* Make(const Options&) {
  return new T;
}

constexpr DetectorEntry kEntries[] = {
    {"octree", "a loose octree", kBroad, 0, MakeOctree},
    {"kd_tree", "a k-d tree", kBroad, 0, MakeKdTree},
    {"null", "finds nothing", kBroad, 0, Make<Null>},
};

}  // namespace

std::span<const DetectorEntry> OwnDetectors() { return kEntries; }

}  // namespace cdb::library
