// Summaries of detectors: the wrong ones first, then the cost of each.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "compiler/schema/catalogue.h"
#include "compiler/yaml/plan_yaml.h"
#include "runtime/figures/conclusions.h"
#include "runtime/figures/model.h"
#include "runtime/printers/show.h"
#include "tests/runtime/results/store_fixture.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

constexpr std::uint64_t kCycles = 3;
/// The title of every made-up plan.
const std::string kTitle = "A plan for tests \xE2\x80\x93 \xC2\xB5";

/// A made-up run: values of its series, the same in every cycle or one for each.
class Made {
 public:
  explicit Made(const plan::Run& run) : fake_(run) {
    for (const char* name : {"missed_pairs", "phantom_pairs", "duplicate_pairs", "missed_contacts",
                             "unlisted_contacts", "bullet_missed_contacts", "uncompared_contacts",
                             "bullet_uncompared_contacts"})
      Ints(name, {0, 0, 0});
    Ints("exact_pairs", {10, 10, 10});
    for (const char* name : {"exact_contacts", "bullet_contacts"}) Ints(name, {7, 7, 7});
    Reals("depth_error", {1e-5, NAN, 3e-5});
    Reals("normal_error", {NAN, NAN, NAN});
    fake_.result.message = fake_.result.omitted = fake_.result.decisions = "";
    fake_.result.scalars.peak_rss_bytes = 8e6;
    fake_.result.scalars.harness_ns = NAN;
  }
  void Ints(const char* name, const std::vector<std::int32_t>& values) { Put(name, values); }
  void Reals(const char* name, const std::vector<double>& values) { Put(name, values); }
  /// Sets the time of detect in each cycle, ns; and of every phase, because the others are not
  /// used.
  void Detect(const std::vector<double>& ns) {
    std::vector<double> all;
    for (std::size_t phase = 0; phase < protocol::kPhaseCount; ++phase)
      all.insert(all.end(), ns.begin(), ns.end());
    Put("duration", all);
  }
  results::RunResult& result() { return fake_.result; }

 private:
  template <typename T>
  void Put(const char* name, const std::vector<T>& values) {
    for (auto& [series, bytes] : fake_.result.series) {
      if (series->name != name) continue;
      ASSERT_EQ(bytes.size(), values.size() * sizeof(T)) << name;
      auto& memory = memory_[name];
      memory.resize(bytes.size());
      std::memcpy(memory.data(), values.data(), bytes.size());
      bytes = memory;
    }
  }

  FakeResult fake_;
  std::map<std::string, std::vector<std::byte>> memory_;
};

plan::Plan PlanOf(std::vector<plan::Axis> axes, schema::WordList record) {
  return MakePlan(std::move(axes), 1, {.cycles = kCycles, .record = std::move(record)});
}

/// A plan that can be read back.
plan::Plan RealPlanOf(const schema::WordList& record, const std::vector<std::string>& detectors) {
  const Program program;
  program.Write("fixture.cdb",
                fmt::format("benchmark fixture \"{}\" {{ cycles {}; record {}; warmup 0\n"
                            "objects {{ quantity sweep(10, 20, 40) }} detector sweep({}) }}",
                            kTitle, kCycles, fmt::join(record, ", "), fmt::join(detectors, ", ")));
  const Finished planned = program.Run({"plan", "fixture.cdb", "-o", "plan.yaml"});
  EXPECT_EQ(planned.status, 0) << planned.err;
  return yaml::FromYaml(program.Read("plan.yaml"), "plan.yaml");
}

/// Returns `use(file)` for the file of a plan whose runs `settle` makes.
template <typename Use>
auto WithFile(const plan::Plan& plan, const std::function<void(const plan::Run&, Made&)>& settle,
              Use use) {
  const TemporaryFolder folder;
  for (const plan::Run& run : plan.runs) {
    Made made(run);
    settle(run, made);
    WriteRun(plan, run, made.result(), TestProvenance(), folder.path());
  }
  journal::Merge(plan, TestProvenance(), folder.path(), folder / "out.h5");
  return use(results::ResultFile(folder / "out.h5"));
}

std::string IdOf(const plan::Plan& plan, std::size_t run) { return plan.runs[run].id; }

TEST(Verify, TellsTheWrongFirst) {
  const plan::Plan plan =
      PlanOf({TextAxis("detector", {"simple", "dbvt", "twice", "broken", "null"}),
              NumberAxis("quantity", {10, 20})},
             {"pairs"});
  const printers::VerifyText verified = WithFile(
      plan,
      [](const plan::Run& run, Made& made) {
        if (run.at[0] == 1) made.Ints("phantom_pairs", {0, 2, 1});
        if (run.at[0] == 2) made.Ints("duplicate_pairs", {0, 0, 4});
        if (run.at[0] == 3 && run.at[1] == 1) {
          made.result().status = results::Status::kCrashed;
          made.result().n_cycles = 0;
          made.result().message = "ended by signal 11 (SIGSEGV)";
        }
        if (run.at[0] == 4) made.Ints("missed_pairs", {0, run.at[1] == 0 ? 0 : 3, 10});
      },
      [](const results::ResultFile& file) {
        return printers::VerifyTable(file, {"sap is not built"});
      });
  EXPECT_FALSE(verified.is_good);
  EXPECT_EQ(verified.text, kTitle +
                               R"(
  detector  phase   points  cycles    compared  missed  phantom  duplicate  depth error  normal error  verdict
  ------------------------------------------------------------------------------------------------------------------------
  null      broad        2       6    60 of 60      23        0          0            -             -  wrong: misses pairs
  broken    broad        2       3    30 of 30       0        0          0            -             -  failed: 1 of 2
  simple    broad        2       6    60 of 60       0        0          0            -             -  exact
  dbvt      broad        2       6    60 of 60       0        6          0            -             -  superset
  twice     broad        2       6    60 of 60       0        0          8            -             -  lists pairs twice
  bullet    narrow       9      27  189 of 189       0        -          -      2.0e-05             -  misses none

  null misses pairs from cycle 2 on, at detector null, quantity 10, rep 0
    cdb run fixture.cdb -b fixture --only )" +
                               IdOf(plan, 8) + R"(
  broken crashed at detector broken, quantity 20, rep 0: ended by signal 11 (SIGSEGV)
    cdb run fixture.cdb -b fixture --only )" +
                               IdOf(plan, 7) + R"(
  twice lists pairs twice from cycle 2 on, at detector twice, quantity 10, rep 0
    cdb run fixture.cdb -b fixture --only )" +
                               IdOf(plan, 4) + "\n  Omitted: sap is not built.\n");
}

TEST(Verify, IsGoodWhereNoDetectorMissesAnything) {
  const plan::Plan plan = PlanOf({TextAxis("detector", {"simple", "dbvt"})}, {"pairs"});
  using Counts = std::map<const char*, std::vector<std::int32_t>>;
  const auto judge = [&](const Counts& counts) {
    return WithFile(
        plan,
        [&](const plan::Run&, Made& made) {
          for (const auto& [series, values] : counts) made.Ints(series, values);
        },
        [](const results::ResultFile& file) { return printers::VerifyTable(file, {}); });
  };
  EXPECT_TRUE(judge({{"phantom_pairs", {9, 9, 9}}}).is_good);
  EXPECT_TRUE(judge({{"duplicate_pairs", {1, 0, 0}}}).is_good);
  EXPECT_FALSE(judge({{"missed_pairs", {0, 0, 1}}}).is_good);
  EXPECT_FALSE(judge({{"missed_contacts", {0, 1, 0}}, {"bullet_contacts", {0, 0, 0}}}).is_good);
  EXPECT_FALSE(judge({{"missed_contacts", {0, 2, 0}},
                      {"bullet_missed_contacts", {0, 1, 0}},
                      {"bullet_contacts", {2, 2, 2}}})
                   .is_good)
      << "one of the two is the detector's";
  EXPECT_TRUE(
      judge({{"missed_contacts", {0, 1, 0}}, {"bullet_missed_contacts", {0, 1, 0}}}).is_good)
      << "no detector misses anything";
}

/// The row of a phase in the table of a run with these counts, with single spaces.
std::string RowOf(const char* phase,
                  const std::map<const char*, std::vector<std::int32_t>>& counts) {
  const std::string text = WithFile(
      PlanOf({TextAxis("detector", {"grid"})}, {"pairs"}),
      [&](const plan::Run&, Made& made) {
        for (const auto& [series, values] : counts) made.Ints(series, values);
      },
      [](const results::ResultFile& file) { return printers::VerifyTable(file, {}).text; });
  const std::size_t at = text.find(phase);
  EXPECT_NE(at, text.npos) << text;
  const std::size_t begin = text.rfind('\n', at) + 1;
  std::istringstream words(text.substr(begin, text.find('\n', at) - begin));
  std::string row;
  for (std::string word; words >> word;) row += (row.empty() ? "" : " ") + word;
  return row;
}

TEST(Verify, SaysHowMuchWasCompared) {
  EXPECT_EQ(RowOf("narrow",
                  {{"uncompared_contacts", {2, 0, 0}}, {"bullet_uncompared_contacts", {2, 0, 0}}}),
            "bullet narrow 1 3 21 of 23 0 - - 2.0e-05 - misses none");
  EXPECT_EQ(RowOf("narrow", {{"exact_contacts", {0, 0, 0}}, {"bullet_contacts", {0, 0, 0}}}),
            "- narrow 1 3 0 of 0 - - - 2.0e-05 - nothing compared");
  EXPECT_EQ(RowOf("broad", {{"exact_pairs", {0, 0, 0}}}),
            "grid broad 1 3 0 of 0 - - - - - nothing compared");
  EXPECT_EQ(RowOf("broad", {{"exact_pairs", {-1, -1, -1}}}),
            "grid broad 1 0 0 of 0 - - - - - nothing compared");
}

TEST(Verify, GivesTheNarrowPhaseARowOfItsOwn) {
  EXPECT_EQ(
      RowOf("narrow", {{"missed_contacts", {0, 3, 0}}, {"bullet_missed_contacts", {0, 3, 0}}}),
      "bullet narrow 1 3 21 of 21 3 - - 2.0e-05 - Bullet misses contacts");
  EXPECT_EQ(RowOf("broad", {{"missed_contacts", {0, 3, 0}}, {"bullet_missed_contacts", {0, 3, 0}}}),
            "grid broad 1 3 30 of 30 0 0 0 - - exact");
  // The pair of one contact was not listed: no narrow phase was asked for it.
  EXPECT_EQ(RowOf("narrow", {{"bullet_contacts", {0, 0, 0}},
                             {"missed_contacts", {0, 3, 0}},
                             {"unlisted_contacts", {0, 1, 0}}}),
            "grid narrow 1 3 20 of 20 2 - - 2.0e-05 - wrong: misses contacts");
  const std::map<const char*, std::vector<std::int32_t>> both = {
      {"bullet_contacts", {2, 2, 2}},
      {"missed_contacts", {0, 3, 0}},
      {"bullet_missed_contacts", {0, 3, 0}}};
  EXPECT_EQ(RowOf("grid      narrow", both),
            "grid narrow 1 3 15 of 15 0 - - 2.0e-05 - misses none");
  EXPECT_EQ(RowOf("bullet    narrow", both),
            "bullet narrow 1 3 6 of 6 3 - - - - Bullet misses contacts");
}

/// The summary of three detectors at three quantities; detect grows as quantity, as quantity^2, and
/// not at all.
std::string Shown(const schema::WordList& record, const std::vector<std::string>& detectors,
                  const std::vector<std::string>& by = {},
                  const std::function<void(const plan::Run&, Made&)>& more = {}) {
  const plan::Plan plan = RealPlanOf(record, detectors);
  return WithFile(
      plan,
      [&](const plan::Run& run, Made& made) {
        const double n = std::get<double>(plan.axes[0].values[run.at[0]]);
        const double ns = std::pow(n, run.at[1] == 0 ? 1 : run.at[1] == 1 ? 2 : 0);
        made.Detect({ns, ns, 100 * ns});
        if (more) more(run, made);
      },
      [&](const results::ResultFile& file) { return printers::Show(file, {by}).text; });
}

TEST(ShowDetectors, SetsTheWorstCycleBesideTheMeanAndFitsGrowth) {
  const std::string text = Shown({"timing", "pairs"}, {"sap", "dbvt", "simple"}, {"detector"},
                                 [](const plan::Run& run, Made& made) {
                                   if (run.at[1] == 1) made.Ints("phantom_pairs", {0, 1, 2});
                                 });
  EXPECT_NE(text.find("\nDetectors: a cycle's detect, ns\n"
                      "  detector  cells   mean   worst  missed  phantom  peak rss, MB\n"
                      "  -------------------------------------------------------------\n"
                      "  sap           3    793    4000       0        0          8.00\n"
                      "  dbvt          3  23800  160000       0        9          8.00\n"
                      "  simple        3   34.0     100       0        0          8.00\n"
                      "  Mean over cycles and cells; no interval: one repeat.\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\nGrowth over quantity: p of detect ~ objects^p\n"
                      "  detector     p  95 % interval\n"
                      "  -----------------------------\n"
                      "  sap       1.00   1.00 .. 1.00\n"
                      "  dbvt      2.00   2.00 .. 2.00\n"
                      "  simple    0.00   0.00 .. 0.00\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\nPairs listed that do not overlap: dbvt 9 beside 90.\n"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("WRONG"), std::string::npos) << text;
}

TEST(ShowDetectors, NamesTheNarrowPhaseThatMissesContacts) {
  const std::string text =
      Shown({"timing", "pairs"}, {"sap", "dbvt"}, {}, [](const plan::Run& run, Made& made) {
        if (run.at[1] == 1) made.Ints("missed_contacts", {0, 1, 1});
        if (run.at[1] == 1) made.Ints("bullet_missed_contacts", {0, 1, 1});
      });
  EXPECT_NE(text.find("\nOverlaps without a contact: bullet 6 of 126 compared.\n"),
            std::string::npos)
      << text;
}

TEST(ShowDetectors, SaysThatTheyListDifferentPairs) {
  const auto answer = [](const std::string& order, const std::string& decisions) {
    return WithFile(
        RealPlanOf({"timing", "counts; pair_order " + order}, {"dbvt", "grid"}),
        [&](const plan::Run& run, Made& made) {
          made.Detect({100, 100, 100});
          made.Ints("pairs", run.at[1] == 0 ? std::vector<std::int32_t>{90, 100, 110}
                                            : std::vector<std::int32_t>{7, 10, 13});
          made.result().decisions = decisions;
        },
        [](const results::ResultFile& file) {
          for (const figures::Conclusion& of : figures::Conclusions(figures::Model(file)))
            if (of.kind == "detect") return of.answer;
          return std::string();
        });
  };
  const std::string different =
      " They list different pairs: dbvt 100 and grid 10.0 at quantity 10.";
  const std::string remedy =
      " Bullet's own pair every object with every wall; `omit auto, wall_pairs` leaves the "
      "pairs out that no box reaches.";
  const std::string kept = "wall_pairs: kept: omitted only if omit names it\n";
  const std::string with_walls = answer("sorted", kept);
  EXPECT_NE(with_walls.find(different + remedy), std::string::npos) << with_walls;
  for (const std::string& without : {answer("sorted", ""), answer("listed", kept)}) {
    EXPECT_NE(without.find(different), std::string::npos) << without;
    EXPECT_EQ(without.find(remedy), std::string::npos) << without;
  }
}

TEST(ShowDetectors, AreOfThePhasesThatAreAsked) {
  const std::string text = WithFile(
      RealPlanOf({"timing"}, {"dbvt", "grid"}),
      [&](const plan::Run&, Made& made) {
        made.Detect({100, 100, 100});
      },
      [](const results::ResultFile& file) {
        return printers::Show(file, {.phases = {protocol::Phase::kBroad}}).text;
      });
  EXPECT_NE(text.find("\nDetectors: a cycle's broad, "), std::string::npos) << text;
  EXPECT_NE(text.find(": p of broad ~ objects^p\n"), std::string::npos) << text;
  EXPECT_EQ(text.find("detect,"), std::string::npos) << text;
}

TEST(ShowDetectors, SaysBeforeAnyTimingWhoIsWrong) {
  const std::string text =
      Shown({"timing", "pairs"}, {"sap", "dbvt", "null"}, {}, [](const plan::Run& run, Made& made) {
        if (run.at[1] == 2) made.Ints("missed_pairs", {run.at[0] == 0 ? 0 : 5, 10, 10});
      });
  const std::string line =
      kTitle +
      "\n  9 runs (3 values of quantity x 3 of detector), 3 cycles (0.0500 s simulated)\n"
      "  WRONG: null missed 70 of 90 pairs, in 3 of 3 runs; first in cycle 1 of quantity 10, "
      "detector null, rep 0.\n"
      "    Its times are of less work than necessary. To repeat that run: cdb run fixture.cdb -b "
      "fixture --only ";
  EXPECT_TRUE(text.starts_with(line)) << text;
}

TEST(ShowDetectors, NamesThoseThatNobodyLookedAt) {
  if (!schema::FindDetectorPart("fcl")->is_built)
    GTEST_SKIP() << "needs libfcl-dev (./setup --third-party)";
  const std::string blind = Shown({"timing", "counts"}, {"sap", "fcl_spatialhash", "dbvt"});
  EXPECT_NE(blind.find("\n  Known to miss pairs, but not checked: fcl_spatialhash. `record pairs` "
                       "checks them.\n"),
            std::string::npos)
      << blind;
  const std::string seen = Shown({"timing", "pairs"}, {"sap", "fcl_spatialhash", "dbvt"});
  EXPECT_EQ(seen.find("but not checked"), std::string::npos) << seen;
}

TEST(ShowDetectors, SaysWhatTheHarnessCosts) {
  const auto set = [](const plan::Run& run, Made& made) {
    made.result().scalars.harness_ns = run.at[1] == 2 ? NAN : 68;
  };
  const std::string text = Shown({"timing"}, {"sap", "dbvt", "null"}, {}, set);
  // Detect takes 680 ns with sap at the middle point; null would take 34 ns, all of which is
  // overhead of the harness.
  EXPECT_NE(text.find("\n  Measurement overhead: 68.0 ns per cycle, 10.0 % of the detection of "
                      "sap, the fastest; not subtracted.\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(Shown({"timing"}, {"sap", "dbvt", "null"}).find("Measurement overhead"),
            std::string::npos);
}

TEST(ShowDetectors, FitsGrowthOverWhateverChangesTheNumberOfObjects) {
  const Program program;
  program.Write("s.cdb",
                "benchmark s { let n = sweep(10, 20, 40)\n"
                "cycles 3; detector sweep(simple, dbvt); world.side 2000\n"
                "objects { quantity 2 * n } }");
  program.Run({"run", "s.cdb"});
  const Finished grown = program.Run({"show", "s.h5", "--all"});
  EXPECT_NE(grown.out.find("\nGrowth over n: p of detect ~ objects^p\n"), std::string::npos)
      << grown.out << grown.err;
  program.Write("t.cdb",
                "benchmark t { objects { restitution sweep(0, 0.5, 1) }\n"
                "cycles 3; detector sweep(simple, dbvt) }");
  program.Run({"run", "t.cdb"});
  const Finished level = program.Run({"show", "t.h5", "--all"});
  EXPECT_NE(level.out.find("\nDetectors: "), std::string::npos) << level.out << level.err;
  EXPECT_EQ(level.out.find("Growth"), std::string::npos) << level.out;
}

TEST(ShowDetectors, FitsGrowthOverTheNumbersOfObjectsThatAllHave) {
  const Program program;
  const std::string scene =
      "cycles 3; detector sweep(simple, dbvt); world.side 2000; omit none\n"
      "objects.quantity sweep(10, 20, 40, 80)\n";
  program.Write("s.cdb", "benchmark s { " + scene +
                             "skip when detector == simple and quantity > 40 }\n"
                             "benchmark t { " +
                             scene + "skip when detector == simple and quantity > 20 }\n");
  program.Run({"run", "s.cdb", "-b", "s"});
  const Finished matched = program.Run({"show", "s.h5", "--all"});
  EXPECT_NE(matched.out.find("\n  Over the numbers of objects that all rows have, 10 .. 40.\n"),
            std::string::npos)
      << matched.out << matched.err;
  // Two quantities are too few for a fit.
  program.Run({"run", "s.cdb", "-b", "t"});
  const Finished unlike = program.Run({"show", "t.h5", "--all"});
  EXPECT_NE(
      unlike.out.find("\n  The rows have different numbers of objects: do not compare them.\n"),
      std::string::npos)
      << unlike.out << unlike.err;
}

TEST(ShowDetectors, SaysWhereGrowthMixesOmissions) {
  const auto shown = [](bool of_all) {
    return Shown({"timing"}, {"sap", "dbvt"}, {}, [of_all](const plan::Run& run, Made& made) {
      const bool left_out = of_all || run.at[0] == 0;
      made.result().omitted = left_out ? "solver" : "";
      made.result().decisions =
          std::string("solver: ") + (left_out ? "left out" : "kept") + ": a test\n";
    });
  };
  const std::string note =
      "\n  Some points ran without solver and others with it: the growth is not due to the number "
      "of objects alone.\n";
  EXPECT_NE(shown(false).find(note), std::string::npos) << shown(false);
  EXPECT_EQ(shown(true).find(note), std::string::npos) << shown(true);
}

}  // namespace
}  // namespace cdb::tests
