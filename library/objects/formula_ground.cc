#include "library/objects/formula_ground.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <deque>
#include <mutex>
#include <string>
#include <utility>

#include "compiler/schema/formula.h"
#include "compiler/schema/parametrised_words.h"
#include "library/objects/surface.h"
#include "library/scene_error.h"
#include "library/terrain/zero_set.h"

namespace cdb::objects {
namespace {

using Eigen::Vector3d;

/// Ground of a formula, placed by the origin of that.
ConvexDecomposition FormOfFormula(const std::string& name, const schema::Call& call) {
  constexpr std::array<std::string_view, 3> kVariables = {"x", "y", "z"};
  const auto program =
      std::make_shared<schema::FormulaProgram>(ArgumentOf(call, "formula"), kVariables);
  const terrain::Function function = [program](const Vector3d& at) {
    return (*program)(std::array<double, 3>{at.x(), at.y(), at.z()});
  };
  const auto number = [&](const char* argument) {
    return schema::AsNumber(ArgumentOf(call, argument))->AsReal();
  };
  const double cell = number("cell");
  terrain::Deviation deviation;
  ConvexDecomposition form;
  if (call.name == schema::kHeightCall) {
    const double width = number("width");
    const schema::Number* given = schema::AsNumber(ArgumentOf(call, "depth"));
    const double depth = given != nullptr ? given->AsReal() : width;
    form = MakeSurface(name, std::make_shared<const terrain::HeightGrid>(
                                 terrain::HeightsOf(function, width, depth, cell, deviation)));
    // The first height is at x = z = 0 of the grid.
    const Vector3d origin = Vector3d(width / 2, 0, depth / 2) - form.heights->box().center();
    form.origin = origin.cwiseQuotient(form.native_side * form.proportions);
  } else {
    const Eigen::AlignedBox3d box(*schema::AsVector(ArgumentOf(call, "lower")),
                                  *schema::AsVector(ArgumentOf(call, "upper")));
    if (!(box.sizes().minCoeff() > 0))
      throw library::SceneError("lower is not below upper along each axis",
                                "for example `lower: (-5, -1, -5), upper: (5, 1, 5)`");
    const meshes::Mesh mesh = terrain::ZeroSetOf(function, box, cell, deviation);
    if (mesh.triangles.size() > kMaxSurfaceTriangles)
      throw library::SceneError(
          fmt::format("the surface of the formula has {} triangles; the limit is {}",
                      mesh.triangles.size(), kMaxSurfaceTriangles),
          fmt::format("make the cell larger, such as `cell: {:.2g}`", 1.5 * cell));
    form = MakeSurface(name, mesh);
    form.origin = form.file_origin;
  }
  form.deviation = deviation.most;
  form.points_compared = deviation.points;
  return form;
}

}  // namespace

bool IsFormulaGround(const schema::Call& type) {
  return type.name == schema::kHeightCall || type.name == schema::kImplicitCall;
}

std::shared_ptr<const ConvexDecomposition> FormulaGround(const schema::Call& type) {
  using Form = std::shared_ptr<const ConvexDecomposition>;
  constexpr std::size_t kMostKept = 8;
  static std::mutex mutex;
  static std::deque<Form> kept;
  const std::string name = schema::ToText(type);
  {
    const std::lock_guard lock(mutex);
    const auto found = std::ranges::find(kept, name, [](const Form& form) { return form->name; });
    if (found != kept.end()) return *found;
  }
  const Form form = std::make_shared<const ConvexDecomposition>(FormOfFormula(name, type));
  const std::lock_guard lock(mutex);
  kept.push_back(form);
  if (kept.size() > kMostKept) kept.pop_front();
  return form;
}

}  // namespace cdb::objects
