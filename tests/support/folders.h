// Where the repository and the build are, so that tests run from any folder.
#pragma once

#include <filesystem>

namespace cdb::tests {

/// Of the repository.
std::filesystem::path SourceFolder();
/// Where the programs are built.
std::filesystem::path BuildFolder();

}  // namespace cdb::tests
