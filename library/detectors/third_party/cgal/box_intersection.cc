// CGAL's box_self_intersection_d: a streamed segment tree, built anew every cycle.
//
// Source: A. Zomorodian & H. Edelsbrunner, Fast software for box intersections, 2002.
#include <CGAL/box_intersection_d.h>

#include <cstddef>
#include <vector>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::third_party {
namespace {

/// With fewer boxes, CGAL tests them one by one.
constexpr std::ptrdiff_t kCutoff = 400;

/// The requirements of CGAL::Box_intersection_d::Box_traits_d on a box.
struct Element {
  using NT = double;
  using ID = Id;
  double lower[3], upper[3];
  Id body;
  static int dimension() { return 3; }
  Id id() const { return body; }
  double min_coord(int axis) const { return lower[axis]; }
  double max_coord(int axis) const { return upper[axis]; }
};

class BoxIntersection final : public kernels::FiniteBoxes {
 private:
  void Build(const Scene&, std::span<const Id>) override {}

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    elements_.clear();
    for (const Id body : bodies()) {
      const Box& box = scene.boxes[body];
      elements_.push_back(
          {{box.lower.x, box.lower.y, box.lower.z}, {box.upper.x, box.upper.y, box.upper.z}, body});
    }
    CGAL::box_self_intersection_d(
        elements_.begin(), elements_.end(),
        [&](const Element& a, const Element& b) { pairs.push_back(Ordered(a.body, b.body)); },
        kCutoff, CGAL::Box_intersection_d::CLOSED);
  }

  std::vector<Element> elements_;
};

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("cgal", kernels::MakeDetector<BoxIntersection>),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
