// Detectors that each attempt something that a confined worker must deny, and then do their work.
// If the attempt is not denied, the run fails with the word `allowed`.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "library/detectors/detector.h"
#include "runtime/protocol/recording.h"
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
/// Memory that does not count towards the limit.
bool SharesMemory() {
  const auto maps = [](int flags) {
    return mmap(nullptr, 1 << 20, PROT_READ | PROT_WRITE, flags | MAP_ANONYMOUS, -1, 0) !=
           MAP_FAILED;
  };
  return memfd_create("escaped", 0) >= 0 || maps(MAP_SHARED) || maps(MAP_PRIVATE | MAP_GROWSDOWN);
}
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

/// True if a descriptor of the recording is open, or one whose file can grow without being counted.
bool HoldsDescriptors() {
  for (int fd = 3; fd < 64; ++fd) {
    char name[64] = {};
    const std::string link = "/proc/self/fd/" + std::to_string(fd);
    if (readlink(link.c_str(), name, sizeof name - 1) < 0) continue;
    if (std::strstr(name, "cdb-recording") != nullptr) return true;
    if (std::strstr(name, "cdb-run") != nullptr && ftruncate(fd, 1 << 20) == 0) return true;
  }
  return false;
}

/// Overwrites the measurements of earlier cycles in the worker's memory.
class OverwritesItsRecording : public EveryPair {
 public:
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    EveryPair::FindPairs(scene, pairs);
    std::ifstream maps("/proc/self/maps");
    for (std::string line; std::getline(maps, line);) {
      if (line.find("cdb-recording") == std::string::npos) continue;
      char* end = nullptr;
      const auto from = std::strtoull(line.c_str(), &end, 16);
      const auto to = std::strtoull(end + 1, nullptr, 16);
      constexpr std::size_t kHeader = sizeof(protocol::RecordingHeader);
      std::memset(reinterpret_cast<char*>(from) + kHeader, 0xff, to - from - kHeader);
    }
  }
};

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
    {"shares_memory", "", kBroad, 0, Make<Tries<SharesMemory>>},
    {"holds_descriptors", "", kBroad, 0, Make<Tries<HoldsDescriptors>>},
    {"overwrites_its_recording", "", kBroad, 0, Make<OverwritesItsRecording>},
    {"raises_its_limits", "", kBroad, 0, Make<Tries<RaisesItsLimits>>},
    {"threads_and_reading", "", kBroad, 0, Make<Tries<ThreadsAndReading>>},
    {"writes_past_its_pairs", "", kBroad, 0, Make<WritesPastItsPairs>},
    {"crashes_in_its_destructor", "", kBroad, 0, Make<CrashesInItsDestructor>},
    {"takes_memory", "", kBroad, 0, Make<TakesMemory>},
};

}  // namespace

CDB_DETECTORS(kEntries)
