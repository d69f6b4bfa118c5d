// `cdb suite --publish` and `--page`: folders of results that others can check, and what is found
// when one was tampered with.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "runtime/cli/publish/digest.h"
#include "runtime/cli/publish/place.h"
#include "runtime/cli/publish/publish.h"
#include "runtime/cli/publish/signature.h"
#include "runtime/printers/json_points.h"
#include "runtime/sweep/process/program.h"
#include "tests/runtime/cli/plans/submission.h"
#include "tests/support/program.h"
#include "tests/support/sanitizers.h"

namespace cdb::tests {
namespace {

namespace fs = std::filesystem;

results::Provenance On(const std::string& cpu) {
  results::Provenance facts = kSuiteProvenance;
  facts["cpu"] = cpu;
  return facts;
}

/// Every file below a folder, by its name, with its contents.
std::map<std::string, std::string> Contents(const fs::path& folder) {
  std::map<std::string, std::string> contents;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      contents[fs::relative(entry.path(), folder)] = ReadFile(entry.path());
  return contents;
}

/// Replaces the first `was` in a file.
void Replace(const fs::path& file, const std::string& was, const std::string& now) {
  std::string text = ReadFile(file);
  ASSERT_NE(text.find(was), std::string::npos) << was;
  WriteFile(file, text.replace(text.find(was), was.size(), now));
}

/// As somebody does who tampers with a folder.
void RenewDigest(const fs::path& folder) {
  WriteFile(folder / publish::kDigestFile, publish::DigestText(publish::ComputeDigest(folder)));
}

/// Two machines: on the other one, the same motion, and `auto` is half as fast.
class Publish : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (kAnySanitizer) return;
    mine_ =
        std::make_unique<Submission>(SuiteChange(), On("Intel(R) Xeon(R) Gold 6230 CPU @ 2.10GHz"));
    mine_->Summarise();
    other_ = std::make_unique<Submission>(
        [](const plan::Run& run, SuiteRun& made) {
          if (run.at.back() > 0) made.ns *= 4;
        },
        On("AMD EPYC 7B13"));
    other_->Summarise();
    published_ = std::make_unique<Program>();
    first_ = published_->Run({"suite", "-o", mine_->folder(), "--publish", "place"});
  }
  static void TearDownTestSuite() {
    mine_.reset();
    other_.reset();
    published_.reset();
  }
  void SetUp() override {
    if (kAnySanitizer) GTEST_SKIP() << "it writes and reads 840 runs";
  }

  Finished Add(const Submission& results, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"suite", "-o", results.folder(), "--publish", "place"};
    words.insert(words.end(), more.begin(), more.end());
    return program_.Run(words);
  }
  /// The only folder in the place.
  fs::path Only() const {
    for (const auto& entry : fs::directory_iterator(place()))
      if (entry.is_directory()) return entry.path();
    ADD_FAILURE() << "nothing was published";
    return {};
  }
  fs::path place() const { return program_.folder() / "place"; }
  static void ExpectSays(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
  }
  /// What `--page` finds in the only folder.
  std::vector<std::string> Faults() const {
    const publish::Place read = publish::ReadPlace(place());
    return read.entries.size() == 1 ? read.entries[0].faults
                                    : std::vector<std::string>{"another number of entries"};
  }
  void ExpectFault(const std::string& part) const {
    const std::vector<std::string> faults = Faults();
    ASSERT_FALSE(faults.empty()) << part;
    ExpectSays(faults[0], part);
  }

  /// Gives the test a place in which `mine_` is published.
  void UsePlace() const {
    ASSERT_EQ(first_.status, 0) << first_.err;
    fs::copy(published_->folder() / "place", place(), fs::copy_options::recursive);
  }

  static inline std::unique_ptr<Submission> mine_, other_;
  static inline std::unique_ptr<Program> published_;
  static inline Finished first_;
  const Program program_;
};

TEST_F(Publish, MakesAFolderThatOthersCanCheck) {
  UsePlace();
  ExpectSays(first_.out, "published: 19 files");
  ExpectSays(first_.out, "not signed");
  const fs::path folder = Only();
  EXPECT_TRUE(folder.filename().string().starts_with("intel-xeon-gold-6230-cdb-0.1.0-"))
      << folder.filename();
  EXPECT_EQ(program_.Shell("cd place/*/ && sha256sum -c --quiet digest.txt").status, 0);
  const Finished check = program_.Run({"suite", "--check", folder});
  EXPECT_EQ(check.status, 0) << check.out << check.err;
  ExpectSays(check.out, "signature: not signed");
  const Finished against = program_.Run({"suite", "--against", folder, "-o", mine_->folder()});
  EXPECT_EQ(against.status, 0) << against.out << against.err;
}

TEST_F(Publish, ASecondTimeChangesNothing) {
  UsePlace();
  const auto before = Contents(place());
  // Of results that were copied meanwhile.
  fs::copy(mine_->folder(), program_.folder() / "copy");
  const Finished again = program_.Run({"suite", "-o", "copy", "--publish", "place"});
  EXPECT_EQ(again.status, 0) << again.err;
  ExpectSays(again.out, "was published already; nothing changed");
  EXPECT_EQ(Contents(place()), before);
}

TEST_F(Publish, RefusesResultsThatAreNotCompleteAndComparable) {
  fs::copy(mine_->folder(), program_.folder() / "part");
  fs::remove(program_.folder() / "part" / "standard_bounce.h5");
  const Finished refused = program_.Run({"suite", "-o", "part", "--publish", "place"});
  EXPECT_EQ(refused.status, 3);
  ExpectSays(refused.out, "not published");
  ExpectSays(refused.out, "stiff/bounce: there are no results");
  EXPECT_FALSE(program_.Exists("place"));
  const Finished none = program_.Run({"suite", "-o", "nowhere", "--publish", "place"});
  EXPECT_EQ(none.status, 2);
  ExpectSays(none.err, "has no results of the standard suite");
  ExpectSays(program_.Run({"suite", "--sign", "key"}).err, "it needs --publish");
  ExpectSays(program_.Run({"suite", "--publish", "place", "--only", "games"}).err,
             "--only is for runs, and --publish executes none");
  ExpectSays(program_.Run({"suite", "--page", "part"}).err, "has no published results");
  ExpectSays(program_.Run({"suite", "--page", "a", "--publish", "b"}).err,
             "--publish cannot be combined with --page");
}

TEST_F(Publish, FindsChangedBytes) {
  UsePlace();
  Replace(Only() / "suite.json", "Xeon", "Zeon");
  ExpectFault("suite.json: it has changed since digest.txt was written");
  const Finished page = program_.Run({"suite", "--page", "place"});
  EXPECT_EQ(page.status, 3);
  ExpectSays(page.out, "1 of them not sound");
  const Finished check = program_.Run({"suite", "--check", Only()});
  EXPECT_EQ(check.status, 3);
  ExpectSays(check.out, "suite.json: it has changed since digest.txt was written");
  const Finished against = program_.Run({"suite", "--against", Only(), "-o", mine_->folder()});
  EXPECT_EQ(against.status, 2);
  ExpectSays(against.err, "is not as it was published: suite.json");
  // Nor is it replaced.
  const auto before = Contents(Only());
  const Finished again = Add(*mine_);
  EXPECT_EQ(again.status, 2);
  ExpectSays(again.err, "does not have these results as they were published");
  EXPECT_EQ(Contents(Only()), before);
}

TEST_F(Publish, FindsAFigureThatIsNotThatOfTheResults) {
  UsePlace();
  Replace(Only() / "suite.json", "\"score\": ", "\"score\": 9");
  RenewDigest(Only());
  ExpectFault("suite.json: it is not the summary of these results");
}

TEST_F(Publish, FindsMissingAndForeignFiles) {
  UsePlace();
  const fs::path folder = Only();
  WriteFile(folder / "more.txt", "");
  ExpectFault("more.txt: it is not in digest.txt");
  fs::remove(folder / "more.txt");
  fs::rename(folder / "suite.json", program_.folder() / "suite.json");
  fs::create_symlink(program_.folder() / "suite.json", folder / "suite.json");
  ExpectFault("suite.json: it is not a regular file");
  fs::remove(folder / "suite.json");
  fs::rename(program_.folder() / "suite.json", folder / "suite.json");
  EXPECT_EQ(Faults(), std::vector<std::string>{});
  fs::remove(folder / "standard_bounce.h5");
  ExpectFault("standard_bounce.h5: it is missing");
  RenewDigest(folder);
  ExpectFault("stiff/bounce: there are no results");
  WriteFile(folder / "digest.txt", "../../etc/passwd\n");
  ExpectFault("digest.txt: it is not a list as `sha256sum` prints it");
}

TEST_F(Publish, TheSameResultsAreNotVerifiedByACopy) {
  UsePlace();
  // With the same digits, or with those of a folder that has one more file.
  const fs::path mine = Only();
  const std::string name = mine.filename();
  const fs::path copy = place() / ("amd" + name.substr(name.find('-')));
  fs::copy(mine, copy);
  WriteFile(copy / "more.h5", "");
  RenewDigest(copy);
  const publish::Place read = publish::ReadPlace(place());
  ASSERT_EQ(read.entries.size(), 2u);
  ASSERT_EQ(read.entries[0].faults.size(), 2u);
  ExpectSays(read.entries[0].faults[0], "the name of the folder should be " + name);
  ExpectSays(read.entries[0].faults[1], "more.h5: it is not a file of the suite");
  EXPECT_TRUE(read.entries[1].faults.empty());
  EXPECT_TRUE(read.entries[1].verified.empty());
}

TEST_F(Publish, ASummaryWithoutFiguresOrOfALaterVersionIsNone) {
  UsePlace();
  const fs::path summary = Only() / "suite.json";
  auto json = printers::Json::parse(ReadFile(summary));
  const std::string whole = json.dump();
  for (auto& kind : json["kinds"]) kind = printers::Json::object();
  WriteFile(summary, json.dump());
  RenewDigest(Only());
  ExpectFault("suite.json: it is not the summary of these results");
  json = printers::Json::parse(whole);
  json["suite"] = figures::kSuiteVersion + 1;
  WriteFile(summary, json.dump());
  RenewDigest(Only());
  ExpectFault("which this cdb does not know");
}

TEST_F(Publish, EntriesOfOneVersionVerifyEachOther) {
  UsePlace();
  const Finished second = Add(*other_);
  EXPECT_EQ(second.status, 0);
  ExpectSays(second.out, " is contradicted by ");
  ExpectSays(second.out, "2 entries, 2 disagreements");
  const publish::Place read = publish::ReadPlace(place());
  ASSERT_EQ(read.entries.size(), 2u);
  for (const publish::PlaceEntry& entry : read.entries) {
    EXPECT_TRUE(entry.faults.empty());
    ASSERT_EQ(entry.verified.size(), 1u);
    EXPECT_EQ(entry.verified[0].outcome, publish::Verification::Outcome::kDisagrees);
    EXPECT_EQ(entry.verified[0].scenes, figures::StandardScenes().size());
  }
  EXPECT_EQ(program_.Run({"suite", "--page", "place"}).status, 4);

  // Other versions of the suite are kept apart.
  const fs::path older = read.entries[0].name;
  Replace(place() / older / "suite.json", fmt::format("\"suite\": {}", figures::kSuiteVersion),
          fmt::format("\"suite\": {}", figures::kSuiteVersion - 1));
  RenewDigest(place() / older);
  const publish::Place apart = publish::ReadPlace(place());
  EXPECT_EQ(apart.entries[0].version, figures::kSuiteVersion - 1);
  for (const publish::PlaceEntry& entry : apart.entries) {
    EXPECT_TRUE(entry.faults.empty());
    EXPECT_TRUE(entry.verified.empty());
  }
  ExpectSays(program_.Run({"suite", "--check", place() / older}).out,
             "suite.json: it is of version ");
}

class SignedPublish : public Publish {
 protected:
  void SetUp() override {
    Publish::SetUp();
    if (IsSkipped()) return;
    if (!process::FindProgram("ssh-keygen")) GTEST_SKIP() << "without ssh-keygen (./setup --test)";
    for (const char* key : {"ann", "bob"})
      ASSERT_EQ(
          program_.Shell(fmt::format("ssh-keygen -q -t ed25519 -N '' -C x -f {}", key)).status, 0);
  }
  Finished Sign(const std::string& key) const { return Add(*mine_, {"--sign", key}); }
  publish::Signature Found() const { return publish::CheckSignature(Only()); }
};

TEST_F(SignedPublish, ASignatureIsVerifiedAndBelongsToOneKey) {
  UsePlace();
  const Finished later = Sign("ann");
  EXPECT_EQ(later.status, 0) << later.err;
  ExpectSays(later.out, "was published already, signed by key SHA256:");
  EXPECT_EQ(Found().state, publish::SignatureState::kGood);
  const auto before = Contents(place());
  ExpectSays(Sign("ann.pub").out, "nothing changed");  // a public key names the same key
  const Finished other = Sign("bob");
  EXPECT_EQ(other.status, 2);
  ExpectSays(other.err, "has a signature already, not by the key of --sign");
  ExpectSays(Sign("nobody").err, "--sign nobody: ");
  EXPECT_EQ(Contents(place()), before);
  // Of another digest.
  WriteFile(Only() / "digest.txt", ReadFile(Only() / "digest.txt") + "\n");
  EXPECT_EQ(Found().state, publish::SignatureState::kBad);
}

TEST_F(SignedPublish, AKeyThatIsNotOfAKnownSignerIsTold) {
  UsePlace();
  publish::Sign(Only(), program_.folder() / "ann");
  ASSERT_EQ(
      program_.Shell("echo \"ann@example.org $(cat ann.pub)\" > place/allowed_signers").status, 0);
  EXPECT_EQ(Found().state, publish::SignatureState::kGood);
  ExpectSays(Found().text, "signed by ann@example.org, key SHA256:");
  // Somebody else signs the folder again.
  publish::Sign(Only(), program_.folder() / "bob");
  EXPECT_EQ(Found().state, publish::SignatureState::kStranger);
  ExpectSays(Found().text, "which is not in allowed_signers");
  // The signature is of something else.
  WriteFile(Only() / "digest.txt.sig", "no signature\n");
  EXPECT_EQ(Found().state, publish::SignatureState::kBad);
  const Finished check = program_.Run({"suite", "--check", Only()});
  EXPECT_EQ(check.status, 3);
  ExpectSays(check.out, "the signature does not match");
}

TEST_F(SignedPublish, WithoutTheProgramItIsRefused) {
  const Finished refused = program_.Shell(fmt::format(
      "PATH=/nowhere \"$CDB\" suite -o {} --publish place --sign ann", mine_->folder().string()));
  EXPECT_EQ(refused.status, 2);
  ExpectSays(refused.err, "--sign needs the program ssh-keygen");
  EXPECT_FALSE(fs::exists(place()));
}

TEST_F(Publish, AKillLeavesTheWholeFolderOrNone) {
  for (const int milliseconds : {500, 1500, 2500}) {
    const pid_t child =
        program_.Start({CdbPath(), "suite", "-o", mine_->folder(), "--publish", "place"});
    usleep(static_cast<useconds_t>(milliseconds) * 1000);
    kill(child, SIGKILL);
    ASSERT_GT(waitpid(child, nullptr, 0), 0);
    if (!fs::exists(place())) continue;
    for (const auto& entry : fs::directory_iterator(place()))
      if (const std::string name = entry.path().filename();
          entry.is_directory() && !name.starts_with('.')) {
        EXPECT_TRUE(publish::FindDigestFaults(entry.path()).empty()) << name;
      }
  }
  // Half a folder that was left is not in the way.
  const fs::path left =
      place() / fmt::format(".{}.tmp", publish::NameOf(plans::ReadSuiteFolder(mine_->folder())));
  fs::remove_all(place());
  fs::create_directories(left);
  WriteFile(left / "standard_bounce.h5", "half a");
  EXPECT_EQ(Add(*mine_).status, 0);
  EXPECT_FALSE(fs::exists(left));
  EXPECT_EQ(Faults(), std::vector<std::string>{});
}

}  // namespace
}  // namespace cdb::tests
