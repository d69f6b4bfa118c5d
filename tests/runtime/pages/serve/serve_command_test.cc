// `cdb view --serve` against hostile clients, and its end by signals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <thread>
#include <vector>

#include "tests/runtime/pages/serve/client.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kServed =
    "benchmark served { world.side 10; objects { quantity 2; size 1 } }";

/// The program, listening.
class Served {
 public:
  Served() {
    program_.Write("served.cdb", kServed);
    pid_ = program_.Start({CdbPath(), "view", "--serve", "served.cdb"});
    while (program_.Read("stdout.txt").find('\n') == std::string::npos &&
           ::waitpid(pid_, nullptr, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    address_ = std::make_unique<Address>(program_.Read("stdout.txt"));
  }
  ~Served() {
    if (pid_ != 0) End(SIGKILL);
  }
  const Address& address() const { return *address_; }
  const Program& program() const { return program_; }

  /// Returns the exit status, or 128 + signal.
  int End(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  /// The most memory that it had in use, kB.
  long PeakMemory() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("VmHWM:")) return std::stol(line.substr(6));
    return 0;
  }
  int Threads() const {
    std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("Threads:")) return std::stoi(line.substr(8));
    return 0;
  }
  std::string Ask(const std::string& name, const std::string& body) const {
    return RawClient(*address_).Ask(Post(*address_, name, body));
  }

 private:
  Program program_;
  pid_t pid_ = 0;
  std::unique_ptr<Address> address_;
};

std::string Quoted(const std::string& text) { return R"({"text": ")" + text + R"("})"; }

TEST(ServeCommand, BoundsTheNestingOfQuestions) {
  const Served served;
  EXPECT_THAT(served.Ask("check", Quoted(kServed)), HasSubstr("\"parameters\""));
  const long before = served.PeakMemory();
  const std::string brackets(3'900'000, '[');
  EXPECT_EQ(StatusOf(served.Ask("check", brackets)), "400");
  EXPECT_EQ(StatusOf(served.Ask("check", R"({"text": )" + brackets)), "400");
  std::string many = "{\"text\": [0";
  for (int i = 0; i < 1'900'000; ++i) many += ",0";
  EXPECT_EQ(StatusOf(served.Ask("check", many + "]}")), "400");
  EXPECT_EQ(StatusOf(served.Ask("check", "")), "400");
  EXPECT_EQ(StatusOf(served.Ask("check", R"({"text": 5})")), "400");
  EXPECT_EQ(StatusOf(served.Ask("check", R"({"text": "\xff"})")), "400");
  EXPECT_LT(served.PeakMemory() - before, 40'000);
}

TEST(ServeCommand, FollowsTheBenchmarks) {
  const Served served;
  const auto check = [&](const std::string& text, const std::string& more = "") {
    return BodyOf(served.Ask("check", R"({"text": ")" + text + '"' + more + "}"));
  };
  const std::string block = " { world.side 10; objects { quantity 2; size 1 } }";
  // Renamed: its scene and its parameters follow.
  const std::string renamed = check("benchmark other" + block);
  EXPECT_THAT(renamed, HasSubstr(R"("benchmark":"other")"));
  EXPECT_THAT(renamed, HasSubstr("no longer has the benchmark 'served', so 'other' is shown"));
  EXPECT_THAT(renamed, HasSubstr(R"("name":"world.side","value":"10")"));
  EXPECT_THAT(renamed, Not(HasSubstr(R"("scene":null)")));
  // Also the second of two, and one that is chosen.
  const std::string two = "benchmark a" + block + " benchmark b" + block;
  EXPECT_THAT(check(two, R"(, "benchmark": "b")"),
              HasSubstr(R"("benchmark":"b","benchmarks":["a","b"],"notice":"")"));
  EXPECT_THAT(check("benchmark a" + block + " benchmark c" + block),
              HasSubstr(R"("benchmark":"c")"));
  // A text that does not parse is about the same benchmark as before.
  const std::string broken = check("benchmark a" + block + " benchmark d {{");
  EXPECT_THAT(broken, HasSubstr(R"("benchmark":"c")"));
  EXPECT_THAT(broken, HasSubstr(R"("parameters":null,"scene":null)"));
  EXPECT_THAT(broken, HasSubstr(R"("severity":1)"));
  EXPECT_THAT(check(""), HasSubstr("benchmark"));
  const std::string run = BodyOf(served.Ask("run", Quoted("benchmark a { cycles x }")));
  EXPECT_THAT(run, HasSubstr("not run and not saved: the text has 1 error"));
  EXPECT_EQ(served.program().Read("served.cdb"), kServed);
}

TEST(ServeCommand, AnswersAsTheLanguageServer) {
  const Served served;
  const auto ask = [&](const std::string& what, int character) {
    return BodyOf(
        served.Ask(what, R"({"text": "benchmark served { timest 1 }", "line": 0, "character": )" +
                             std::to_string(character) + "}"));
  };
  EXPECT_THAT(ask("complete", 25), HasSubstr(R"("newText":"timestep")"));
  EXPECT_THAT(ask("hover", 3), HasSubstr("benchmark"));
  EXPECT_EQ(ask("hover", 17), "null");
  EXPECT_THAT(ask("complete", 100'000), HasSubstr("["));  // beyond the end of the line
  EXPECT_THAT(served.Ask("check", Quoted("benchmark served { timest 1 }")),
              HasSubstr(R"("character":19,"line":0)"));
}

// A process with several threads must not be copied, and reading some models copies it.
TEST(ServeCommand, HasOneThread) {
  const Served served;
  EXPECT_THAT(served.Ask("check", Quoted(kServed)), HasSubstr("\"parameters\""));
  EXPECT_EQ(served.Threads(), 1);
}

TEST(ServeCommand, EndsWithClientsConnected) {
  for (const int signal : {SIGINT, SIGTERM}) {
    Served served;
    std::vector<std::unique_ptr<RawClient>> clients;
    for (int i = 0; i < 40; ++i) {
      clients.push_back(std::make_unique<RawClient>(served.address()));
      if (i % 2 == 0) clients.back()->Send("POST ");
    }
    EXPECT_EQ(served.End(signal), 0);
  }
}

TEST(ServeCommand, EndsAtOnceWhileItCompiles) {
  Served served;
  RawClient client(served.address());
  const std::string slow =
      "benchmark served { world.side 100000; objects { quantity 8000000; size 1 } }";
  client.Send(Post(served.address(), "check", Quoted(slow)));
  // The signal comes while it compiles, unless this machine is slow; then the request is not
  // answered either.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(served.End(SIGINT), 0);
  EXPECT_EQ(client.ReadAll(), "");
}

}  // namespace
}  // namespace cdb::tests
