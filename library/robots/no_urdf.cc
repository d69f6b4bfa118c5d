// Of a build without urdfdom.
#include <fmt/format.h>

#include "library/robots/urdf.h"

namespace cdb::robots {

bool HasReader() { return false; }

std::optional<analysis::Robot> ParseUrdf(const std::string&, const std::string& path,
                                         const analysis::RobotOptions&,
                                         std::vector<analysis::RobotFault>& faults) {
  faults.push_back({fmt::format("{}: this build reads no robots", path),
                    "install liburdfdom-dev and build cdb again (`./setup --import`)",
                    analysis::RobotFault::Kind::kUnavailable});
  return std::nullopt;
}

}  // namespace cdb::robots
