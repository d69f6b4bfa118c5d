// The lists of `cdb list`.
#pragma once

#include <string>
#include <vector>

namespace cdb::cli {

std::vector<std::string> ListKinds();

}  // namespace cdb::cli
