// Caches convex decompositions by all of their inputs.
//
// A form takes up to seconds to compute and a few kilobytes to keep; found again, it is the same to
// the last bit. One process computes it while others that need it wait. Errors: those of `make`.
// Where forms cannot be kept, nothing comes of it. Threads: any.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "library/content_cache.h"
#include "library/objects/compound.h"

namespace cdb::objects {

/// What `make` gives, or what it gave in an earlier call that left it in `folder`; it has this
/// `name` either way. `source`: what `make` depends on besides the code, as the hash of a file.
ConvexDecomposition DecomposeOnce(std::string name, std::string_view source,
                                  const std::function<ConvexDecomposition()>& make,
                                  const std::filesystem::path& folder = library::CacheFolder());

/// 64 hex digits: of the source, of DecomposerVersion and of the code here.
std::string DecompositionKey(std::string_view source);

}  // namespace cdb::objects
