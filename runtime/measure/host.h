// The machine that we are on.
#pragma once

#include <string>

namespace cdb::runtime {

/// Its name; `localhost` where it has none.
std::string HostName();

}  // namespace cdb::runtime
