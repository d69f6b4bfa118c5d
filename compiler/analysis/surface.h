// Objects whose type is a surface: triangles without an inside, which do not move.
#pragma once

#include "compiler/plan/plan.h"

namespace cdb::analysis {

/// The type that is one, of a mesh; `heights` is one too.
inline constexpr std::string_view kSurfaceWord = "surface";

/// The type is a surface or a height field.
bool IsSurface(const schema::Call& type);
/// The group has objects, and they are surfaces, or some of them may be drawn to be.
bool HasSurface(const plan::GroupSettings& settings);

}  // namespace cdb::analysis
