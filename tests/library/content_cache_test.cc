#include "library/content_cache.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <string>
#include <thread>

#include "tests/support/files.h"

namespace cdb::tests {
namespace {

const std::string kKey(64, 'a');

TEST(CacheLock, OneMakesAnEntryAndTheOthersFindIt) {
  const TemporaryFolder folder;
  std::atomic<bool> is_waiting = false;
  std::optional<std::string> found;
  std::thread other;
  {
    const library::CacheLock first(folder.path(), "pile", kKey, [] { FAIL() << "nobody has it"; });
    EXPECT_TRUE(first.IsHeld());
    other = std::thread([&] {
      const library::CacheLock second(folder.path(), "pile", kKey, [&] { is_waiting = true; });
      found = library::FindCached(folder.path(), "pile", kKey);
    });
    while (!is_waiting) std::this_thread::yield();
    EXPECT_TRUE(library::StoreCached(folder.path(), "pile", kKey, "poses"));
  }
  other.join();
  EXPECT_EQ(found, "poses");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1)
      << "the entry and no lock";
}

TEST(CacheLock, OtherEntriesAreFree) {
  const TemporaryFolder folder;
  const auto fail = [] { FAIL(); };
  const library::CacheLock first(folder.path(), "pile", kKey, fail);
  const library::CacheLock second(folder.path(), "pile", std::string(64, 'b'), fail);
  EXPECT_TRUE(second.IsHeld());
}

TEST(CacheLock, AProcessThatDiesLetsGo) {
  const TemporaryFolder folder;
  const pid_t child = fork();
  if (child == 0) {
    const library::CacheLock lock(folder.path(), "pile", kKey, [] {});
    _exit(lock.IsHeld() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  const library::CacheLock lock(folder.path(), "pile", kKey, [] { FAIL() << "nobody has it"; });
  EXPECT_TRUE(lock.IsHeld());
}

TEST(CacheLock, WithoutAFolderNothingIsLocked) {
  const library::CacheLock lock({}, "pile", kKey, [] { FAIL(); });
  EXPECT_FALSE(lock.IsHeld());
  const library::CacheLock nowhere("/dev/null/cache", "pile", kKey, [] { FAIL(); });
  EXPECT_FALSE(nowhere.IsHeld());
}

}  // namespace
}  // namespace cdb::tests
