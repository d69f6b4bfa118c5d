#include "runtime/sweep/process/processors.h"

#include <fmt/format.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

namespace cdb::process {
namespace {

/// Has no descriptor if another process holds the claim.
Descriptor Claim(std::string_view name, int cpu) {
  Descriptor fd(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  const std::string text = fmt::format("{}-{}", name, cpu);
  // After the NUL that marks the abstract namespace.
  const std::size_t size = std::min(text.size(), sizeof address.sun_path - 1);
  std::memcpy(address.sun_path + 1, text.data(), size);
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + size);
  if (bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), length) != 0) fd.Close();
  return fd;
}

}  // namespace

ClaimedProcessors::ClaimedProcessors(std::size_t slots, std::string_view name) {
  cpu_set_t allowed;
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0 ||
      static_cast<std::size_t>(CPU_COUNT(&allowed)) < slots)
    return;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0 && cpus_.size() < slots; --cpu) {
    if (!CPU_ISSET(cpu, &allowed)) continue;
    Descriptor claim = Claim(name, cpu);
    if (claim.get() < 0) continue;
    cpus_.push_back(cpu);
    claims_.push_back(std::move(claim));
  }
  if (cpus_.size() == slots) return;
  cpus_.clear();
  claims_.clear();
}

}  // namespace cdb::process
