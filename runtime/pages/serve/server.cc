#include "runtime/pages/serve/server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <poll.h>

#include <array>
#include <atomic>
#include <mutex>
#include <nlohmann/json.hpp>
#include <random>
#include <system_error>
#include <thread>

#include "runtime/pages/page/page.h"

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

}  // namespace cdb::serve
