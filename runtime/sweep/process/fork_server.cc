#include "runtime/sweep/process/fork_server.h"

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
  spawn.Give(theirs.get(), protocol::kServerFd);
  spawn.SetVariable(std::string(protocol::kBindNow) + "=1");
  pid_ = spawn.Start(program, {protocol::kServeOption});
}

ForkServer::~ForkServer() {
  kill(pid_, SIGKILL);  // it has not been reaped, so its id is still valid
  while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
  }
}

protocol::ForkAnswer ForkServer::Start(const protocol::ForkRequest& request) {
  return protocol::AskForWorker(socket_.get(), request);
}

}  // namespace cdb::process
