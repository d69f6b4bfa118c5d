// The topics of `cdb doc`.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace cdb::help {

struct Topic {
  std::string_view name, doc;
  std::string (*text)();
};

/// In the order in which `cdb doc` lists them.
std::span<const Topic> Topics();

}  // namespace cdb::help
