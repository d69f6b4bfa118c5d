#include "runtime/process/fork_server.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <string>

namespace cdb::process {

ForkServer::ForkServer(const std::filesystem::path& program) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0)
    FailToStart("no descriptor to start a run", errno);
  socket_ = Descriptor(ends[0]);
  const Descriptor theirs(ends[1]), nowhere(open("/dev/null", O_WRONLY | O_CLOEXEC));
  SpawnPlan spawn;
  spawn.Give(nowhere.get(), STDERR_FILENO);  // if the server fails, a directly started worker
                                             // reports the reason
  spawn.Give(theirs.get(), measure::kServerFd);
  spawn.SetVariable(std::string(measure::kBindNow) + "=1");
  pid_ = spawn.Start(program, {measure::kServeOption});
}

ForkServer::~ForkServer() {
  kill(pid_, SIGKILL);  // it has not been reaped, so its id is still valid
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

measure::ForkAnswer ForkServer::Start(const measure::ForkRequest& request) {
  return measure::AskForWorker(socket_.get(), request);
}

}  // namespace cdb::process
