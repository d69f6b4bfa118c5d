// The versions of the schema of results files, and the paths of today's arrays in older ones.
#pragma once

#include <string>
#include <string_view>

#include "runtime/results/hdf5/file.h"

namespace cdb::results {

inline constexpr std::string_view kSchema = "cdb-results";
/// Increase it if a reader of the version before would misinterpret a file.
inline constexpr int kSchemaVersion = 2;
inline constexpr int kOldestSchemaVersion = 1;

/// The attribute `frame` of `poses`; files without it have poses of bodies.
inline constexpr std::string_view kPoseFrame = "origin";

/// `Conventions`: the meaning of the attributes of a file, for netCDF readers. CF has groups and
/// texts from 1.8 on.
inline constexpr std::string_view kConventions = "CF-1.8";

/// The version of a results file. Throws StoreError if this cdb cannot read it.
int ReadVersion(const hdf5::File& file, const std::string& name);

/// The path, in a file of `version`, of the array that this version stores at `path`.
std::string PathIn(int version, std::string_view path);

}  // namespace cdb::results
