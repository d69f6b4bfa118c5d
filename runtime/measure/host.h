// Facts about this machine.
#pragma once

#include <string>

namespace cdb::measure {

/// Its name; `localhost` where it has none.
std::string HostName();

}  // namespace cdb::measure
