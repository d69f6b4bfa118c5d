// Ground that is read from a file: `type heights(…)` and `type voxels(…)`, as surfaces.
//
// Errors: SceneError. Threads: any.
#pragma once

#include <string>

#include "compiler/schema/value.h"
#include "library/objects/compound.h"

namespace cdb::objects {

bool IsGroundFile(const schema::Call& type);

/// `bytes` are those of the file.
ConvexDecomposition GroundOfFile(const std::string& name, const schema::Call& type,
                                 const std::string& bytes);

}  // namespace cdb::objects
