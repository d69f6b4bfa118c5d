// Programs of the system.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace cdb::process {

/// The executable file of that name in the first folder of PATH that has one. Threads: any.
std::optional<std::filesystem::path> FindProgram(const std::string& name);

}  // namespace cdb::process
