#include <filesystem>
#include <system_error>
#include <vector>

#include "library/robots/urdf.h"

namespace cdb::robots {

namespace fs = std::filesystem;

std::string MeshPath(std::string_view written, const std::string& robot_file,
                     const std::string& packages) {
  const fs::path folder = fs::path(robot_file).parent_path();
  std::vector<fs::path> candidates;
  const std::size_t scheme = written.find("://");
  if (scheme == written.npos) {
    candidates.push_back(folder / written);
  } else if (written.starts_with("file://")) {
    candidates.push_back(folder / written.substr(scheme + 3));
  } else {
    const fs::path in_package(written.substr(scheme + 3));
    const fs::path rest = in_package.lexically_relative(*in_package.begin());
    if (!packages.empty()) {
      candidates.push_back(fs::path(packages) / in_package);
      candidates.push_back(fs::path(packages) / rest);
    }
    std::error_code error;
    fs::path above = fs::absolute(folder, error).lexically_normal(), way = folder;
    for (; !above.empty() && above != above.parent_path(); above = above.parent_path()) {
      candidates.push_back(way / in_package);
      if (above.filename() == *in_package.begin()) candidates.push_back(way / rest);
      way /= "..";
    }
  }
  std::error_code error;
  for (const fs::path& candidate : candidates)
    if (fs::is_regular_file(candidate, error)) return candidate.lexically_normal().string();
  return candidates.empty() ? std::string(written) : candidates[0].lexically_normal().string();
}

}  // namespace cdb::robots
