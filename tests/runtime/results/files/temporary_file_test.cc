// Temporary files: locks determine which are in use, and only files are ever overwritten.
#include "runtime/results/files/safe_file.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/results/store.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using files::TemporaryFile;
using testing::ElementsAre;
using testing::HasSubstr;

std::string HostPart() {
  std::array<char, 256> host = {};
  EXPECT_EQ(gethostname(host.data(), host.size() - 1), 0);
  return std::string(".") + host.data() + ".";
}

/// Runs `body` in a process that is killed as soon as it returns.
template <typename Body>
void InKilledProcess(Body body) {
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    body();
    raise(SIGKILL);
  }
  ASSERT_EQ(waitpid(child, nullptr, 0), child);
}

TEST(StaleTemporaries, AreThoseThatNobodyHasLocked) {
  const std::string run = "0123456789abcdef.h5", here = run + HostPart();
  const std::vector<std::string> kept = {run,           run + ".tmp", here + "x.tmp",
                                         here + ".tmp", here + "17",  run + ".elsewhere.17.tmp",
                                         "plan.yaml"};
  const TemporaryFolder folder;
  for (const std::string& name : kept) WriteFile(folder / name, "x");
  // The id of a running process, or of none, does not matter.
  for (const std::string& number : {std::to_string(getpid()), std::string("999999999")})
    WriteFile(folder / (here + number + ".tmp"), "x");
  files::RemoveStaleTemporaries(folder.path());
  EXPECT_THAT(FilesIn(folder.path()), testing::UnorderedElementsAreArray(kept));
  EXPECT_THROW(files::RemoveStaleTemporaries(folder / "nowhere"), files::StoreError);
}

/// In two containers with the same host name, equal ids mean different processes.
TEST(StaleTemporaries, OfALivingProcessStayWhateverTheirNumber) {
  const TemporaryFolder folder;
  const fs::path out = folder / "out.h5";
  const fs::path of_nobody = out.string() + HostPart() + "999999999.tmp";
  WriteFile(of_nobody, "x");
  const int fd = open(of_nobody.c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(flock(fd, LOCK_SH), 0);
  files::RemoveStaleTemporaries(folder.path());
  files::RemoveStaleTemporariesBeside(out);
  EXPECT_TRUE(fs::exists(of_nobody));
  // This file stands for one of the same name that is in use elsewhere: it is not overwritten
  // either.
  const fs::path mine = out.string() + HostPart() + std::to_string(getpid()) + ".tmp";
  WriteFile(mine, "theirs");
  TemporaryFile file(out);
  EXPECT_NE(file.path(), mine);
  EXPECT_EQ(ReadFile(mine), "theirs");
  InKilledProcess([&] { files::RemoveStaleTemporaries(folder.path()); });
  EXPECT_TRUE(fs::exists(file.path()));
  EXPECT_TRUE(fs::exists(of_nobody));
  close(fd);
  InKilledProcess([&] { files::RemoveStaleTemporaries(folder.path()); });
  EXPECT_TRUE(fs::exists(file.path()));
  EXPECT_FALSE(fs::exists(of_nobody));
}

TEST(StaleTemporaries, OfKilledWritersGoWithTheNextWriter) {
  const TemporaryFolder folder;
  for (int i = 0; i < 3; ++i)
    InKilledProcess([&] { new TemporaryFile(folder / "out.html"); });  // NOLINT: it is killed
  EXPECT_EQ(FilesIn(folder.path()).size(), 3u);
  files::WriteWhole("text", folder / "out.html");
  EXPECT_THAT(FilesIn(folder.path()), ElementsAre("out.html"));
}

TEST(TemporaryFile, IsRemovedUnlessPublished) {
  const TemporaryFolder folder;
  { const TemporaryFile file(folder / "out.h5"); }
  EXPECT_TRUE(FilesIn(folder.path()).empty());
  TemporaryFile file(folder / "out.h5");
  ASSERT_EQ(write(file.fd(), "x", 1), 1);
  file.Publish();
  EXPECT_EQ(ReadFile(folder / "out.h5"), "x");
}

TEST(TemporaryFile, FollowsLinks) {
  const TemporaryFolder folder, other;
  WriteFile(other / "old.h5", "old");
  fs::create_symlink(other / "old.h5", folder / "link.h5");
  fs::create_symlink("link.h5", folder / "second.h5");
  fs::create_symlink(other / "new.h5", folder / "dangling.h5");
  files::WriteWhole("1", folder / "second.h5");
  files::WriteWhole("2", folder / "dangling.h5");
  EXPECT_EQ(ReadFile(other / "old.h5"), "1");
  EXPECT_EQ(ReadFile(other / "new.h5"), "2");
  for (const char* name : {"link.h5", "second.h5", "dangling.h5"})
    EXPECT_TRUE(fs::is_symlink(folder / name)) << name;
  EXPECT_THAT(FilesIn(other.path()), ElementsAre("new.h5", "old.h5"));
  fs::create_symlink("loop.h5", folder / "loop.h5");
  EXPECT_THROW(files::WriteWhole("3", folder / "loop.h5"), files::StoreError);
}

TEST(TemporaryFile, WritesOverNothingButFiles) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_symlink("/dev/null", folder / "null");
  const auto refusal = [&](const fs::path& path) -> std::string {
    try {
      files::WriteWhole("x", path);
    } catch (const files::StoreError& error) {
      return error.what();
    }
    return {};
  };
  EXPECT_THAT(refusal(folder / "pipe"), HasSubstr("it is a pipe, not a file"));
  EXPECT_THAT(refusal(folder / "null"), HasSubstr("it is a device, not a file"));
  EXPECT_THAT(refusal(folder.path()), HasSubstr("Is a directory"));
  EXPECT_THAT(refusal(folder / "no" / "x"), HasSubstr("its folder is not there"));
  EXPECT_THAT(FilesIn(folder.path()), ElementsAre("null", "pipe"));
}

}  // namespace
}  // namespace cdb::tests
