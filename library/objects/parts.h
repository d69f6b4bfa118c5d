// Solids of several parts, as `type compound(part(…), …)` lists them: each a closed form or the
// hulls of a mesh, at its own place.
//
// Lengths in m. Round parts become polytopes with their corners on the surface; volumes, centres
// and moments are those of the round ones. Where parts overlap, the common volume counts twice.
// Errors: SceneError. Threads: any.
#pragma once

#include <functional>
#include <memory>

#include "compiler/schema/value.h"
#include "library/objects/compound.h"

namespace cdb::objects {

using Form = std::shared_ptr<const ConvexDecomposition>;

/// Corners round the axis of a cylinder, a cone, a capsule and an ellipsoid.
inline constexpr int kPartCorners = 64, kBallCorners = 24;

/// `form_of`: the form of the type of a part, a mesh or a hull; null for a closed form.
ConvexDecomposition MakeCompoundOfParts(const schema::Call& call,
                                        const std::function<Form(const schema::Value&)>& form_of);

}  // namespace cdb::objects
