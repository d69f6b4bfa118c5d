// Of a build without pugixml.
#include <fmt/format.h>

#include "library/robots/builder.h"

namespace cdb::robots {
namespace {

std::optional<analysis::Robot> Refuse(const RobotBuilder& builder, const char* format,
                                      std::vector<analysis::RobotFault>& faults) {
  faults.push_back({fmt::format("{}: this build reads no {}", builder.path(), format),
                    "install libpugixml-dev and build cdb again (`./setup --import`)",
                    analysis::RobotFault::Kind::kUnavailable});
  return std::nullopt;
}

}  // namespace

bool HasXml() { return false; }

std::optional<analysis::Robot> ReadSdf(const std::string&, RobotBuilder& builder,
                                       std::vector<analysis::RobotFault>& faults) {
  return Refuse(builder, "SDF", faults);
}
std::optional<analysis::Robot> ReadMjcf(const std::string&, RobotBuilder& builder,
                                        std::vector<analysis::RobotFault>& faults) {
  return Refuse(builder, "MJCF", faults);
}

}  // namespace cdb::robots
