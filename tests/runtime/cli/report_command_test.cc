// `cdb report` as a program: the page in a browser, and its figures as files. The browsers are
// scripts; tests/page has a real one.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

#include "tests/support/program.h"

namespace cdb::tests {
namespace {

class ReportCommand : public testing::Test {
 protected:
  void SetUp() override {
    program_.Write("s.cdb", "benchmark s { cycles 2; objects.quantity sweep(2, 3) }");
    ASSERT_EQ(program_.Run({"run", "s.cdb", "-q", "-o", "a b.h5"}).status, 0);
    const Finished written = program_.Run({"report", "a b.h5"});
    if (written.err.find("built without pages") != std::string::npos)
      GTEST_SKIP() << "this build has no pages";
    ASSERT_EQ(written.status, 0) << written.err;
  }

  void WriteProgram(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories(program_.folder() / "bin");
    program_.Write("bin/" + name, "#!/bin/sh\n" + text + "\n");
    chmod((program_.folder() / "bin" / name).c_str(), 0755);
  }

  /// With only the programs of WriteProgram in PATH.
  Finished Report(const std::string& environment, const std::string& options) const {
    return program_.Shell("unset BROWSER DISPLAY WAYLAND_DISPLAY; PATH=$PWD/bin " + environment +
                          " exec \"$CDB\" report 'a b.h5' " + options);
  }

  /// The text of a file that a program writes while this one goes on.
  std::string Await(const std::string& name) const {
    for (int i = 0; i < 1000 && program_.Read(name).empty(); ++i) usleep(10'000);
    return program_.Read(name);
  }

  const Program program_;
};

TEST_F(ReportCommand, HasTheTitlesOfAxes) {
  program_.Write("t.cdb",
                 "benchmark t { cycles 2; let n = sweep(2, 3) as \"number of grains\"\n"
                 "objects.quantity n }");
  ASSERT_EQ(program_.Run({"run", "t.cdb", "-q"}).status, 0);
  const Finished shown = program_.Run({"show", "t.h5"});
  EXPECT_NE(shown.out.find("\n  n: number of grains\n"), std::string::npos) << shown.out;
  const Finished json = program_.Run({"show", "t.h5", "--json"});
  EXPECT_NE(json.out.find("\"label\":\"number of grains\",\"has_title\":true"), std::string::npos)
      << json.out;
  const Finished table = program_.Run({"show", "t.h5", "--table", "step", "--latex"});
  EXPECT_NE(table.out.find("number of grains & step, "), std::string::npos) << table.out;
}

TEST_F(ReportCommand, RefusesOptionsThatHaveNoEffectOnOneTable) {
  const auto refused = [&](std::vector<std::string> options, const std::string& text) {
    options.insert(options.begin(), {"show", "a b.h5"});
    const Finished shown = program_.Run(options);
    EXPECT_NE(shown.status, 0) << shown.out;
    EXPECT_NE(shown.err.find(text), std::string::npos) << shown.err;
  };
  refused({"--columns", "n"}, "--columns needs --table FIGURE");
  refused({"--table", "step", "--csv"}, "--json and --csv have a row for each point");
  refused({"--table", "step", "--phase", "detect"}, "remove --phase");
  refused({"--table", "step", "--error", "energy"}, "remove --error");
  refused({"--table", "steps"}, "--table takes a figure of the file, not 'steps'");
}

TEST_F(ReportCommand, OpensThePageInTheBrowserOfTheEnvironment) {
  WriteProgram("shows", "echo \"$@\" > shown");
  const std::string page = "file://" + (program_.folder() / "a%20b.html").string();
  const Finished opened = Report("BROWSER='none %s:shows --new %s --at 1'", "--open");
  EXPECT_EQ(opened.status, 0) << opened.err;
  EXPECT_NE(opened.out.find("; opened by shows\n"), std::string::npos) << opened.out;
  EXPECT_EQ(Await("shown"), "--new " + page + " --at 1\n");
  WriteProgram("xdg-open", "echo \"$@\" > opened");
  EXPECT_NE(Report("DISPLAY=:9", "--open").out.find("; opened by xdg-open\n"), std::string::npos);
  EXPECT_EQ(Await("opened"), page + "\n");
}

TEST_F(ReportCommand, NamesThePageIfThereIsNoBrowser) {
  WriteProgram("xdg-open", "exit 0");
  for (const char* environment : {"", "BROWSER=none", "BROWSER=: "}) {
    const Finished opened = Report(environment, "--open");
    EXPECT_EQ(opened.status, 0) << opened.err;
    EXPECT_NE(opened.out.find("; no browser found ($BROWSER, or xdg-open and a display): open "
                              "file://"),
              std::string::npos)
        << opened.out;
    EXPECT_NE(opened.out.find("/a%20b.html in one\n"), std::string::npos) << opened.out;
  }
}

TEST_F(ReportCommand, WritesFiguresThatABrowserDraws) {
  const Finished none = Report("", "--svg figures");
  EXPECT_EQ(none.status, 2);
  EXPECT_NE(none.err.find("--svg needs a browser that runs without a window"), std::string::npos)
      << none.err;
  EXPECT_NE(none.err.find("PATH has none of chromium, "), std::string::npos) << none.err;
  EXPECT_FALSE(program_.Exists("figures"));

  WriteProgram(
      "chromium",
      "echo \"$@\" > asked; echo '<html><pre id=\"figures\">{\"s-times.svg\":\"\\u003csvg/>"
      "\",\"../s.svg\":\"x\",\"s.html\":\"x\",\"s-1.svg\":7}</pre></html>'");
  const Finished drawn = Report("", "--svg figures");
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_NE(drawn.out.find("\nfigures/s-times.svg\n"), std::string::npos) << drawn.out;
  EXPECT_EQ(program_.Read("figures/s-times.svg"), "<svg/>");
  // Names that a page may not choose.
  EXPECT_FALSE(program_.Exists("s.svg"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(program_.folder() / "figures"), {}),
            1);
  const std::string asked = program_.Read("asked");
  EXPECT_NE(asked.find("/a%20b.html#figures&size=screen&\n"), std::string::npos) << asked;
  const std::size_t at = asked.find("--user-data-dir=") + 16;
  EXPECT_FALSE(std::filesystem::exists(asked.substr(at, asked.find(' ', at) - at)));

  EXPECT_EQ(
      Report("", "--svg figures --size column --view '#quantity=time:broad&statistic=p95'").status,
      0);
  EXPECT_NE(program_.Read("asked").find("#figures&size=column&quantity=time:broad&statistic=p95\n"),
            std::string::npos);
  for (const char* unknown : {"--size small", "--size 5mm", "--view 'a b'"})
    EXPECT_EQ(Report("", std::string("--svg figures ") + unknown).status, 2) << unknown;

  EXPECT_EQ(Report("", "--svg figures --size 84mm").status, 0);
  EXPECT_NE(program_.Read("asked").find("#figures&size=84mm&\n"), std::string::npos);

  WriteProgram("chromium",
               "echo '<pre id=\"figures\">{\"unknown\":\"a=b\",\"s-times.svg\":\"x\"}</pre>'");
  const Finished wrong = Report("", "--svg figures --view a=b");
  EXPECT_EQ(wrong.status, 2);
  EXPECT_NE(wrong.err.find("--view: no figure takes 'a=b'"), std::string::npos) << wrong.err;

  for (const char* fails :
       {"exit 7", "echo '<pre id=\"figures\">{\"s-times.svg\":'", "kill -9 $$"}) {
    WriteProgram("chromium", fails);
    const Finished failed = Report("", "--svg figures");
    EXPECT_EQ(failed.status, 2) << fails;
    EXPECT_NE(failed.err.find("chromium did not draw the figures of a b.html (exit status "),
              std::string::npos)
        << failed.err;
  }
}

}  // namespace
}  // namespace cdb::tests
