// Caches convex decompositions by all of their inputs.
//
// A form takes up to seconds to compute and a few kilobytes to store; a cached form is identical to
// the last bit. One process computes it while others that need it wait. Errors: those of `make`; a
// form that cannot be stored is not an error. Threads: any.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "library/content_cache.h"
#include "library/objects/compound.h"

namespace cdb::objects {

/// The result of `make`, or of an earlier call stored in `folder`, always with this `name`.
/// `source`: the inputs of `make` besides the code, such as the hash of a file.
ConvexDecomposition DecomposeOnce(std::string name, std::string_view source,
                                  const std::function<ConvexDecomposition()>& make,
                                  const std::filesystem::path& folder = library::CacheFolder());

/// 64 hex digits, a hash of the source, of DecomposerVersion and of the version of the code here.
std::string DecompositionKey(std::string_view source);

}  // namespace cdb::objects
