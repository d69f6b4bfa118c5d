#include "runtime/sweep/process/find_program.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace cdb::process {

std::optional<std::filesystem::path> FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "/bin:/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (const std::string program = folder + "/" + name; access(program.c_str(), X_OK) == 0)
      return program;
  return std::nullopt;
}

}  // namespace cdb::process
