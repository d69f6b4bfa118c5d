// Decompositions that were computed before, by the mesh, the options and the libraries.
//
// Errors: those of Decompose. Where they cannot be kept, that is said and nothing else comes of it.
// Threads: any.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "library/content_cache.h"
#include "library/meshes/decompose.h"

namespace cdb::library {

/// 64 hex digits: of the bytes of vertices and triangles, the options and DecomposerVersion.
std::string CacheKey(const Mesh& mesh, const DecomposeOptions& options);

enum class CacheUse {
  kFound,
  kStored,     ///< computed and stored
  kNotStored,  ///< computed; the folder cannot be written, or there is none
};

struct CachedDecomposition {
  Decomposition decomposition;
  CacheUse use = CacheUse::kNotStored;
};

/// `Decompose`, or what an earlier call has left in `folder`, which is made where it is missing.
CachedDecomposition DecomposeOnce(const Mesh& mesh, std::string_view name,
                                  const DecomposeOptions& options = {},
                                  const std::filesystem::path& folder = CacheFolder());

}  // namespace cdb::library
