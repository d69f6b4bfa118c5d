#include "runtime/engine/worker/landlock.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>

namespace cdb::worker {
namespace {

// From the kernel's linux/landlock.h. The header of the system may be older than its kernel.
struct Ruleset {
  std::uint64_t files, network, scopes;
};
constexpr long kCreateRuleset = 444, kRestrictSelf = 446;  // the same on every processor
constexpr unsigned kAskForVersion = 1;

// Rights of files by bit: 0 execute, 1 write, 2 and 3 read, 4 to 12 remove and make, 13 link and
// rename between folders, 14 truncate, 15 ioctl of devices.
constexpr std::uint64_t kFirstFiles = 0x1fff & ~0b1100u, kLink = 1 << 13, kTruncate = 1 << 14,
                        kDevices = 1 << 15;
constexpr std::uint64_t kAllTcp = 0b11, kAllScopes = 0b11;

}  // namespace

void RestrictByLandlock() {
  const long version = syscall(kCreateRuleset, nullptr, std::size_t{0}, kAskForVersion);
  if (version < 1) return;
  Ruleset rules = {kFirstFiles, 0, 0};
  if (version >= 2) rules.files |= kLink;
  if (version >= 3) rules.files |= kTruncate;
  if (version >= 4) rules.network = kAllTcp;
  if (version >= 5) rules.files |= kDevices;
  if (version >= 6) rules.scopes = kAllScopes;
  const std::size_t size = version >= 6   ? sizeof rules
                           : version >= 4 ? offsetof(Ruleset, scopes)
                                          : offsetof(Ruleset, network);
  // No rule is added, so none of these rights is granted anywhere.
  const long ruleset = syscall(kCreateRuleset, &rules, size, 0u);
  if (ruleset < 0) return;
  syscall(kRestrictSelf, ruleset, 0u);
  close(static_cast<int>(ruleset));
}

}  // namespace cdb::worker
