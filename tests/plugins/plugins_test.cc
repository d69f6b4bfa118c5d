// Detectors from a user's shared library: valid ones run, and others are rejected with a reason.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/plugin.h"
#include "runtime/results/store.h"
#include "tests/plugins/cell_ends.h"
#include "tests/support/files.h"
#include "tests/support/folders.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

std::string PluginFile(const char* name) {
  return BuildFolder() / "tests/plugins" / (std::string(name) + ".so");
}

/// A cluster of touching balls, with a statement about detectors.
std::string ContactCluster(const std::string& use, const std::string& statement) {
  return use + "benchmark b {\n  cycles 20\n  world.side 250\n  pair_order sorted\n  " + statement +
         "\n  objects { quantity 30; linear_velocity uniform(-100, 100) }\n}\n";
}

std::string Use(const char* name) { return fmt::format("use detector \"{}\"\n", PluginFile(name)); }

TEST(Plugins, RunBesideTheCatalogue) {
  const Program program;
  fs::copy(PluginFile("faulty"), program.folder() / "mine.so");
  program.Write("used.cdb", ContactCluster("use detector \"mine.so\"\n",
                                           "detector sweep(sound, simple, dbvt)"));
  program.Write("given.cdb", ContactCluster("", "detector sweep(sound, simple, dbvt)"));
  EXPECT_EQ(program.Run({"run", "used.cdb", "-q", "-o", "used.h5"}).status, 0);
  EXPECT_EQ(program.Run({"run", "given.cdb", "-q", "-o", "given.h5", "--plugin", "mine.so"}).status,
            0);
  EXPECT_EQ(program.Run({"run", "--plugin", "mine.so", "given.cdb", "-q", "-o", "again.h5"}).status,
            0);
  EXPECT_EQ(program.Run({"plan", "used.cdb", "-o", "plan.yaml"}).status, 0);
  EXPECT_EQ(program.Run({"run", "plan.yaml", "-q", "-o", "plan.h5"}).status, 0);
  const auto used = Ends(program.folder() / "used.h5");
  EXPECT_EQ(used.at("sound").state_hash.size(), 16u);
  // Detectors that test every pair list the same pairs, whatever their library sets when it is
  // loaded. With sorted pairs, the motion is the same to the bit.
  EXPECT_EQ(used.at("sound").state_hash, used.at("simple").state_hash);
  for (const char* other : {"given.h5", "again.h5", "plan.h5"})
    EXPECT_EQ(Ends(program.folder() / other).at("sound").state_hash, used.at("sound").state_hash);
}

TEST(Plugins, OfTheCommandLineStandInWhatIsPrintedToRunOneCell) {
  const Program program;
  fs::create_directory(program.folder() / "my own");
  fs::copy(PluginFile("faulty"), program.folder() / "my own/mine.so");
  program.Write("b.cdb", ContactCluster("", "detector sweep(sound, throws_in_make)"));
  const Finished run = program.Run({"run", "b.cdb", "--plugin", "my own/mine.so"});
  EXPECT_EQ(run.status, 3);
  const std::size_t at = run.out.find("cdb run b.cdb -b b --only ");
  ASSERT_NE(at, std::string::npos) << run.out;
  const std::string command = run.out.substr(at, run.out.find('\n', at) - at);
  EXPECT_TRUE(command.ends_with(" --plugin 'my own/mine.so'")) << command;
  const Finished one = program.Shell("\"$CDB\"" + command.substr(3));
  EXPECT_EQ(one.status, 3);
  EXPECT_TRUE(Has(one.out, "out of luck")) << one.out << one.err;
}

TEST(Plugins, TimeOffTheProcessorIsSaid) {
  const Program program;
  program.Write("b.cdb", ContactCluster(Use("faulty"), "detector naps"));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 0);
  const results::ResultFile result(program.folder() / "b.h5");
  EXPECT_TRUE(Has(result.ReadText("noise_cause", {{}, 0}), "% of the time not on a processor"));
  const Finished show = program.Run({"show", "b.h5", "--all"});
  EXPECT_TRUE(Has(show.out, "noisy")) << show.out;
  EXPECT_EQ(result.ReadReal("attempts", {{}, 0}), 1);
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q", "--fresh", "--retry-noisy", "2"}).status, 0);
  EXPECT_EQ(results::ResultFile(program.folder() / "b.h5").ReadReal("attempts", {{}, 0}), 3);
}

TEST(Plugins, AreTracedToo) {
  const Program program;
  program.Write("b.cdb", ContactCluster("", "detector sound"));
  const Finished traced =
      program.Run({"trace", "b.cdb", "-o", "t.h5", "--plugin", PluginFile("faulty")});
  EXPECT_EQ(traced.status, 0) << traced.err;
  EXPECT_TRUE(Has(traced.out, "20 cycles")) << traced.out;
}

TEST(Plugins, MayListEitherBodyOfAPairFirst) {
  const Program program;
  program.Write("b.cdb", ContactCluster(Use("faulty"),
                                        "detector sweep(sound, backwards); record counts, pairs"));
  ASSERT_EQ(program.Run({"trace", "b.cdb", "-q", "-o", "t"}).status, 0);
  program.Write("on.cdb", Use("faulty") +
                              "benchmark on { trace \"t/b_detector-sound.trace.h5\"\n"
                              "record timing, counts, pairs; detector sweep(sound, backwards) }\n");
  for (const char* name : {"b", "on"}) {
    const Finished run = program.Run({"run", fmt::format("{}.cdb", name)});
    EXPECT_EQ(run.status, 0) << run.out << run.err;
    const results::ResultFile file(program.folder() / fmt::format("{}.h5", name));
    EXPECT_EQ(file.ReadText("state_hash", {{0}, 0}), file.ReadText("state_hash", {{1}, 0}));
    for (const char* series : {"pairs", "exact_pairs", "missed_pairs", "duplicate_pairs"})
      EXPECT_EQ(file.ReadSeries(series, {{0}, 0}), file.ReadSeries(series, {{1}, 0})) << series;
  }
}

TEST(Plugins, ThatMissContactsAreFoundOnPairs) {
  const Program program;
  program.Write("b.cdb", ContactCluster("", "acceleration 0"));
  ASSERT_EQ(program.Run({"trace", "b.cdb", "-q", "--pairs", "-o", "t.h5"}).status, 0);
  program.Write("on.cdb", Use("faulty") +
                              "benchmark on { trace \"t.h5\"; record timing, counts, pairs\n"
                              "narrow_phase sweep(bullet, is_blind, throws_in_find_contacts) }\n");
  const Finished run = program.Run({"run", "on.cdb"});
  EXPECT_EQ(run.status, 3) << run.out << run.err;
  const auto ends = Ends(program.folder() / "on.h5");
  EXPECT_EQ(ends.at("bullet").status, results::Status::kDone) << ends.at("bullet").message;
  EXPECT_EQ(ends.at("is_blind").status, results::Status::kDone) << ends.at("is_blind").message;
  EXPECT_TRUE(Has(ends.at("throws_in_find_contacts").message, "out of luck"));
  const results::ResultFile file(program.folder() / "on.h5");
  const auto sum = [&](const char* series, std::size_t phase) {
    double all = 0;
    for (const double value : file.ReadSeries(series, {{phase}, 0})) all += value;
    return all;
  };
  EXPECT_GT(sum("exact_contacts", 0), 0);
  EXPECT_EQ(sum("missed_contacts", 0), 0);
  EXPECT_EQ(sum("false_contacts", 0), 0);
  EXPECT_EQ(sum("exact_contacts", 1), sum("exact_contacts", 0));
  EXPECT_EQ(sum("missed_contacts", 1), sum("exact_contacts", 1));
  EXPECT_EQ(sum("contacts", 1), 0);
  EXPECT_EQ(sum("pairs", 1), sum("pairs", 0));
}

TEST(Plugins, CostTheirOwnCellsAlone) {
  const std::map<std::string, std::string> causes = {
      {"makes_nothing", "returns nothing"},
      {"throws_in_make", "out of luck"},
      {"throws_in_prepare", "Prepare: out of luck"},
      {"throws_in_find_pairs", "FindPairs of cycle 1: out of luck"},
      {"throws_escapes", "FindPairs of cycle 1: all ?[32mwell ???? of it"},
      {"rounds_up", "FindPairs of cycle 1: it changes the floating-point environment"},
      {"throws_a_number", "FindPairs of cycle 1: it throws something other than a std::exception"},
      {"aborts", "FindPairs of detector `aborts`"},
      {"segfaults", "FindPairs of detector `segfaults`"},
      {"hangs", "FindPairs of detector `hangs`"},
      {"unknown_body", "it lists the pair (0, 36)"},
      {"same_body", "it lists body 1 with itself"}};
  std::string names = "dbvt";
  for (const auto& [name, cause] : causes) names += ", " + name;
  const Program program;
  program.Write("b.cdb",
                ContactCluster(Use("faulty"), fmt::format("timeout 2; detector sweep({})", names)));
  const Finished run = program.Run({"run", "b.cdb"});
  EXPECT_EQ(run.status, 3) << run.err;
  const auto ends = Ends(program.folder() / "b.h5");
  EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone);
  for (const auto& [name, cause] : causes) {
    const CellEnd& end = ends.at(name);
    EXPECT_EQ(end.status, name == "hangs"                           ? results::Status::kTimedOut
                          : name == "aborts" || name == "segfaults" ? results::Status::kCrashed
                                                                    : results::Status::kFailed);
    EXPECT_TRUE(Has(end.message, fmt::format("detector `{}`", name))) << end.message;
    EXPECT_TRUE(Has(end.message, cause)) << end.message;
  }
}

TEST(Plugins, ContactsThatAreNoneFailTheRun) {
  const std::map<std::string, std::string> causes = {
      {"throws_in_find_contacts", "out of luck"},
      {"place_is_nan", "has a number that is not finite"},
      {"distance_is_nan", "has a number that is not finite"},
#ifdef __x86_64__
      {"flushes_denormals", "FindContacts of cycle 1: it changes the floating-point environment"},
#endif
      {"long_normal", "normal"}};
  std::string names = "bullet";
  for (const auto& [name, cause] : causes) names += ", " + name;
  const Program program;
  program.Write("b.cdb",
                ContactCluster(Use("faulty"), fmt::format("narrow_phase sweep({})", names)));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q"}).status, 3);
  const auto ends = Ends(program.folder() / "b.h5");
  EXPECT_EQ(ends.at("bullet").status, results::Status::kDone);
  for (const auto& [name, cause] : causes) {
    EXPECT_EQ(ends.at(name).status, results::Status::kFailed) << name;
    EXPECT_TRUE(Has(ends.at(name).message, fmt::format("`{}`", name))) << ends.at(name).message;
    EXPECT_TRUE(Has(ends.at(name).message, cause)) << ends.at(name).message;
  }
}

TEST(Plugins, AreRefusedWhereTheyAreNamed) {
  const Program program;
  program.Write("text.so", "not a library");
  struct Case {
    std::string library, message;
  };
  const Case cases[] = {
      {"nowhere.so", "cannot read 'nowhere.so'"},
      {"text.so", "'text.so' is not a shared library of this machine"},
      {PluginFile("other_abi"),
       fmt::format("was built for detector interface 1000000, but this cdb has {}", kDetectorAbi)},
      {PluginFile("other_build"), "was built with another library"},
      {PluginFile("no_symbol"), "has no list of detectors"},
      {PluginFile("bad_name"), "'half-open', which is not a name in .cdb files"},
      {PluginFile("taken_name"), "has a detector 'dbvt', which is also the name of one of cdb's"},
  };
  for (const Case& one : cases) {
    program.Write("b.cdb",
                  "# first\nuse detector \"" + one.library + "\"\n" + ContactCluster("", ""));
    const Finished used = program.Run({"run", "b.cdb"});
    EXPECT_EQ(used.status, 1);
    EXPECT_TRUE(Has(used.err, "b.cdb:2:14: error: ")) << used.err;
    EXPECT_TRUE(Has(used.err, one.message)) << used.err;
    program.Write("plain.cdb", ContactCluster("", ""));
    const Finished given = program.Run({"check", "plain.cdb", "--plugin", one.library});
    EXPECT_EQ(given.status, 1);
    EXPECT_TRUE(Has(given.err, one.message)) << given.err;
  }
  EXPECT_FALSE(program.Exists("b.h5"));
}

TEST(Plugins, HoldToTheirPhasesAndLimits) {
  const Program program;
  const auto refused = [&](const std::string& statement, const std::string& message) {
    program.Write("b.cdb", ContactCluster(Use("faulty"), statement));
    const Finished finished = program.Run({"check", "b.cdb"});
    EXPECT_EQ(finished.status, 1);
    EXPECT_TRUE(Has(finished.err, message)) << finished.err;
  };
  refused("detector long_normal", "write narrow_phase long_normal");
  refused("narrow_phase sound", "write detector sound");
  refused("detector sonud", "did you mean 'sound'?");
  refused("detector sweep(few, dbvt)", "'few' handles at most 10 bodies");
  refused("let sound = 3", "'sound' is a word of the language");
  program.Write("b.cdb", ContactCluster(Use("faulty"),
                                        "detector sweep(few, dbvt); skip when detector == few"));
  EXPECT_EQ(program.Run({"check", "b.cdb"}).status, 0);
}

TEST(Plugins, ThatWereChangedSinceThePlanAreRefused) {
  const Program program;
  fs::copy(PluginFile("faulty"), program.folder() / "mine.so");
  program.Write("b.cdb", ContactCluster("use detector \"mine.so\"\n", "detector sweep(sound)"));
  EXPECT_EQ(program.Run({"plan", "b.cdb", "-o", "plan.yaml"}).status, 0);
  // The library can still be loaded.
  program.Write("mine.so", program.Read("mine.so") + "changed");
  EXPECT_EQ(program.Run({"run", "plan.yaml", "-q", "-o", "old.h5"}).status, 3);
  EXPECT_TRUE(Has(Ends(program.folder() / "old.h5").at("sound").message,
                  "'mine.so' differs from the file that the plan was made with"));
  EXPECT_EQ(program.Run({"run", "b.cdb", "-q", "-o", "new.h5"}).status, 0);
  const Finished mixed = program.Run({"run", "plan.yaml", "--plugin", "mine.so"});
  EXPECT_EQ(mixed.status, 2);
  EXPECT_TRUE(Has(mixed.err, "which names its plug-ins")) << mixed.err;
}

/// Compiling a scenario does not execute its libraries, so these faults appear only when it runs.
TEST(Plugins, RunNoCodeBeforeTheRun) {
  const Program program;
  for (const char* library : {"crashes", "hangs"}) {
    program.Write("b.cdb", ContactCluster(Use(library), "detector sweep(lonely, dbvt); timeout 1"));
    for (const char* command : {"check", "plan"}) {
      const Finished looked = program.Run({command, "b.cdb"});
      EXPECT_EQ(looked.status, 0) << looked.err;
    }
    EXPECT_EQ(program.Run({"plan", "b.cdb", "--why"}).status, 0);
    EXPECT_EQ(program.Run({"run", "b.cdb", "-q", "--fresh"}).status, 3);
    const auto ends = Ends(program.folder() / "b.h5");
    EXPECT_EQ(ends.at("dbvt").status, results::Status::kDone);
    EXPECT_EQ(ends.at("lonely").status, std::string(library) == "hangs"
                                            ? results::Status::kTimedOut
                                            : results::Status::kCrashed);
    EXPECT_TRUE(Has(ends.at("lonely").message, "loading detector `lonely`"))
        << ends.at("lonely").message;
  }
}

TEST(Manifest, HoldsNamesPhasesAndLimits) {
  const auto found = detectors::ReadManifest(ReadFile(PluginFile("faulty")), "faulty.so");
  EXPECT_EQ(found.at(0), (schema::PluginDetector{"sound", "broad", 0, "", ""}));
  EXPECT_EQ(found.at(1), (schema::PluginDetector{"few", "broad", 10, "", ""}));
  EXPECT_EQ(found.back().phases, "narrow");
}

/// The file's contents are checked as untrusted input.
TEST(Manifest, SurvivesDamage) {
  const std::string bytes = ReadFile(PluginFile("other_abi"));
  const std::size_t sections = bytes.size() - std::min<std::size_t>(bytes.size(), 4096);
  std::mt19937 random(1);
  int refused = 0;
  for (int i = 0; i < 20'000; ++i) {
    std::string damaged = bytes;
    const int flips = 1 + static_cast<int>(random() % 8);
    for (int flip = 0; flip < flips; ++flip) {
      const std::size_t at = random() % 2 == 0 ? random() % 64 : sections + random() % 4096;
      damaged[std::min(at, bytes.size() - 1)] = static_cast<char>(random());
    }
    if (random() % 8 == 0) damaged.resize(random() % damaged.size());
    try {
      detectors::ReadManifest(damaged, "x.so");
    } catch (const detectors::PluginError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 10'000);
}

}  // namespace
}  // namespace cdb::tests
