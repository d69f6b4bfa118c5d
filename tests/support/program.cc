#include "tests/support/program.h"

#include <fcntl.h>
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

pid_t Program::Start(const std::vector<std::string>& arguments) const {
  const pid_t child = fork();
  CDB_CHECK(child >= 0);
  if (child > 0) return child;
  const auto redirect = [&](const char* name, int fd) {
    const int file = open((folder_ / name).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(file, fd);
  };
  redirect("stdout.txt", STDOUT_FILENO);
  redirect("stderr.txt", STDERR_FILENO);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  if (chdir(folder().c_str()) == 0) execv(argv[0], argv.data());
  _exit(127);
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
