// A journal as a file: what is in it, several processes, and what is found after a kill.
#include "runtime/results/journal/journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "runtime/results/journal/journals.h"
#include "tests/runtime/results/journal/change_facts.h"
#include "tests/runtime/results/store_fixture.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;
using journal::Journal;
using testing::ElementsAre;
using testing::HasSubstr;

class JournalTest : public testing::Test {
 protected:
  Journal Open() const { return Journal::OpenToWrite(folder_.path(), plan_.Sha256()); }
  void Write(std::size_t i, Journal& to, results::Status status = results::Status::kDone) {
    writer_.Write(plan_.runs[i], FakeResult(plan_.runs[i], status, 5).result, to);
  }
  std::vector<std::string> Ids(Journal& of, std::int64_t after = 0, bool reversed = false) const {
    std::vector<std::string> ids;
    of.ForEachRun([&](const Journal::Row& row) { ids.push_back(row.run_id); }, after, reversed);
    return ids;
  }
  const std::string& Id(std::size_t i) const { return plan_.runs[i].id; }

  const TemporaryFolder folder_;
  const plan::Plan plan_ = MakePlan({NumberAxis("quantity", {1, 2, 3, 4})}, 1, {});
  const results::Provenance provenance_ = TestProvenance();
  journal::RunWriter writer_{plan_, provenance_};
};

TEST_F(JournalTest, HoldsRunsInTheOrderOfWriting) {
  Journal journal = Open();
  EXPECT_EQ(journal.plan_sha256(), plan_.Sha256());
  for (const std::size_t i : {2, 0, 3}) Write(i, journal);
  EXPECT_THAT(Ids(journal), ElementsAre(Id(2), Id(0), Id(3)));
  EXPECT_THAT(Ids(journal, 1), ElementsAre(Id(0), Id(3)));
  EXPECT_THAT(Ids(journal, 0, true), ElementsAre(Id(3), Id(0), Id(2)));
  EXPECT_EQ(journal.CountRuns(), 3u);
  EXPECT_TRUE(journal.Has(Id(0)));
  EXPECT_FALSE(journal.Has(Id(1)));
  EXPECT_FALSE(journal.Read(Id(1)));
  EXPECT_EQ(journal.FindFault(), "");
  // Written again, a run is the last one.
  Write(2, journal, results::Status::kCrashed);
  EXPECT_THAT(Ids(journal), ElementsAre(Id(0), Id(3), Id(2)));
  EXPECT_EQ(journal::InfoOf(*journal.Read(Id(2))).outcome.status, results::Status::kCrashed);
  journal.Forget(Id(2));
  EXPECT_THAT(Ids(journal), ElementsAre(Id(0), Id(3)));
}

TEST_F(JournalTest, ReadersSeeWhatIsWrittenMeanwhile) {
  Journal writer = Open();
  Journal reader = Journal::OpenToRead(writer.path());
  EXPECT_EQ(reader.plan_sha256(), plan_.Sha256());
  Write(0, writer);
  EXPECT_TRUE(reader.Has(Id(0)));
  EXPECT_EQ(reader.Read(Id(0))->texts, writer.Read(Id(0))->texts);
  EXPECT_THROW(Write(1, reader), files::StoreError);
  Journal other = Open();
  Write(1, other);
  Write(2, writer);
  EXPECT_THAT(Ids(reader), ElementsAre(Id(0), Id(1), Id(2)));
}

TEST_F(JournalTest, ReadersMayComeWhileItIsMade) {
  for (int i = 0; i < 50; ++i) {
    const TemporaryFolder folder;
    const fs::path file = journal::OwnJournal(folder.path());
    const std::jthread maker([&] { Journal::OpenToWrite(folder.path(), plan_.Sha256()); });
    std::string plan;
    while (plan.empty())
      if (fs::exists(file)) plan = Journal::OpenToRead(file).plan_sha256();
    EXPECT_EQ(plan, plan_.Sha256());
  }
}

TEST_F(JournalTest, LeavesNothingBesideItself) {
  {
    Journal writer = Open();
    Write(0, writer);
  }
  Journal::OpenToRead(folder_ / "runs.journal").CountRuns();
  EXPECT_THAT(FilesIn(folder_.path()), ElementsAre("runs.journal"));
  journal::RemoveJournals(folder_.path());
  EXPECT_TRUE(FilesIn(folder_.path()).empty());
}

TEST_F(JournalTest, RequestsAreTheNewestOfAllJournals) {
  journal::Ask(folder_.path(), plan_.Sha256(), journal::kRetry, "failed");
  fs::rename(folder_ / "runs.journal", folder_ / "a.journal");
  journal::Ask(folder_.path(), plan_.Sha256(), journal::kSubmission, "12");
  EXPECT_EQ(journal::FindRequest(folder_.path(), journal::kRetry), "failed");
  journal::Ask(folder_.path(), plan_.Sha256(), journal::kRetry, "crashed");
  EXPECT_EQ(journal::FindRequest(folder_.path(), journal::kRetry), "crashed");
  EXPECT_EQ(journal::FindRequest(folder_.path(), journal::kSubmission), "12");
  EXPECT_EQ(journal::FindRequest(folder_.path(), journal::kFresh), "");
  WriteFile(folder_ / "b.journal", "damaged");
  EXPECT_EQ(journal::FindRequest(folder_.path(), journal::kRetry), "crashed");
}

TEST_F(JournalTest, StartsOverInOneStep) {
  Journal journal = Open();
  Write(0, journal);
  journal.Ask("part 1 of 2", "1");
  Journal other = Open();
  other.Restart("another plan", journal::kFresh);
  EXPECT_EQ(other.CountRuns(), 0u);
  EXPECT_EQ(other.Requests().at(journal::kFresh).value, "another plan");
  EXPECT_EQ(other.Requests().size(), 1u);
  // The first process does not mix two plans.
  try {
    Write(1, journal);
    ADD_FAILURE();
  } catch (const files::StoreError& error) {
    EXPECT_THAT(error.what(), HasSubstr("another plan"));
  }
  EXPECT_EQ(other.CountRuns(), 0u);
}

TEST_F(JournalTest, AFileThatIsRemovedIsNoticed) {
  Journal journal = Open();
  Write(0, journal);
  fs::remove(journal.path());
  EXPECT_THROW(Write(1, journal), files::StoreError);
  Journal again = Open();
  EXPECT_EQ(again.CountRuns(), 0u);
  EXPECT_THROW(Write(1, journal), files::StoreError);
}

TEST_F(JournalTest, OtherFilesAreRefused) {
  WriteFile(folder_ / "runs.journal", "this is no SQLite file, whatever its name says");
  EXPECT_THROW(Open(), journal::DamagedJournal);
  EXPECT_FALSE(journal::IsJournal(folder_ / "runs.journal"));
  WriteFile(folder_ / "empty.journal", "");
  EXPECT_EQ(Journal::OpenToRead(folder_ / "empty.journal").CountRuns(), 0u);
  EXPECT_THROW(Journal::OpenToRead(folder_ / "none.journal"), files::StoreError);
  fs::remove(folder_ / "runs.journal");
  Open();
  EXPECT_TRUE(journal::IsJournal(folder_ / "runs.journal"));
  // Byte 60 to 63 of the head is user_version, 68 to 71 application_id.
  for (const std::size_t place : {63, 71}) {
    std::string bytes = ReadFile(folder_ / "runs.journal");
    bytes[place] = static_cast<char>(bytes[place] + 1);
    WriteFile(folder_ / "other.journal", bytes);
    EXPECT_THROW(Journal::OpenToRead(folder_ / "other.journal"), files::StoreError) << place;
  }
}

TEST_F(JournalTest, ADamagedRunDoesNotHideOthers) {
  {
    Journal journal = Open();
    for (std::size_t i = 0; i < 4; ++i) Write(i, journal);
  }
  ChangeFacts(folder_ / "runs.journal", Id(1));
  Journal journal = Open();
  EXPECT_TRUE(journal.Read(Id(0)));
  EXPECT_THROW(journal.Read(Id(1)), journal::DamagedRun);
  EXPECT_TRUE(journal.Read(Id(2)));
  EXPECT_EQ(journal.FindFault(), "") << "SQLite sees no fault";
}

}  // namespace
}  // namespace cdb::tests
