#include "runtime/pages/serve/http.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <memory>
#include <optional>
#include <random>
#include <thread>

#include "tests/runtime/pages/serve/client.h"

namespace cdb::tests {
namespace {

using ::testing::HasSubstr;
using std::chrono_literals::operator""ms;

/// A server in a thread, with a page and an echo.
class HttpTest : public ::testing::Test {
 protected:
  void Start(const serve::HttpLimits& limits = {}) {
    server_.emplace(
        std::vector<serve::Route>{
            {"GET", "",
             [](const std::string&) {
               return serve::Reply{200, "text/html", "the page"};
             }},
            {"POST", "echo",
             [this](const std::string& body) {
               ++answered_;
               return serve::Reply{200, "text/plain", body};
             }},
            {"POST", "large",
             [](const std::string&) {
               return serve::Reply{200, "text/plain", std::string(30'000'000, 'x')};
             }}},
        limits);
    address_.emplace(server_->Address());
    thread_ = std::thread([this] { server_->Run(stop_.get()); });
  }
  void Stop() {
    if (!thread_.joinable()) return;
    const std::uint64_t one = 1;
    ASSERT_EQ(write(stop_.get(), &one, sizeof one), static_cast<ssize_t>(sizeof one));
    thread_.join();
  }
  void TearDown() override { Stop(); }

  std::string Ask(const std::string& request) { return RawClient(*address_).Ask(request); }
  std::string Head(const std::string& line, const std::string& fields = "") const {
    return line + " HTTP/1.1\r\nHost: " + address_->host + "\r\n" + fields + "\r\n";
  }
  std::string Echoed(const std::string& body) { return BodyOf(Ask(Post(*address_, "echo", body))); }

  plan::Descriptor stop_{eventfd(0, EFD_CLOEXEC)};
  std::optional<serve::HttpServer> server_;
  std::optional<Address> address_;
  std::thread thread_;
  int answered_ = 0;  ///< read it after Stop
};

TEST_F(HttpTest, AnswersInPartsAndWhole) {
  Start();
  EXPECT_EQ(BodyOf(Ask(Head("GET " + address_->path))), "the page");
  EXPECT_EQ(Echoed(""), "");
  EXPECT_EQ(Echoed(std::string(3'000'000, 'a')), std::string(3'000'000, 'a'));
  RawClient client(*address_);
  for (const char c : Post(*address_, "echo", "slow")) ASSERT_TRUE(client.Send({&c, 1}));
  EXPECT_EQ(BodyOf(client.ReadAll()), "slow");
  EXPECT_EQ(BodyOf(Ask(Post(*address_, "large", ""))).size(), 30'000'000u);
  EXPECT_THAT(
      Ask(Head("POST " + address_->path + "echo", "Expect: 100-continue\r\nContent-Length: 0\r\n")),
      HasSubstr("HTTP/1.1 200"));
}

// The head is refused although the body that it announces never comes.
TEST_F(HttpTest, RefusesTheHeadWithoutReadingTheBody) {
  Start();
  const auto status = [&](const std::string& line, const std::string& fields) {
    return StatusOf(Ask(Head(line, fields)));
  };
  const std::string echo = "POST " + address_->path + "echo",
                    foreign = "POST /" + std::string(32, '0') + "/echo";
  const std::string long_body = "Content-Length: 4000000\r\n",
                    chunked = "Transfer-Encoding: chunked\r\n";
  EXPECT_EQ(status(foreign, long_body), "404");
  EXPECT_EQ(status(foreign, chunked), "404");
  EXPECT_EQ(status("POST /", long_body), "404");
  EXPECT_EQ(status(echo + "es", long_body), "404");
  EXPECT_EQ(status("PUT " + address_->path + "echo", long_body), "405");
  EXPECT_EQ(status("POST " + address_->path, long_body), "405");
  EXPECT_EQ(status(echo, ""), "411");
  EXPECT_EQ(status(echo, "Content-Length: 4000001\r\n"), "413");
  EXPECT_EQ(status(echo, "Content-Length: 99999999999999999999999\r\n"), "413");
  EXPECT_EQ(status(echo, "Content-Length: -1\r\n"), "400");
  EXPECT_EQ(status(echo, "Content-Length: 5x\r\n"), "400");
  EXPECT_EQ(status(echo, long_body + long_body), "400");
  EXPECT_EQ(status("what is this", long_body), "400");
  EXPECT_EQ(status(echo, " folded\r\n"), "400");
  for (const char* host : {"localhost", "elsewhere.example", ""})
    EXPECT_EQ(StatusOf(Ask(echo + " HTTP/1.1\r\nHost: " + host + "\r\n" + long_body + "\r\n")),
              "403")
        << host;
  EXPECT_THAT(Ask(Head(echo, chunked)),
              HasSubstr("a body in chunks is not read: send Content-Length"));
  EXPECT_THAT(Ask(Head(echo, "Content-Encoding: gzip\r\n" + long_body)),
              HasSubstr("a compressed body is not read"));
  Stop();
  EXPECT_EQ(answered_, 0);
}

// Without the token nothing is kept of a body, however long; the reply arrives although the client
// is still sending.
TEST_F(HttpTest, RefusesWhileTheClientSends) {
  Start();
  RawClient client(*address_);
  ASSERT_TRUE(client.Send(Head("POST /guess/echo", "Content-Length: 500000000\r\n")));
  client.Send(std::string(2'000'000, 'x'));
  ::shutdown(client.fd(), SHUT_WR);
  EXPECT_EQ(StatusOf(client.ReadAll()), "404");
  RawClient endless(*address_);
  ASSERT_TRUE(endless.Send(Head("POST /guess/echo", "Transfer-Encoding: chunked\r\n")));
  while (endless.Send(std::string(1'000'000, 'x')))
    ;  // until it is closed
  EXPECT_EQ(Echoed("next"), "next");
}

TEST_F(HttpTest, RefusesALongHead) {
  Start();
  RawClient client(*address_);
  client.Send("GET /");
  client.Send(std::string(20'000, 'a'));
  EXPECT_EQ(StatusOf(client.ReadAll()), "431");
  EXPECT_EQ(StatusOf(Ask(Head("GET /", "A: " + std::string(20'000, 'a') + "\r\n"))), "431");
}

// Idle connections, more than it keeps, do not hold up a request.
TEST_F(HttpTest, IdleConnectionsDoNotBlockOthers) {
  Start({.reading = std::chrono::hours(1)});
  std::vector<std::unique_ptr<RawClient>> idle;
  for (int i = 0; i < 150; ++i) {
    idle.push_back(std::make_unique<RawClient>(*address_));
    if (i % 3 == 1) idle.back()->Send("POST /");
    if (i % 3 == 2) idle.back()->Send(Post(*address_, "echo", "abc").substr(0, 80));
  }
  EXPECT_EQ(Echoed("through"), "through");
  Stop();  // with all of them connected
}

TEST_F(HttpTest, EachRequestHasADeadline) {
  Start({.reading = 50ms});
  RawClient silent(*address_), partial(*address_);
  partial.Send(Head("POST " + address_->path + "echo", "Content-Length: 10\r\n") + "abc");
  EXPECT_EQ(silent.ReadAll(), "");
  EXPECT_EQ(partial.ReadAll(), "");
}

TEST_F(HttpTest, AReplyThatIsNotReadHasADeadline) {
  Start({.writing = 0ms});
  RawClient deaf(*address_);
  deaf.Send(Post(*address_, "large", ""));
  EXPECT_EQ(Echoed("another"), "another");  // by then, its time is over
  EXPECT_LT(deaf.ReadAll().size(), 30'000'000u);
}

TEST_F(HttpTest, StopsBeforeItRuns) {
  const std::uint64_t one = 1;
  ASSERT_EQ(write(stop_.get(), &one, sizeof one), static_cast<ssize_t>(sizeof one));
  Start();
  thread_.join();
}

TEST_F(HttpTest, SurvivesNoise) {
  Start({.reading = 50ms});
  std::mt19937 random(7);
  const std::string good = Post(*address_, "echo", "body");
  for (int i = 0; i < 300; ++i) {
    std::string request = good;
    for (int k = 0; k < 4; ++k) {
      const std::size_t at = random() % request.size();
      if (random() % 2 == 0)
        request[at] = static_cast<char>(random());
      else
        request.erase(at, random() % 20);
    }
    RawClient client(*address_);
    client.Send(request);
    if (random() % 3 == 0) continue;  // it is closed without reading
    ::shutdown(client.fd(), SHUT_WR);
    client.ReadAll();
  }
  EXPECT_EQ(Echoed("still here"), "still here");
}

}  // namespace
}  // namespace cdb::tests
