// The folders of the repository and the build, so that tests can run from any folder.
#pragma once

#include <filesystem>

namespace cdb::tests {

/// The root of the repository.
std::filesystem::path SourceFolder();
/// The folder with the built programs.
std::filesystem::path BuildFolder();

}  // namespace cdb::tests
