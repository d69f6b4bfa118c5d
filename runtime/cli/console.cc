#include "runtime/cli/console.h"

#include <cstdio>

namespace cdb::runtime {

void Print(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stdout); }

void Say(std::string_view text) { std::fwrite(text.data(), 1, text.size(), stderr); }

}  // namespace cdb::runtime
