// `cdb generate`, `cdb doc` and `cdb list`: the output for shells, man and terminals.
#include <gtest/gtest.h>

#include <iostream>
#include <string>

#include "compiler/schema/schema.h"
#include "tests/support/program.h"

namespace cdb::tests {
namespace {

/// False if the program is not installed, which skips what needs it.
bool IsThere(const Program& program, const std::string& name) {
  if (program.Shell("command -v " + name).status == 0) return true;
  std::cout << "skipped: needs " << name << " (./setup --editors)\n";
  return false;
}

TEST(Completion, OfBashKnowsCommandsOptionsWordsAndFiles) {
  const Program program;
  program.Write("first.cdb", "benchmark b { }\n");
  program.Write("try.bash",
                "source ./completion\ntry() { COMP_WORDS=(\"$@\"); COMP_CWORD=$(($#-1)); _cdb; "
                "echo \"${COMPREPLY[@]}\"; }\ntry cdb che\ntry cdb check --js\ntry cdb doc tunnel\n"
                "try cdb list scen\ntry cdb run fir\ntry cdb explain E020\n");
  const Finished done = program.Shell("$CDB generate bash > completion && bash try.bash");
  EXPECT_EQ(done.status, 0) << done.err;
  EXPECT_EQ(done.out,
            "check\n--json\ntunnelled\nscenarios\nfirst.cdb\nE0201 E0202 E0203 E0204 E0205 E0206 "
            "E0207 E0208 E0209\n");
}

TEST(Completion, OfZshAndFishIsWellFormed) {
  const Program program;
  if (IsThere(program, "zsh")) {
    EXPECT_EQ(program
                  .Shell("$CDB generate zsh > _cdb && zsh -n _cdb && zsh -fc 'autoload -U "
                         "compinit && compinit -D && source ./_cdb && echo $_comps[cdb]'")
                  .out,
              "_cdb\n");
  }
  if (IsThere(program, "fish")) {
    EXPECT_EQ(program
                  .Shell("$CDB generate fish > cdb.fish && HOME=. fish -c 'source cdb.fish; "
                         "complete -C \"cdb doc tunn\"'")
                  .out,
              "tunnelled\n");
  }
}

TEST(Man, PagesHaveNoErrorsAndEveryCommandAndParameter) {
  const Program program;
  const Finished commands = program.Run({"generate", "cdb.1"});
  for (const char* part : {".TH CDB 1", ".SS cdb check", "\\fB\\-\\-json\\fR", ".SH EXIT STATUS"})
    EXPECT_NE(commands.out.find(part), std::string::npos) << part;
  const Finished language = program.Run({"generate", "cdb-language.5"});
  std::string plain = language.out;
  for (std::size_t at = 0; (at = plain.find("\\-", at)) != plain.npos;) plain.replace(at, 2, "-");
  for (const schema::Parameter& parameter : schema::Schema())
    EXPECT_NE(plain.find("\\fB" + parameter.FullName() + "\\fR"), std::string::npos)
        << parameter.FullName();
  if (!IsThere(program, "groff")) return;
  for (const char* page : {"cdb.1", "cdb-language.5"}) {
    const Finished set =
        program.Shell(std::string("$CDB generate ") + page + " | groff -man -Tutf8 -ww -z");
    EXPECT_EQ(set.status, 0) << page;
    EXPECT_EQ(set.err, "") << page;
  }
}

TEST(Generate, RefusesByName) {
  const Program program;
  const Finished finished = program.Run({"generate", "tcsh"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.err.find("there are bash, zsh, fish"), std::string::npos) << finished.err;
}

TEST(Doc, FindsWordsAndScenarios) {
  const Program program;
  for (const char* word :
       {"sweep", "any", "let", "skip", "cases", "from", "uniform", "dbvt", "tunnelled"})
    EXPECT_EQ(program.Run({"doc", word}).status, 0) << word;
  const Finished scenario = program.Run({"doc", "paper/experiment2"});
  EXPECT_EQ(scenario.status, 0);
  EXPECT_NE(scenario.out.find("benchmark paper_experiment2"), std::string::npos);
  EXPECT_EQ(program.Run({"doc", "experiment2"}).out, scenario.out);
  EXPECT_TRUE(program.Run({"doc", "which_one"}).out.starts_with("WHICH"));
  EXPECT_EQ(program.Run({"doc", "../../etc/passwd"}).status, 2);
  EXPECT_NE(program.Run({"doc", "tunneled"}).err.find("did you mean 'tunnelled'?"),
            std::string::npos);
}

TEST(List, NamesTheBenchmarksOfEachScenario) {
  const Program program;
  const Finished list = program.Run({"list", "scenarios"});
  EXPECT_NE(list.out.find("benchmark: paper_experiment2"), std::string::npos) << list.out;
}

}  // namespace
}  // namespace cdb::tests
