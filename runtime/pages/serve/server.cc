#include "runtime/pages/serve/server.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "runtime/pages/page/page.h"
#include "runtime/pages/serve/http.h"
#include "runtime/pages/serve/text_edit.h"
#include "runtime/pages/view/scene_document.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"

namespace cdb::serve {
namespace {

using Json = nlohmann::ordered_json;

std::string Dump(const Json& answer) {
  return answer.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json ParameterOf(const schema::Parameter& parameter, const std::string& text,
                 const std::string& benchmark, const std::string& group) {
  const std::string name(parameter.name);
  const auto written = WrittenValue(text, benchmark, {group, name});
  return {{"group", group},
          {"name", name},
          {"value", written ? Json(*written) : Json()},
          {"default", std::string(parameter.DefaultText())},
          {"takes", parameter.Takes()},
          {"unit", std::string(parameter.unit)},
          {"doc", std::string(parameter.doc)}};
}

/// Every row of the schema, for the world and for each group. Empty if the text does not parse.
Json ParametersOf(const std::string& text, const std::string& benchmark) {
  Json parameters = Json::array();
  try {
    for (const schema::Parameter& parameter : schema::Schema())
      if (!parameter.grouped) parameters.push_back(ParameterOf(parameter, text, benchmark, ""));
    for (const std::string& group : GroupsIn(text, benchmark))
      for (const schema::Parameter& parameter : schema::Schema())
        if (parameter.grouped) parameters.push_back(ParameterOf(parameter, text, benchmark, group));
  } catch (const EditError&) {
    return Json::array();  // the diagnostics give the reason
  }
  return parameters;
}

std::string ReadWhole(const std::filesystem::path& file) {
  std::string why;
  return plan::ReadInputFile(file, why).value_or("");
}

Json Message(const std::string& message) { return {{"message", message}}; }

}  // namespace

namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP};
std::atomic<pid_t> g_owner{0}, g_run{0};
static_assert(std::atomic<pid_t>::is_always_lock_free);

/// Calls only functions that are async-signal-safe.
void EndNow(int signal) {
  if (getpid() != g_owner.load()) _exit(128 + signal);  // a copy of this process that reads a file
  if (g_run.load() != 0) ::kill(-g_run.load(), SIGTERM);
  _exit(0);
}

/// While it lives, a signal that would end the program between two requests ends it at once, and
/// asks the run to stop: compiling a text takes up to minutes. Ignored signals stay ignored.
class EndsAtOnce {
 public:
  explicit EndsAtOnce(pid_t run) {
    g_owner = getpid();
    g_run = run;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      sigaction(kSignals[i], nullptr, &before_[i]);
      if (before_[i].sa_handler == SIG_IGN) continue;
      struct sigaction action = {};
      action.sa_handler = EndNow;
      sigaction(kSignals[i], &action, nullptr);
    }
  }
  ~EndsAtOnce() {
    for (std::size_t i = 0; i < before_.size(); ++i) sigaction(kSignals[i], &before_[i], nullptr);
  }
  EndsAtOnce(const EndsAtOnce&) = delete;
  EndsAtOnce& operator=(const EndsAtOnce&) = delete;

 private:
  std::array<struct sigaction, std::size(kSignals)> before_{};
};

}  // namespace

Editor::Editor(Scenario scenario, std::filesystem::path program)
    : scenario_(std::move(scenario)), program_(std::move(program)) {}

Editor::~Editor() {
  // The first signal lets it finish its current run; the second ends it at once.
  for (int asked = 0; run_ != 0 && asked < 2; ++asked) {
    ::kill(-run_, SIGTERM);
    for (int waited = 0; waited < 20 && run_ != 0; ++waited) {
      if (::waitpid(run_, nullptr, WNOHANG) != 0) run_ = 0;
      if (run_ != 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

std::string Editor::SceneOf(const std::vector<plan::Plan>& plans, std::string& trouble) const {
  for (const plan::Plan& plan : plans) {
    if (plan.benchmark != scenario_.benchmark || plan.runs.empty()) continue;
    try {
      view::SceneRecording start = view::StartOf(plan, plan.runs[0]);
      start.file = scenario_.file.string();
      return view::SceneDocument(plan.title.empty() ? plan.benchmark : plan.title, {&start, 1});
    } catch (const std::exception& error) {
      trouble = error.what();
    }
  }
  return {};
}

std::string Editor::Check(const std::string& text) {
  const EndsAtOnce ends(run_);
  Checked checked = scenario_.check(text);
  std::string trouble;
  const std::string scene = SceneOf(checked.plans, trouble);
  if (!trouble.empty()) checked.diagnostics += trouble + "\n";
  return Dump({{"text", text},
               {"diagnostics", checked.diagnostics},
               {"parameters", ParametersOf(text, scenario_.benchmark)},
               {"scene", scene.empty() ? Json() : Json::parse(scene)}});
}

std::string Editor::Document() {
  Json answer = Json::parse(Check(scenario_.text));
  Json document = answer["scene"].is_null()
                      ? Json{{"title", scenario_.benchmark}, {"runs", Json::array()}}
                      : answer["scene"];
  answer.erase("scene");
  answer["file"] = scenario_.file.string();
  document["editor"] = std::move(answer);
  return Dump(document);
}

std::string Editor::Set(const std::string& text, const std::string& group, const std::string& name,
                        const std::string& value) {
  try {
    return Check(WithValue(text, scenario_.benchmark, {group, name}, value));
  } catch (const EditError& error) {
    return Dump({{"text", text}, {"diagnostics", error.what()}});
  }
}

std::string Editor::SaveFile(const std::string& text) {
  if (ReadWhole(scenario_.file) != scenario_.text)
    return fmt::format(
        "{} was changed by another program, so it was not saved: copy your text, then open the "
        "page again",
        scenario_.file.string());
  files::WriteWhole(text, scenario_.file);
  scenario_.text = text;
  return {};
}

std::string Editor::Save(const std::string& text) {
  const std::string why = SaveFile(text);
  return Dump(Message(why.empty() ? fmt::format("saved {}", scenario_.file.string()) : why));
}

std::string Editor::Run(const std::string& text) {
  if (run_ != 0) return Dump(Message("it is already running"));
  if (const std::string why = SaveFile(text); !why.empty()) return Dump(Message(why));
  log_ = process::MemoryFile("cdb run");
  process::SpawnPlan spawn;
  spawn.Give(log_->get(), STDERR_FILENO);
  run_ = spawn.Start(program_, {"run", scenario_.file.string(), "-b", scenario_.benchmark, "-o",
                                scenario_.benchmark + ".view.h5", "--fresh"});
  return Dump(Message("running"));
}

std::string Editor::ResultScene() const {
  const results::ResultFile file(scenario_.benchmark + ".view.h5");
  view::SceneRecording run = view::ReadRecording(file, view::DefaultCell(file), {});
  run.file = scenario_.benchmark + ".view.h5";
  return view::SceneDocument(file.title().empty() ? file.benchmark() : file.title(), {&run, 1});
}

std::string Editor::Progress() {
  if (!log_) return Dump({{"is_running", false}, {"log", ""}});
  std::string log;
  std::array<char, 4096> part{};
  for (ssize_t n = 0;
       (n = ::pread(log_->get(), part.data(), part.size(), static_cast<off_t>(log.size()))) > 0;)
    log.append(part.data(), static_cast<std::size_t>(n));
  Json answer = {{"is_running", true}, {"log", log}};
  if (run_ == 0 || ::waitpid(run_, &run_status_, WNOHANG) == 0) {
    answer["is_running"] = run_ != 0;
    return Dump(answer);
  }
  run_ = 0;
  answer["is_running"] = false;
  const int status = WIFEXITED(run_status_) ? WEXITSTATUS(run_status_) : -1;
  if (status != 0) answer["log"] = log + "cdb run " + process::EndText(run_status_) + "\n";
  if (status == 0 || status == 3) try {
      answer["scene"] = Json::parse(ResultScene());
    } catch (const std::exception& error) {
      answer["log"] = log + error.what() + "\n";
    }
  return Dump(answer);
}

std::string Editor::Stop() {
  if (run_ != 0) ::kill(-run_, SIGTERM);
  return Dump(Message(run_ != 0 ? "stopping" : "nothing is running"));
}

namespace {

/// Reads a question: an object of a few texts and numbers. Throws nlohmann::json::exception, or
/// QuestionError if it is nested or large, which would take many times the memory of its text.
struct QuestionError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
nlohmann::json ParseQuestion(const std::string& body) {
  constexpr int kDeepest = 2, kMostValues = 20;
  int values = 0;
  return nlohmann::json::parse(
      body, [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
        if (depth > kDeepest || ++values > 3 * kMostValues)
          throw QuestionError("a question is an object of a few texts and numbers");
        return true;
      });
}

Reply Refusal(const char* why) {
  return {400, "text/plain; charset=utf-8", fmt::format("{}\n", why)};
}

/// Takes JSON and answers in JSON.
template <typename Act>
Route Answer(Editor& editor, const char* name, Act act) {
  return {"POST", name, [&editor, act](const std::string& body) -> Reply {
            try {
              return {.body = act(editor, ParseQuestion(body))};
            } catch (const nlohmann::json::exception& error) {
              return Refusal(error.what());
            } catch (const QuestionError& error) {
              return Refusal(error.what());
            } catch (const std::exception& error) {
              return {.body = Dump(Message(error.what()))};
            }
          }};
}

Reply PageOf(Editor& editor) {
  try {
    return {.type = "text/html; charset=utf-8",
            .body = page::Assemble(page::ViewTemplate(), "cdb view", editor.Document())};
  } catch (const std::exception& error) {
    return {500, "text/plain; charset=utf-8", fmt::format("{}\n", error.what())};
  }
}

using Question = nlohmann::json;

}  // namespace

void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin) {
  HttpServer server({
      {"GET", "", [&](const std::string&) { return PageOf(editor); }},
      Answer(editor, "check",
             [](Editor& e, const Question& asked) { return e.Check(asked.at("text")); }),
      Answer(editor, "set",
             [](Editor& e, const Question& asked) {
               return e.Set(asked.at("text"), asked.at("group"), asked.at("name"),
                            asked.at("value"));
             }),
      Answer(editor, "save",
             [](Editor& e, const Question& asked) { return e.Save(asked.at("text")); }),
      Answer(editor, "run",
             [](Editor& e, const Question& asked) { return e.Run(asked.at("text")); }),
      Answer(editor, "progress", [](Editor& e, const Question&) { return e.Progress(); }),
      Answer(editor, "stop", [](Editor& e, const Question&) { return e.Stop(); }),
  });
  begin(server.Address());
  server.Run(stop_fd);
}

}  // namespace cdb::serve
