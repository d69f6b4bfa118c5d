// Boost.Geometry's R-tree, packed anew every cycle and queried once for every body.
//
// Source: S. Leutenegger et al., STR: a simple and efficient algorithm for R-tree packing, 1997.
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <boost/iterator/function_output_iterator.hpp>
#include <vector>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::third_party {
namespace {

namespace geometry = boost::geometry;
using Point = geometry::model::point<double, 3, geometry::cs::cartesian>;
using Bounds = geometry::model::box<Point>;
using Value = std::pair<Bounds, Id>;
using Tree = geometry::index::rtree<Value, geometry::index::quadratic<16>>;

class Rtree final : public kernels::FiniteBoxes {
 private:
  void Build(const Scene&, std::span<const Id>) override {}

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    values_.clear();
    for (const Id body : bodies()) {
      const auto& [lower, upper] = scene.boxes[body];
      values_.emplace_back(Bounds({lower.x, lower.y, lower.z}, {upper.x, upper.y, upper.z}), body);
    }
    const Tree tree(values_);
    for (const auto& [bounds, a] : values_)
      tree.query(geometry::index::intersects(bounds),
                 boost::make_function_output_iterator([&, a = a](const Value& other) {
                   if (a < other.second) pairs.push_back({a, other.second});
                 }));
  }

  std::vector<Value> values_;
};

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("rtree", kernels::MakeDetector<Rtree>),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
