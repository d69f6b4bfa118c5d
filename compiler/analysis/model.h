// Facts about the solid that a value of `objects.type` names. The compiler and the library share
// them; the library reads models (library/objects/solid_factory.h).
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "compiler/plan/plan.h"

namespace cdb::analysis {

struct SoftMesh;

struct ModelFacts {
  /// Sides of the box around it, along the axes of the file, m: at `size native`, or at size 1 if
  /// no file gives it a size.
  Eigen::Vector3d sides = Eigen::Vector3d::Ones();
  bool has_size = false;  ///< a file gives it a size
  /// From the middle of the box to the point that a layout places, divided by the sides.
  Eigen::Vector3d placed = Eigen::Vector3d::Zero();
  /// Common volume of its hulls and the mesh divided by that of their union. Nullopt if it is not a
  /// compound, or is not decomposed yet.
  std::optional<double> iou;
  std::size_t hulls = 0;  ///< of a compound
  std::string text;       ///< of `cdb check`, on one line; empty for a closed form
  std::shared_ptr<const SoftMesh> tetrahedra = {};  ///< of soft( )

  /// The sides of a solid of this size and aspect; a size of 0 is native.
  Eigen::Vector3d SidesOf(double size, const Eigen::Vector3d& aspect) const {
    if (size == 0) return sides;
    return aspect == Eigen::Vector3d::Ones() ? Eigen::Vector3d(size / sides.maxCoeff() * sides)
                                             : Eigen::Vector3d(size * aspect);
  }
};

/// IoU of hulls and mesh; below it, objects touch where the mesh is not.
inline constexpr double kGoodFit = 0.8;

/// About the number of hulls for a good fit, if `hulls` have this IoU: the volume outside a mesh
/// falls with their number. At least `hulls` and 50, at most 1024.
inline std::size_t HullsForGoodFit(std::size_t hulls, double iou) {
  constexpr double kMargin = 1.2, kMost = 1024;
  const double outside = (1 / iou - 1) / (1 / kGoodFit - 1);
  const double needed = std::min(kMargin * static_cast<double>(hulls) * outside, kMost);
  return std::clamp<std::size_t>(10 * static_cast<std::size_t>(std::ceil(needed / 10)),
                                 std::max<std::size_t>(hulls, 50), 1024);
}

/// The reason why a type is no solid; `cause` names the file.
struct ModelFault {
  std::string cause, remedy;
  bool is_missing = false;  ///< its file is not on this machine; runs may be made on another one
};

/// Reads the facts about a constant type; a function, so that the compiler knows no file format.
using ReadModel =
    std::function<std::optional<ModelFacts>(const schema::Value& type, ModelFault& why)>;

/// The types that the objects of a group may have; empty without objects.
inline std::vector<schema::Value> TypesOf(const plan::GroupSettings& settings) {
  if (settings.Count("quantity") == 0) return {};
  const schema::Value& type = settings.Get("type");
  const schema::Distribution* drawn = schema::AsDistribution(type);
  return drawn != nullptr ? drawn->arguments : std::vector<schema::Value>{type};
}

}  // namespace cdb::analysis
