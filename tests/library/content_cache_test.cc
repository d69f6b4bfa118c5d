#include "library/content_cache.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/files.h"

namespace cdb::tests {
namespace {

const std::string kKey(64, 'a');

namespace fs = std::filesystem;

fs::perms PermsOf(const fs::path& path) { return fs::status(path).permissions(); }

TEST(Cache, IsTheUsersOwn) {
  const TemporaryFolder folder;
  const fs::path cache = folder / "new" / "cache";
  ASSERT_TRUE(library::StoreCached(cache, "pile", kKey, "poses"));
  EXPECT_EQ(PermsOf(cache), fs::perms::owner_all);
  for (const std::string& name : FilesIn(cache))
    EXPECT_EQ(PermsOf(cache / name), fs::perms::owner_read | fs::perms::owner_write) << name;
  EXPECT_EQ(library::FindCached(cache, "pile", kKey), "poses");
  EXPECT_EQ(library::CacheFault(cache), "");
  // If others may write to the folder, nothing is found or stored, and a warning is given.
  for (const fs::perms writers : {fs::perms::group_write, fs::perms::others_write}) {
    fs::permissions(cache, fs::perms::owner_all | writers);
    EXPECT_EQ(library::FindCached(cache, "pile", kKey), std::nullopt);
    EXPECT_FALSE(library::StoreCached(cache, "pile", kKey, "other"));
    EXPECT_FALSE(library::CacheLock(cache, "pile", kKey, [] {}).IsHeld());
    EXPECT_NE(library::CacheFault(cache).find("chmod 700"), std::string::npos);
  }
  if (geteuid() == 0) {
    fs::permissions(cache, fs::perms::owner_all);
    ASSERT_EQ(chown(cache.c_str(), 12345, 12345), 0);
    EXPECT_EQ(library::FindCached(cache, "pile", kKey), std::nullopt);
    EXPECT_NE(library::CacheFault(cache).find("another user"), std::string::npos);
  }
}

TEST(Cache, TakesNoEntryThatIsDamagedOrThatOthersMayWrite) {
  const TemporaryFolder folder;
  const std::string entry = kKey + ".pile", another_key(64, 'b');
  ASSERT_TRUE(library::StoreCached(folder.path(), "pile", kKey, "poses"));
  const auto find = [&](const std::string& key) {
    return library::FindCached(folder.path(), "pile", key);
  };
  const std::string good = ReadFile(folder / entry);
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bent = good;
    bent[i] = static_cast<char>(bent[i] ^ 1);
    WriteFile(folder / entry, bent);
    EXPECT_EQ(find(kKey), std::nullopt) << "byte " << i;
  }
  WriteFile(folder / (another_key + ".pile"), good);
  EXPECT_EQ(find(another_key), std::nullopt) << "bound to another key";
  WriteFile(folder / (kKey + ".hulls"), good);
  EXPECT_EQ(library::FindCached(folder.path(), "hulls", kKey), std::nullopt) << "of another kind";
  WriteFile(folder / entry, good);
  EXPECT_EQ(find(kKey), "poses");
  fs::permissions(folder / entry, fs::perms::others_write, fs::perm_options::add);
  EXPECT_EQ(find(kKey), std::nullopt) << "others may write to it";
  fs::rename(folder / entry, folder / "real");
  fs::permissions(folder / "real", fs::perms::others_write, fs::perm_options::remove);
  fs::create_symlink("real", folder / entry);
  EXPECT_EQ(find(kKey), std::nullopt) << "a link";
}

TEST(Cache, AKilledWriterLeavesNothingThatGrows) {
  const TemporaryFolder folder;
  WriteFile(folder / (kKey + ".pile.tmp"), "half of someth");
  ASSERT_TRUE(library::StoreCached(folder.path(), "pile", kKey, "poses"));
  EXPECT_EQ(library::FindCached(folder.path(), "pile", kKey), "poses");
  EXPECT_EQ(FilesIn(folder.path()), (std::vector<std::string>{kKey + ".pile"}));
}

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
  EXPECT_EQ(FilesIn(folder.path()), (std::vector<std::string>{kKey + ".pile"}))
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
