#include "library/objects/solid_factory.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

#include "tests/library/meshes/test_meshes.h"
#include "tests/support/files.h"

namespace cdb::tests {
namespace {

using namespace testing;
namespace fs = std::filesystem;

class DecompositionCacheTest : public ::testing::Test {
 protected:
  DecompositionCacheTest() {
    const meshes::Mesh mesh = AngleMesh();
    form_ = objects::MakeDecomposition("m", mesh, meshes::MassPropertiesOf(mesh),
                                       meshes::Decompose(mesh, "m"));
    form_.centre.x() = -0.0;
  }

  objects::ConvexDecomposition Once(const fs::path& folder, const std::string& source = "angle") {
    const auto make = [&] {
      ++made_;
      return form_;
    };
    return objects::DecomposeOnce("m", source, make, folder);
  }
  std::vector<fs::path> Files() const {
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(cache_)) files.push_back(entry.path());
    return files;
  }

  const TemporaryFolder folder_;
  const fs::path cache_ = folder_ / "new" / "cache";
  objects::ConvexDecomposition form_;
  int made_ = 0;
};

TEST_F(DecompositionCacheTest, OneOfManyProcessesMakesIt) {
  const fs::path made = folder_ / "made";
  const auto make = [&] {
    std::ofstream(made, std::ios::app) << 'x';
    usleep(20'000);  // so that the others arrive in the meantime
    return form_;
  };
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    if (child == 0) _exit(objects::DecomposeOnce("m", "angle", make, cache_) == form_ ? 0 : 1);
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  EXPECT_EQ(ReadFile(made), "x");
  EXPECT_EQ(Files().size(), 1u) << "no lock is left";
}

TEST_F(DecompositionCacheTest, MakesOnce) {
  ASSERT_GE(form_.pieces.size(), 2u);
  EXPECT_EQ(Once(cache_), form_);
  const objects::ConvexDecomposition found = Once(cache_);
  EXPECT_EQ(found, form_);
  EXPECT_EQ(made_, 1);
  ASSERT_EQ(Files(), std::vector{cache_ / (objects::DecompositionKey("angle") + ".form")});
  // Bit for bit: stored again, it is the same file except for its seal, which depends on the
  // folder.
  const auto body = [](const fs::path& file) {
    const std::string bytes = ReadFile(file);
    return bytes.substr(0, bytes.size() - 64);
  };
  objects::DecomposeOnce(
      "m", "angle", [&] { return found; }, folder_ / "other");
  EXPECT_EQ(body(folder_ / "other" / Files()[0].filename()), body(Files()[0]));
}

TEST_F(DecompositionCacheTest, NamesAreNotKept) {
  Once(cache_);
  const objects::ConvexDecomposition other = objects::DecomposeOnce(
      "n", "angle", [] { return objects::ConvexDecomposition(); }, cache_);
  EXPECT_EQ(other.name, "n");
  EXPECT_EQ(other.pieces, form_.pieces);
}

TEST_F(DecompositionCacheTest, WhatIsFoundIsWhatIsThere) {
  Once(cache_);
  const std::string whole = ReadFile(Files()[0]);
  ASSERT_GT(whole.size(), 200u);
  // Each kind of damage is detected and repaired.
  std::vector<std::string> damages = {"", whole + "x", whole.substr(1),
                                      whole.substr(0, whole.size() - 1)};
  for (std::size_t at = 0; at < whole.size(); at += whole.size() / 23) {
    damages.push_back(whole);
    damages.back()[at] = static_cast<char>(damages.back()[at] ^ 1);
  }
  for (const std::string& damage : damages) {
    WriteFile(Files()[0], damage);
    made_ = 0;
    EXPECT_EQ(Once(cache_), form_);
    EXPECT_EQ(made_, 1);
    EXPECT_EQ(ReadFile(Files()[0]), whole);
  }
}

TEST_F(DecompositionCacheTest, ContentsOfAnotherShapeAreNotThere) {
  // With a correct digest, as after a bug in cdb.
  for (const std::string& contents : {std::string(), std::string(8, '\xff'), std::string(160, '\0'),
                                      std::string(168, '\1'), std::string(4096, '\xff')}) {
    ASSERT_TRUE(library::StoreCached(cache_, "form", objects::DecompositionKey("angle"), contents));
    made_ = 0;
    EXPECT_EQ(Once(cache_), form_);
    EXPECT_EQ(made_, 1);
  }
}

TEST_F(DecompositionCacheTest, AFolderThatCannotBeWrittenIsNoError) {
  WriteFile(folder_ / "file", "x");
  EXPECT_EQ(Once(folder_ / "file" / "cache"), form_);
  EXPECT_EQ(Once({}), form_);
  // A non-empty folder has the name of the entry, so that the rename fails.
  fs::create_directories(cache_ / (objects::DecompositionKey("angle") + ".form") / "x");
  EXPECT_EQ(Once(cache_), form_);
  EXPECT_EQ(made_, 3);
  EXPECT_EQ(Files().size(), 1u);  // no temporary file is left
}

TEST_F(DecompositionCacheTest, WhatFailsIsNotKept) {
  const auto fail = [&] {
    objects::DecomposeOnce(
        "m", "angle",
        []() -> objects::ConvexDecomposition { throw library::SceneError("no solid"); }, cache_);
  };
  EXPECT_EQ(Refusal(fail), "no solid");
  EXPECT_EQ(Refusal(fail), "no solid");
  EXPECT_TRUE(Files().empty());
}

TEST_F(DecompositionCacheTest, SourcesAreToldApart) {
  Once(cache_, "a");
  Once(cache_, "b");
  Once(cache_, "a");
  EXPECT_EQ(made_, 2);
  EXPECT_EQ(Files().size(), 2u);
  EXPECT_EQ(objects::DecompositionKey("a").size(), 64u);
}

TEST_F(DecompositionCacheTest, ProcessesAtOnceAllGetTheSame) {
  std::vector<pid_t> children;
  for (int i = 0; i < 4; ++i) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) _exit(Once(cache_) == form_ ? 0 : 1);
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_EQ(status, 0);
  }
  Once(cache_);
  EXPECT_EQ(made_, 0);
  EXPECT_EQ(Files().size(), 1u);
}

TEST_F(DecompositionCacheTest, FolderComesFromTheEnvironment) {
  std::vector<std::pair<const char*, std::string>> before;
  for (const char* name : {"CDB_CACHE", "XDG_CACHE_HOME", "HOME"})
    if (const char* value = std::getenv(name)) before.emplace_back(name, value);
  setenv("CDB_CACHE", "/a", 1);
  setenv("XDG_CACHE_HOME", "/b", 1);
  setenv("HOME", "/c", 1);
  EXPECT_EQ(library::CacheFolder(), "/a");
  unsetenv("CDB_CACHE");
  EXPECT_EQ(library::CacheFolder(), "/b/cdb");
  setenv("XDG_CACHE_HOME", "relative", 1);
  EXPECT_EQ(library::CacheFolder(), "/c/.cache/cdb");
  unsetenv("XDG_CACHE_HOME");
  unsetenv("HOME");
  EXPECT_EQ(library::CacheFolder(), "");
  for (const auto& [name, value] : before) setenv(name, value.c_str(), 1);
}

}  // namespace
}  // namespace cdb::tests
