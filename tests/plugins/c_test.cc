// Detectors from shared libraries in C.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "library/detectors/detector_c.h"
#include "library/detectors/plugin.h"
#include "runtime/results/store.h"
#include "tests/plugins/cell_ends.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

std::string LibraryInC(const char* name) {
  return BuildFolder() / "tests/plugins" / (std::string(name) + ".so");
}

std::string Moving(const std::string& statements, const std::string& type = "sphere") {
  return fmt::format(
      "use detector \"{}\"\nbenchmark b {{\n  cycles 40\n  world.side 250\n  pair_order sorted\n"
      "  {}\n  objects {{ quantity 40; type {}; linear_velocity uniform(-100, 100) }}\n}}\n",
      LibraryInC("in_c"), statements, type);
}

TEST(PluginsInC, MoveObjectsAsOthersDo) {
  const Program program;
  program.Write("b.cdb", Moving("detector sweep(c_all, c_changes, c_balls, c_pieces, grid)\n"
                                "narrow_phase bullet; record counts, stability, pairs",
                                "any(sphere, cuboid, tetrahedron, torus)"));
  const Finished run = program.Run({"run", "b.cdb", "-q"});
  EXPECT_EQ(run.status, 0) << run.out << run.err;
  const auto ends = Ends(program.folder() / "b.h5");
  for (const char* name : {"c_all", "c_changes", "c_balls", "c_pieces"}) {
    EXPECT_EQ(ends.at(name).status, results::Status::kDone) << ends.at(name).message;
    EXPECT_EQ(ends.at(name).state_hash, ends.at("grid").state_hash) << name;
  }
  const Finished verify = program.Run({"verify", "b.cdb"});
  EXPECT_EQ(verify.status, 0) << verify.out << verify.err;
}

TEST(PluginsInC, FindContactsByShapesAndPoses) {
  const Program program;
  program.Write("b.cdb", Moving("detector c_balls; narrow_phase sweep(c_balls, bullet)\n"
                                "record counts, stability, pairs",
                                "any(sphere, cuboid)"));
  const Finished verify = program.Run({"verify", "b.cdb"});
  EXPECT_EQ(verify.status, 0) << verify.out << verify.err;
  EXPECT_TRUE(Has(verify.out, "c_balls   narrow")) << verify.out;
}

TEST(PluginsInC, FailTheirOwnRunsWithAReason) {
  const Program program;
  program.Write("b.cdb", Moving("detector sweep(dbvt, c_fails, c_arrayless, c_nothing)"));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 3);
  const auto ends = Ends(program.folder() / "b.h5");
  EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone);
  const auto message = [&](const char* name) { return ends.at(name).message; };
  EXPECT_TRUE(Has(message("c_fails"), "FindPairs of cycle 1: out of luck in C"));
  EXPECT_TRUE(Has(message("c_arrayless"), "it returns a size without an array"));
  EXPECT_TRUE(Has(message("c_nothing"), "its function returns nothing"));
  program.Write("few.cdb", Moving("detector c_few"));
  EXPECT_TRUE(Has(program.Run({"check", "few.cdb"}).err, "at most 10"));
}

TEST(PluginsInC, AreRefusedInWords) {
  const Program program;
  const auto refusal = [&](const char* library, const char* command) {
    program.Write("b.cdb", fmt::format("use detector \"{}\"\nbenchmark b {{ detector c_none }}\n",
                                       LibraryInC(library)));
    const Finished run = program.Run({command, "b.cdb"});
    EXPECT_NE(run.status, 0);
    return run.out + run.err;
  };
  EXPECT_TRUE(Has(refusal("other_c_abi", "check"),
                  fmt::format("was built for C detector interface 1000000, but this cdb has {}; "
                              "rebuild it with this cdb's cdb/detector_c.h",
                              CDB_C_ABI)));
  // Seen only when it is loaded.
  EXPECT_TRUE(Has(refusal("row_without_function", "run"), "without name, line, phase or function"));
}

TEST(PluginsInC, SayBeforeAndAfterLoadingTheSame) {
  const std::string path = LibraryInC("in_c");
  std::vector<std::string> names;
  for (const auto& loaded : detectors::LoadPlugin(path)) names.push_back(loaded.name);
  std::vector<std::string> read;
  for (const auto& detector : detectors::ReadManifest(ReadFile(path), path))
    read.push_back(detector.name);
  EXPECT_EQ(names, read);
  EXPECT_EQ(names.size(), 8u);
}

}  // namespace
}  // namespace cdb::tests
