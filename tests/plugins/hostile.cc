// Detectors that each attempt something that a confined worker must deny, and then do their work.
// If the attempt is not denied, the run fails with the word `allowed`.
#include <fcntl.h>
#include <signal.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

#include "library/detectors/detector.h"
#include "tests/plugins/every_pair.h"

namespace {

using namespace cdb;

/// Makes an attempt; true if it was not denied.
using Attempt = bool (*)();

template <Attempt kTry>
class Tries : public EveryPair {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    if (kTry()) throw std::runtime_error("allowed");
    EveryPair::FindPairs(scene, pairs);
  }
};

bool OpensASocket() {
  return socket(AF_INET, SOCK_STREAM, 0) >= 0 || socket(AF_UNIX, SOCK_DGRAM, 0) >= 0;
}
bool MakesAFile() { return open("escaped", O_WRONLY | O_CREAT, 0600) >= 0; }
bool WritesAFile() { return open("victim", O_WRONLY) >= 0 || truncate("victim", 0) == 0; }
bool RemovesAFile() { return unlink("victim") == 0 || rename("victim", "escaped") == 0; }
bool ChangesRights() { return chmod("victim", 0777) == 0 || mkdir("escaped", 0700) == 0; }
bool Executes() { return execl("/bin/true", "true", nullptr) == 0; }
bool StartsAProcess() {
  const pid_t child = fork();
  if (child == 0) {
    setsid();
    _exit(0);
  }
  if (child > 0) waitpid(child, nullptr, 0);
  return child > 0;
}
bool LeavesItsGroup() { return setsid() > 0 || setpgid(0, getpgid(getppid())) == 0; }
bool SignalsTheRunner() { return kill(getppid(), 0) == 0 || kill(-1, 0) == 0; }
bool TracesTheRunner() { return ptrace(PTRACE_SEIZE, getppid(), nullptr, nullptr) == 0; }
bool RaisesItsLimits() {
  rlimit limit = {};
  return getrlimit(RLIMIT_NOFILE, &limit) != 0 || setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

/// Operations that must still work.
bool ThreadsAndReading() {
  std::vector<int> sums(4);
  std::vector<std::thread> threads;
  for (int& sum : sums)
    threads.emplace_back([&sum] {
      for (int i = 0; i < 1000; ++i) sum += i;
    });
  for (std::thread& thread : threads) thread.join();
  std::string line;
  std::getline(std::ifstream("victim"), line);
  for (const int sum : sums)
    if (sum != 499500) return true;
  return line != "as it was";
}

/// Overwrites the header of the next block of the heap.
class WritesPastItsPairs : public EveryPair {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    EveryPair::FindPairs(scene, pairs);
    if (pairs.capacity() < 8) pairs.reserve(8);
    std::memset(static_cast<void*>(pairs.data() + pairs.capacity()), 0x41, 64);
  }
};

class CrashesInItsDestructor : public EveryPair {
 public:
  ~CrashesInItsDestructor() override { raise(SIGSEGV); }
};

/// Allocates 64 GiB without touching them.
class TakesMemory : public EveryPair {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (int i = 0; i < 64; ++i) taken_.push_back(new char[std::size_t{1} << 30]);
    EveryPair::FindPairs(scene, pairs);
  }

 private:
  std::vector<char*> taken_;
};

template <typename T>
Detector* Make(const Options&) {
  return new T;
}

constexpr DetectorEntry kEntries[] = {
    {"opens_a_socket", "", kBroad, 0, Make<Tries<OpensASocket>>},
    {"makes_a_file", "", kBroad, 0, Make<Tries<MakesAFile>>},
    {"writes_a_file", "", kBroad, 0, Make<Tries<WritesAFile>>},
    {"removes_a_file", "", kBroad, 0, Make<Tries<RemovesAFile>>},
    {"changes_rights", "", kBroad, 0, Make<Tries<ChangesRights>>},
    {"executes", "", kBroad, 0, Make<Tries<Executes>>},
    {"starts_a_process", "", kBroad, 0, Make<Tries<StartsAProcess>>},
    {"leaves_its_group", "", kBroad, 0, Make<Tries<LeavesItsGroup>>},
    {"signals_the_runner", "", kBroad, 0, Make<Tries<SignalsTheRunner>>},
    {"traces_the_runner", "", kBroad, 0, Make<Tries<TracesTheRunner>>},
    {"raises_its_limits", "", kBroad, 0, Make<Tries<RaisesItsLimits>>},
    {"threads_and_reading", "", kBroad, 0, Make<Tries<ThreadsAndReading>>},
    {"writes_past_its_pairs", "", kBroad, 0, Make<WritesPastItsPairs>},
    {"crashes_in_its_destructor", "", kBroad, 0, Make<CrashesInItsDestructor>},
    {"takes_memory", "", kBroad, 0, Make<TakesMemory>},
};

}  // namespace

CDB_DETECTORS(kEntries)
