// The files of `cdb generate`.
#pragma once

#include <string>
#include <vector>

namespace cdb::cli {

std::vector<std::string> GeneratedKinds();

}  // namespace cdb::cli
