#include "runtime/pages/serve/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <system_error>
#include <thread>
#include <utility>

#include "compiler/plan/input_file.h"
#include "compiler/schema/schema.h"
#include "dsl/diagnostics.h"
#include "dsl/parser.h"
#include "runtime/pages/page/page.h"
#include "runtime/pages/view/scene_document.h"
#include "runtime/results/files/safe_file.h"
#include "runtime/results/store.h"

namespace cdb::serve {
namespace {

using httplib::Request;
using httplib::Response;

constexpr const char* kLoopback = "127.0.0.1";
constexpr std::size_t kMaxRequest = 16'000'000;  // bytes

std::string MakeToken() {
  std::random_device device;  // of the processor or the operating system
  std::string token;
  for (int i = 0; i < 4; ++i) token += fmt::format("{:08x}", device());
  return token;
}

class Server {
 public:
  explicit Server(Editor& editor) : editor_(editor) {
    server_.set_payload_max_length(kMaxRequest);
    server_.set_keep_alive_max_count(1);  // the end must not wait for a browser
    port_ = server_.bind_to_any_port(kLoopback);
    if (port_ <= 0)
      throw std::system_error(errno, std::generic_category(), "no port of the loopback interface");
    AddRoutes();
  }

  std::string Address() const { return fmt::format("http://{}:{}/{}/", kLoopback, port_, token_); }
  void Listen() { server_.listen_after_bind(); }
  void Stop() { server_.stop(); }

 private:
  void AddRoutes() {
    // The browser treats another host name for this machine as another site.
    server_.set_pre_routing_handler([this](const Request& request, Response& response) {
      if (request.get_header_value("Host") == fmt::format("{}:{}", kLoopback, port_))
        return HttpServer::HandlerResponse::Unhandled;
      response.status = 403;
      return HttpServer::HandlerResponse::Handled;
    });
    server_.Get("/" + token_ + "/", [this](const Request&, Response& response) {
      const std::lock_guard lock(mutex_);
      response.set_header("Referrer-Policy", "no-referrer");
      response.set_header("X-Frame-Options", "DENY");
      response.set_header("X-Content-Type-Options", "nosniff");
      response.set_header("Cache-Control", "no-store");
      response.set_content(page::Assemble(page::ViewTemplate(), "cdb view", editor_.Document()),
                           "text/html; charset=utf-8");
    });
    Answer("check", [](Editor& editor, const nlohmann::json& asked) {
      return editor.Check(asked.at("text"));
    });
    Answer("set", [](Editor& editor, const nlohmann::json& asked) {
      return editor.Set(asked.at("text"), asked.at("group"), asked.at("name"), asked.at("value"));
    });
    Answer("save", [](Editor& editor, const nlohmann::json& asked) {
      return editor.Save(asked.at("text"));
    });
    Answer("run", [](Editor& editor, const nlohmann::json& asked) {
      return editor.Run(asked.at("text"));
    });
    Answer("progress", [](Editor& editor, const nlohmann::json&) { return editor.Progress(); });
    Answer("stop", [](Editor& editor, const nlohmann::json&) { return editor.Stop(); });
  }

  /// Takes JSON and answers in JSON.
  template <typename Act>
  void Answer(const std::string& name, Act act) {
    server_.Post("/" + token_ + "/" + name, [this, act](const Request& asked, Response& response) {
      const std::lock_guard lock(mutex_);
      try {
        response.set_content(act(editor_, nlohmann::json::parse(asked.body)), "application/json");
      } catch (const nlohmann::json::exception&) {
        response.status = 400;
      } catch (const std::exception& error) {
        response.set_content(nlohmann::json{{"message", error.what()}}.dump(
                                 -1, ' ', false, nlohmann::json::error_handler_t::replace),
                             "application/json");
      }
    });
  }

  using HttpServer = httplib::Server;
  Editor& editor_;
  const std::string token_ = MakeToken();
  std::mutex mutex_;
  HttpServer server_;
  int port_ = 0;
};

}  // namespace

void Serve(Editor& editor, int stop_fd, const std::function<void(const std::string&)>& begin) {
  Server server(editor);
  std::atomic<bool> has_ended = false;
  std::thread listener([&] {
    server.Listen();
    has_ended = true;
  });
  begin(server.Address());
  while (!has_ended) {
    pollfd stop{stop_fd, POLLIN, 0};
    if (::poll(&stop, 1, 500) > 0) break;
  }
  server.Stop();
  listener.join();
}

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

/// A benchmark, with the syntax tree that owns it.
class ParsedBenchmark {
 public:
  ParsedBenchmark(const std::string& text, const std::string& name) {
    dsl::Diagnostics diagnostics;
    file_ = dsl::Parse(std::make_shared<const text::Source>("scenario", text), diagnostics);
    if (diagnostics.has_errors()) throw EditError(dsl::Render(diagnostics));
    for (const auto& item : file_.items)
      if (const auto* found = std::get_if<dsl::Benchmark>(&item);
          found != nullptr && found->name.text == name)
        benchmark_ = found;
    if (benchmark_ == nullptr)
      throw EditError(fmt::format("the text no longer has a benchmark '{}'", name));
    Visit(benchmark_->block, "", "");
  }

  struct Group {
    std::string name;
    const dsl::Block* block;
  };
  struct Written {
    std::string group, path;
    const dsl::Setting* setting;
  };

  const std::vector<Group>& groups() const { return groups_; }
  const dsl::Block& block() const { return benchmark_->block; }
  std::string_view text() const { return file_.source->text(); }

  /// The last setting of a parameter; null if there is none.
  const dsl::Setting* Find(const Place& place) const {
    const dsl::Setting* found = nullptr;
    for (const auto& [group, path, setting] : written_)
      if ((group == place.group && path == place.name) ||
          (group.empty() && !place.group.empty() && path == place.group + "." + place.name))
        found = setting;
    return found;
  }

 private:
  void Visit(const dsl::Block& block, const std::string& group, const std::string& prefix) {
    for (const dsl::Statement& statement : block.statements) {
      if (const auto* setting = std::get_if<dsl::Setting>(&statement.what)) {
        written_.push_back({group, prefix + setting->path.text, setting});
      } else if (const auto* inner = std::get_if<dsl::Group>(&statement.what)) {
        if (inner->kind.text == "objects") {
          groups_.push_back({inner->label ? inner->label->text : "objects", &inner->block});
          Visit(inner->block, groups_.back().name, "");
        } else {
          Visit(inner->block, group, prefix + inner->kind.text + ".");
        }
      }
    }
  }

  dsl::File file_;
  const dsl::Benchmark* benchmark_ = nullptr;
  std::vector<Group> groups_;
  std::vector<Written> written_;
};

/// The range of bytes of a setting's values.
std::pair<std::size_t, std::size_t> ValueRange(const dsl::Setting& setting) {
  return {setting.values.front()->span.begin, setting.values.back()->span.end};
}

/// Inserts a statement before the closing brace of the block.
std::string Inserted(std::string_view text, const dsl::Block& block, const std::string& statement) {
  const std::size_t brace = block.span.end - 1;
  std::string before(text.substr(0, brace)), after(text.substr(brace));
  const std::string_view inside = text.substr(block.span.begin, brace - block.span.begin);
  if (inside.find('\n') == std::string_view::npos) {
    while (before.ends_with(' ')) before.pop_back();
    const char* separator = block.statements.empty() ? " " : "; ";
    return before + separator + statement + " " + after;
  }
  const std::size_t line = before.rfind('\n') + 1;
  const std::string indent = before.substr(line);
  const bool is_alone = indent.find_first_not_of(" \t") == std::string::npos;
  if (!is_alone) return before + "\n  " + statement + "\n" + after;
  return before.substr(0, line) + indent + "  " + statement + "\n" + indent + after;
}

}  // namespace

std::vector<std::string> GroupsIn(const std::string& text, const std::string& benchmark) {
  std::vector<std::string> names;
  const ParsedBenchmark parsed(text, benchmark);
  for (const ParsedBenchmark::Group& group : parsed.groups()) names.push_back(group.name);
  return names;
}

std::optional<std::string> WrittenValue(const std::string& text, const std::string& benchmark,
                                        const Place& place) {
  const ParsedBenchmark parsed(text, benchmark);
  const dsl::Setting* setting = parsed.Find(place);
  if (setting == nullptr) return std::nullopt;
  const auto [begin, end] = ValueRange(*setting);
  return std::string(parsed.text().substr(begin, end - begin));
}

std::string WithValue(const std::string& text, const std::string& benchmark, const Place& place,
                      const std::string& value) {
  if (value.find_first_not_of(" \t") == std::string::npos ||
      value.find_first_of("\r\n") != std::string::npos)
    throw EditError(fmt::format("{} needs a value, on one line", place.name));
  const ParsedBenchmark parsed(text, benchmark);
  if (const dsl::Setting* setting = parsed.Find(place)) {
    const auto [begin, end] = ValueRange(*setting);
    return std::string(parsed.text().substr(0, begin)) + value +
           std::string(parsed.text().substr(end));
  }
  const std::string statement = place.name + " " + value;
  if (place.group.empty()) return Inserted(parsed.text(), parsed.block(), statement);
  const auto group = std::ranges::find(parsed.groups(), place.group, &ParsedBenchmark::Group::name);
  if (group == parsed.groups().end())
    throw EditError(
        fmt::format("benchmark '{}' does not define the group '{}': write {}.{} {} in it",
                    benchmark, place.group, place.group, place.name, value));
  return Inserted(parsed.text(), *group->block, statement);
}

}  // namespace cdb::serve
