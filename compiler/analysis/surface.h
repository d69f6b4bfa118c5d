// Objects whose type is a surface: triangles without an inside, which cannot move.
#pragma once

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The word for a surface, as the type of a mesh; `heights` is a surface too.
inline constexpr std::string_view kSurfaceWord = "surface";

/// True if the type is a surface or a height field.
bool IsSurface(const schema::Call& type);
/// True if the group has objects, and all or some of them may be surfaces.
bool HasSurface(const plan::GroupSettings& settings);

}  // namespace cdb::analysis
