// Converts the library's solids to the shapes of the detector interface.
#pragma once

#include <deque>
#include <map>
#include <tuple>
#include <vector>

#include "library/detectors/detector.h"
#include "library/objects/solid.h"

namespace cdb::detection {

/// Owns the data that the shapes refer to; equal solids share it. Not thread-safe.
class DetectorShapes {
 public:
  /// Valid during the lifetime of this object. Tetrahedra and compounds of one piece are hulls.
  Shape Of(const objects::Solid& solid);

 private:
  struct Pieces {
    std::deque<std::vector<Vec3>> vertices;
    std::deque<std::vector<Face>> faces;
    std::vector<Hull> hulls;
    void Add(std::vector<Vec3> points, std::vector<Face> sides);
  };
  using Key = std::tuple<objects::Shape, const objects::Compound*, double, double, double>;

  const Pieces& PiecesOf(const objects::Solid& solid);

  std::map<Key, Pieces> pieces_;
};

}  // namespace cdb::detection
