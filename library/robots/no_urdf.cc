// Of a build without urdfdom.
#include <fmt/format.h>

#include "library/robots/builder.h"

namespace cdb::robots {

bool HasUrdf() { return false; }

std::optional<analysis::Robot> ReadUrdf(const std::string&, RobotBuilder& builder,
                                        std::vector<analysis::RobotFault>& faults) {
  faults.push_back({fmt::format("{}: this build reads no URDF", builder.path()),
                    "install liburdfdom-dev and build cdb again (`./setup --import`)",
                    analysis::RobotFault::Kind::kUnavailable});
  return std::nullopt;
}

}  // namespace cdb::robots
