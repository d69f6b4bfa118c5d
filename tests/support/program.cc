#include "tests/support/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "dsl/text/check.h"
#include "tests/support/folders.h"

namespace cdb::tests {

std::string CdbPath() { return BuildFolder() / "cdb"; }

void Program::Write(const std::string& name, const std::string& text) const {
  WriteFile(folder_ / name, text);
}

std::string Program::Read(const std::string& name) const {
  return Exists(name) ? ReadFile(folder_ / name) : "";
}

bool Program::Exists(const std::string& name) const {
  return std::filesystem::exists(folder_ / name);
}

// Not by fork(), which copies the page tables of the test, large under the sanitizers.
pid_t Program::Start(const std::vector<std::string>& arguments) const {
  posix_spawn_file_actions_t actions;
  CDB_CHECK(posix_spawn_file_actions_init(&actions) == 0);
  posix_spawn_file_actions_addchdir_np(&actions, folder().c_str());
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "stdout.txt", flags, 0666);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "stderr.txt", flags, 0666);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t child = 0;
  const int fault = posix_spawn(&child, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  CDB_CHECK(fault == 0);
  return child;
}

Finished Program::Run(const std::vector<std::string>& arguments) const {
  std::vector<std::string> all = {CdbPath()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  int status = 0;
  CDB_CHECK(waitpid(Start(all), &status, 0) > 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), Read("stdout.txt"),
          Read("stderr.txt")};
}

Finished Program::Shell(const std::string& line) const {
  int status = 0;
  const std::string script = "CDB='" + CdbPath() + "'; " + line;
  CDB_CHECK(waitpid(Start({"/bin/sh", "-c", script}), &status, 0) > 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), Read("stdout.txt"),
          Read("stderr.txt")};
}

}  // namespace cdb::tests
