// Standard output: all output is written, or the command reports that it was not.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/program.h"

namespace cdb::tests {
namespace {

class Output : public testing::Test {
 protected:
  void SetUp() override {
    program_.Write("a.cdb", "benchmark a { cycles 3; objects.quantity sweep(2, 3) }");
    ASSERT_EQ(program_.Run({"run", "a.cdb", "-q"}).status, 0);
  }
  Program program_;
};

TEST_F(Output, OnAFullDiskEndsWithAMessage) {
  for (const char* command : {"show a.h5",
                              "show a.h5 --csv",
                              "show a.h5 --json",
                              "plan a.cdb",
                              "plan -o - a.cdb",
                              "plan --why a.cdb",
                              "check a.cdb",
                              "check --json a.cdb",
                              "doc language",
                              "doc",
                              "list",
                              "explain",
                              "explain E0201",
                              "generate bash",
                              "fmt - < a.cdb",
                              "compare a.h5 a.h5",
                              "compare --json a.h5 a.h5",
                              "run --fresh a.cdb",
                              "--help",
                              "--version"}) {
    // A file with errors prints a line of JSON; one without prints nothing.
    if (std::string(command) == "check --json a.cdb")
      program_.Write("a.cdb", "benchmark a { cycles 3; objects.quantity swep(2, 3) }");
    const Finished finished = program_.Shell(std::string("\"$CDB\" ") + command + " > /dev/full");
    EXPECT_EQ(finished.status, 2) << command;
    EXPECT_NE(finished.err.find("cannot write standard output: "), std::string::npos)
        << command << ": " << finished.err;
    program_.Write("a.cdb", "benchmark a { cycles 3; objects.quantity sweep(2, 3) }");
  }
}

TEST_F(Output, ThatIsClosedEndsWithAMessage) {
  const Finished finished = program_.Shell("\"$CDB\" show a.h5 >&-");
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.err.find("standard output"), std::string::npos) << finished.err;
  EXPECT_EQ(program_.Shell("\"$CDB\" show a.h5 <&- 2>&-").status, 0);
}

TEST_F(Output, ToAReaderThatHasGoneEndsQuietly) {
  for (const char* trap : {"", "trap '' PIPE; "}) {
    const Finished finished = program_.Shell(
        std::string(trap) + "(\"$CDB\" doc language 2> said; echo $? > status) | true; cat said");
    EXPECT_EQ(finished.out, "");
    // As for other programs: it is ended by the signal, or, if the signal is ignored, succeeds.
    EXPECT_EQ(program_.Read("status"), *trap == '\0' ? "141\n" : "0\n");
  }
}

/// The title of a plan is its only free text: control characters in it could colour, ring and
/// reverse the line.
TEST_F(Output, ShowsNoControlCharactersOfFiles) {
  program_.Write("h.cdb", "benchmark h \"plain title\" { cycles 2; objects.quantity sweep(2, 3) }");
  ASSERT_EQ(program_.Run({"plan", "h.cdb", "-o", "h.yaml"}).status, 0);
  std::string plan = program_.Read("h.yaml");
  const std::size_t title = plan.find("plain title");
  ASSERT_NE(title, std::string::npos);
  program_.Write("h.yaml", plan.replace(title, 11, "red \\e[31m \\u202e right \\a end"));
  program_.Write("bell.cdb", "benchmark b { cycles \x1b[31m\xe2\x80\xae }");
  ASSERT_EQ(program_.Run({"run", "h.yaml", "-q"}).status, 0);
  for (const char* command :
       {"show h.h5", "show h.h5 --json", "plan h.yaml", "check bell.cdb", "run h.yaml --fresh",
        "compare h.h5 h.h5", "report h.h5", "show \"$(printf '\\033[31m.h5')\""}) {
    const Finished finished = program_.Shell(std::string("\"$CDB\" ") + command);
    EXPECT_NE(finished.out + finished.err, "") << command;
    for (const std::string& text : {finished.out, finished.err}) {
      EXPECT_EQ(text.find('\x1b'), std::string::npos) << command << ": " << text;
      EXPECT_EQ(text.find('\x07'), std::string::npos) << command << ": " << text;
      // JSON may contain it, escaped.
      if (std::string(command).find("json") == std::string::npos) {
        EXPECT_EQ(text.find("\xe2\x80\xae"), std::string::npos) << command << ": " << text;
      }
    }
  }
}

}  // namespace
}  // namespace cdb::tests
