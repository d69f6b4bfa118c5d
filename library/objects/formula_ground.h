// Ground that a formula gives: `type height(…)` and `type implicit(…)`, as surfaces.
//
// The triangles are what objects touch; how far they are from the formula is measured.
// Errors: SceneError. Threads: any.
#pragma once

#include <memory>

#include "compiler/schema/value.h"
#include "library/objects/compound.h"

namespace cdb::objects {

bool IsFormulaGround(const schema::Call& type);

/// Placed by the origin of the formula. The last ones are kept.
std::shared_ptr<const ConvexDecomposition> FormulaGround(const schema::Call& type);

}  // namespace cdb::objects
