#include "runtime/protocol/settling.h"

#include <fmt/format.h>

namespace cdb::protocol {

std::string SettlingText(const Settling& settling) {
  switch (settling.phase.load(std::memory_order_relaxed)) {
    case SettlingPhase::kWaiting:
      return "another run settles the same pile";
    case SettlingPhase::kSettling:
      return fmt::format("{} of {} objects at rest",
                         settling.at_rest.load(std::memory_order_relaxed),
                         settling.objects.load(std::memory_order_relaxed));
    case SettlingPhase::kNone:
      break;
  }
  return {};
}

}  // namespace cdb::protocol
