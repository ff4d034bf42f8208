// SPDX-License-Identifier: MIT
#include "app/live/live_network.h"

#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "capture/captures.h"

namespace poise::app {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;

const std::string kToken = "0123456789abcdef0123456789abcdef";

/// A network with a link that the test holds the other end of.
struct Served {
  Served() : network(LiveNetwork::open(settings(), link).value()), frames(testing::some_frames(1, 2, 20)) {
    network.begin(testing::some_header());
  }
  static WebSettings settings() {
    WebSettings made;
    made.token = kToken;
    made.page = "<p>the page</p>";
    return made;
  }
  [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(network.port()); }
  [[nodiscard]] tcp::endpoint endpoint() const { return {asio::ip::make_address("127.0.0.1"), network.port()}; }

  /// The answer to a request with this host.
  http::response<http::string_body> get(const std::string& target, const std::string& named,
                                        http::verb method = http::verb::get) {
    return answer(http::request<http::empty_body>(method, target, 11), named);
  }
  /// What one is told who asks for a WebSocket.
  unsigned upgrade(const std::string& target, const std::string& origin) {
    http::request<http::empty_body> request(http::verb::get, target, 11);
    request.set(http::field::upgrade, "websocket");
    request.set(http::field::connection, "upgrade");
    request.set(http::field::sec_websocket_key, "dGhlIHNhbXBsZSBub25jZQ==");
    request.set(http::field::sec_websocket_version, "13");
    request.set(http::field::origin, origin);
    return answer(std::move(request), host()).result_int();
  }
  http::response<http::string_body> answer(http::request<http::empty_body> request, const std::string& named) {
    asio::io_context context;
    beast::tcp_stream stream(context);
    stream.connect(endpoint());
    request.set(http::field::host, named);
    http::write(stream, request);
    beast::flat_buffer buffer;
    http::response<http::string_body> response;
    http::read(stream, buffer, response);
    return response;
  }

  /// Hands a frame over as soon as there is room.
  void give(std::uint64_t number) {
    LiveRecord record;
    record.run = 1;
    record.has_frame = true;
    record.frame = frames[given++ == 0 ? 0 : 1];
    if (given > 1) record.frame.new_bodies.clear();
    record.frame.bodies = frames[0].bodies;
    record.frame.facts.frame = number;
    while (!link.records.give(record)) network.wake();
    network.wake();
  }

  LiveLink link;
  LiveNetwork network;
  std::vector<capture::SeenFrame> frames;
  std::uint64_t given = 0;
};

/// A browser that says and reads one thing after the other.
class Browser {
 public:
  explicit Browser(const Served& served) : stream_(context_) {
    beast::get_lowest_layer(stream_).connect(served.endpoint());
    stream_.set_option(websocket::stream_base::decorator(
        [&](websocket::request_type& request) { request.set(http::field::origin, "http://" + served.host()); }));
    stream_.handshake(served.host(), "/" + kToken + "/socket", failure_);
  }
  [[nodiscard]] bool is_open() const { return !failure_; }
  void say(const std::string& text) { stream_.write(asio::buffer(text), failure_); }
  void say_bytes(const std::string& bytes) {
    stream_.binary(true);
    say(bytes);
    stream_.text(true);
  }
  /// The next message; empty once the connection has ended.
  std::string next() {
    beast::flat_buffer buffer;
    stream_.read(buffer, failure_);
    return failure_ ? "" : beast::buffers_to_string(buffer.data());
  }
  /// The next message that begins with this.
  std::string next(const std::string& begin) {
    for (;;) {
      std::string message = next();
      if (failure_ || message.rfind(begin, 0) == 0) return message;
    }
  }
  /// Ends the connection at once, whatever is under way.
  void cut() {
    beast::error_code ignored;
    tcp::socket& socket = beast::get_lowest_layer(stream_).socket();
    socket.set_option(asio::socket_base::linger(true, 0), ignored);
    socket.close(ignored);
  }
  [[nodiscard]] std::string reason() const { return {stream_.reason().reason.data(), stream_.reason().reason.size()}; }

 private:
  asio::io_context context_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::error_code failure_;
};

std::uint32_t number_of(const std::string& frame) {
  std::uint32_t number = 0;
  std::memcpy(&number, frame.data() + 8, sizeof(number));
  return number;
}
std::string shown(const std::string& frame) {
  return R"({"do": "shown", "number": )" + std::to_string(number_of(frame)) + "}";
}

TEST(LiveNetwork, ServesThePageToThoseWhoKnowItsAddress) {
  Served served;
  const auto page = served.get("/" + kToken + "/", served.host());
  EXPECT_EQ(page.result_int(), 200U);
  EXPECT_EQ(page.body(), "<p>the page</p>");
  EXPECT_EQ(page[http::field::cache_control], "no-store");
  EXPECT_EQ(page["Referrer-Policy"], "no-referrer");
  EXPECT_NE(page["Content-Security-Policy"].find("connect-src 'self' ws://" + served.host()), std::string::npos);
  EXPECT_EQ(served.get("/", served.host()).result_int(), 404U);
  EXPECT_EQ(served.get("/" + std::string(32, '0') + "/", served.host()).result_int(), 404U);
  EXPECT_EQ(served.get("/" + kToken + "/", "evil.example").result_int(), 403U);
  EXPECT_EQ(served.get("/" + kToken + "/", served.host(), http::verb::delete_).result_int(), 405U);
}

TEST(LiveNetwork, LetsNoForeignPageIn) {
  Served served;
  const std::string socket = "/" + kToken + "/socket", own = "http://" + served.host();
  EXPECT_EQ(served.upgrade(socket, "http://evil.example"), 403U);
  EXPECT_EQ(served.upgrade(socket, "null"), 403U);
  EXPECT_EQ(served.upgrade("/" + std::string(32, '0') + "/socket", own), 404U);
  EXPECT_EQ(served.upgrade(socket, own), 101U);
}

TEST(LiveNetwork, BringsWhatABrowserAsksForToTheRun) {
  Served served;
  Browser browser(served);
  browser.say(R"({"do": "deadline", "ms": 4})");
  LiveRequest request;
  while (!served.link.requests.take(request)) {
  }
  EXPECT_EQ(std::get<SetDeadline>(request.message).ms, 4);
  served.give(0);
  LiveRecord record;
  record.run = 1;
  record.replies.push_back({request.client, "message: refused"});
  while (!served.link.records.give(record)) {
  }
  served.network.wake();
  EXPECT_EQ(browser.next("{\"error"), R"({"error":"message: refused"})");
}

TEST(LiveNetwork, AnswersWrongMessagesAndClosesAfterMany) {
  Served served;
  Browser browser(served);
  for (int i = 0; i < LiveNetwork::kMostWrong - 1; ++i) {
    browser.say(R"({"do": "deadline", "ms": -1})");
    EXPECT_EQ(browser.next("{\"error"), R"({"error":"message: ms = -1, must be > 0"})");
  }
  LiveRequest request;
  EXPECT_FALSE(served.link.requests.take(request));
  browser.say(std::string(5000, ' '));
  while (browser.is_open()) browser.next();
  EXPECT_EQ(browser.reason(), "too many wrong messages");
  // Others are served as before.
  Browser other(served);
  other.say("{");
  EXPECT_NE(other.next("{\"error").find("not valid JSON"), std::string::npos);
}

TEST(LiveNetwork, ClosesOnBytesAndOnMessagesWithoutEnd) {
  Served served;
  for (const bool is_text : {false, true}) {
    Browser browser(served);
    if (is_text) {
      browser.say(std::string(1 << 20, ' '));
    } else {
      browser.say_bytes("abc");
    }
    while (browser.is_open()) browser.next();
  }
  EXPECT_TRUE(Browser(served).is_open());
}

TEST(LiveNetwork, TwoBrowsersSeeTheSame) {
  Served served;
  Browser first(served), second(served);
  EXPECT_EQ(first.next("HEAD"), second.next("HEAD"));
  for (std::uint64_t number = 0; number < 20; ++number) served.give(number);
  for (std::uint64_t number = 0; number < 20; ++number) {
    const std::string frame = first.next("FRAM");
    EXPECT_FALSE(frame.empty());
    EXPECT_EQ(second.next("FRAM"), frame);
  }
}

TEST(LiveNetwork, OneThatNeverReadsStopsNeitherTheRunNorTheOthers) {
  Served served;
  const Browser stuck(served);
  Browser browser(served);
  browser.next("HEAD");
  constexpr std::uint64_t kFrames = 500;
  std::uint32_t last = 0;
  served.give(0);
  for (std::uint64_t frame = 1; frame < kFrames; ++frame) {
    const std::string got = browser.next("FRAM");
    ASSERT_FALSE(got.empty());
    last = number_of(got);
    browser.say(shown(got));
    served.give(frame);
  }
  EXPECT_EQ(last, kFrames - 2) << "every frame came";
}

TEST(LiveNetwork, OneThatComesBackBeginsAnew) {
  Served served;
  for (int again = 0; again < 3; ++again) {
    Browser browser(served);
    ASSERT_FALSE(browser.next("HEAD").empty());
    for (std::uint64_t i = 0; i < 20; ++i) served.give(served.given);
    ASSERT_FALSE(browser.next("BODY").empty());
    const std::string frame = browser.next("FRAM");
    ASSERT_FALSE(frame.empty());
    EXPECT_EQ(frame[4], 1) << "it can be read alone";
  }
}

TEST(LiveNetwork, ThoseThatAreGoneAmidTheirMessagesEndNothing) {
  Served served;
  for (int again = 0; again < 200; ++again) {
    Browser browser(served);
    ASSERT_FALSE(browser.next("HEAD").empty());
    served.give(served.given);
    for (int message = 0; message < 10; ++message) browser.say(R"({"do": "shown", "number": 0})");
    served.give(served.given);
    browser.cut();
  }
  EXPECT_TRUE(Browser(served).is_open());
}

TEST(LiveNetwork, IsRefusedWhereItsPortIsTaken) {
  Served served;
  WebSettings settings = Served::settings();
  settings.port = served.network.port();
  LiveLink link;
  const Result<LiveNetwork> second = LiveNetwork::open(settings, link);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().message,
            "address 127.0.0.1, port " + std::to_string(settings.port) + ": cannot be served: Address already in use");
}

}  // namespace
}  // namespace poise::app
