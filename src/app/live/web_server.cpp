// SPDX-License-Identifier: MIT
#include "app/live/web_server.h"

#include <fmt/format.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cerrno>
#include <chrono>
#include <map>
#include <optional>
#include <system_error>
#include <utility>

#include "app/live/live_message.h"
#include "app/live/request_check.h"

namespace poise::app {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using boost::system::error_code;

/// A client that does not finish its request by then is let go.
constexpr std::chrono::seconds kRequestTime{10};
constexpr std::uint32_t kMostHeaderBytes = 8192;
constexpr std::chrono::milliseconds kPause{100};
/// Larger messages end the connection; those that are too large but not this are answered.
constexpr std::size_t kMostReadBytes = 4 * kMostMessageBytes;

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

RequestHead head_of(const http::request<http::empty_body>& request) {
  RequestHead head;
  head.method = view_of(request.method_string());
  head.target = view_of(request.target());
  head.host = view_of(request[http::field::host]);
  if (request.count(http::field::origin) > 0) head.origin = view_of(request[http::field::origin]);
  // Of several, none can be trusted.
  if (request.count(http::field::host) != 1 || request.count(http::field::origin) > 1) head.host = {};
  head.upgrade = websocket::is_upgrade(request);
  return head;
}

}  // namespace

struct WebServer::Impl {
  class Connection;

  Impl(const WebSettings& wanted, WebEvents told)
      : page(wanted.page), events(std::move(told)), acceptor(context), pause(context), wakes(context), stops(context) {}

  Status listen(const WebSettings& wanted);
  void accept();
  void wait_for_wake();
  void wait_for_stop();
  void end();

  // What handlers use that still wait when the context ends stands before it.
  std::string page;
  WebEvents events;
  std::optional<RequestCheck> check;
  std::uint16_t port = 0;
  std::size_t connections = 0;
  ClientId next_client = 1;
  std::map<ClientId, Connection*> clients;
  asio::io_context context{1};
  tcp::acceptor acceptor;
  asio::steady_timer pause;
  asio::posix::stream_descriptor wakes, stops;  // counters of the system, which any thread may raise
};

/// One connection: a request, its answer, and after an upgrade messages both ways. It lives as long as something of it
/// is under way.
class WebServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Impl& server, tcp::socket socket) : server_(server), socket_(std::move(socket)) { ++server_.connections; }
  ~Connection() {
    --server_.connections;
    leave();
  }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void begin() {
    beast::get_lowest_layer(socket_).expires_after(kRequestTime);
    parser_.header_limit(kMostHeaderBytes);
    parser_.body_limit(0);
    http::async_read_header(socket_.next_layer(), buffer_, parser_,
                            [self = shared_from_this()](error_code failure, std::size_t) {
                              if (!failure) self->answer();
                            });
  }

  void send(const WebMessage& message) {
    sending_ = message;
    socket_.text(message->is_text);
    socket_.async_write(asio::buffer(sending_->bytes), [self = shared_from_this()](error_code failure, std::size_t) {
      self->sending_.reset();
      if (failure) return self->drop();
      if (self->closing_) return self->close_now();
      if (self->client_ != 0) self->server_.events.sent(self->client_);
    });
  }

  void close(std::string_view reason) {
    if (closing_) return;
    closing_ =
        websocket::close_reason(websocket::close_code::policy_error, beast::string_view(reason.data(), reason.size()));
    leave();
    if (!sending_) close_now();
  }

  /// Ends it at once.
  void drop() {
    leave();
    error_code ignored;
    beast::get_lowest_layer(socket_).socket().close(ignored);
  }

 private:
  void answer() {
    switch (server_.check->answer(head_of(parser_.get()))) {
      case RequestAnswer::Socket:
        return server_.clients.size() < kMostClients
                   ? upgrade()
                   : respond(http::status::service_unavailable, "too many browsers\n");
      case RequestAnswer::Page:
        return respond(http::status::ok, server_.page);
      case RequestAnswer::Forbidden:
        return respond(http::status::forbidden, "not from here\n");
      case RequestAnswer::WrongMethod:
        return respond(http::status::method_not_allowed, "GET alone\n");
      case RequestAnswer::NotFound:
        return respond(http::status::not_found, "nothing here\n");
    }
  }

  void respond(http::status status, const std::string& text) {
    auto response = std::make_shared<http::response<http::string_body>>(status, 11);
    response->set(http::field::content_type,
                  status == http::status::ok ? "text/html; charset=utf-8" : "text/plain; charset=utf-8");
    response->set(http::field::cache_control, "no-store");
    response->set("Referrer-Policy", "no-referrer");
    response->set("X-Content-Type-Options", "nosniff");
    response->set("Cross-Origin-Resource-Policy", "same-origin");
    response->set("Cross-Origin-Opener-Policy", "same-origin");
    // Some browsers do not count a WebSocket of the own origin as 'self'.
    const beast::string_view host = parser_.get()[http::field::host];
    const std::string own = status == http::status::ok ? " ws://" + std::string(host) : std::string();
    response->set("Content-Security-Policy",
                  "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
                  "frame-ancestors 'none'; base-uri 'none'; form-action 'none'; connect-src 'self'" +
                      own);
    response->keep_alive(false);
    response->body() = text;
    response->prepare_payload();
    http::async_write(socket_.next_layer(), *response, [self = shared_from_this(), response](error_code, std::size_t) {
      error_code ignored;
      self->socket_.next_layer().socket().shutdown(tcp::socket::shutdown_send, ignored);
    });
  }

  void upgrade() {
    beast::get_lowest_layer(socket_).expires_never();
    socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
    socket_.read_message_max(kMostReadBytes);
    socket_.auto_fragment(false);
    socket_.async_accept(parser_.get(), [self = shared_from_this()](error_code failure) {
      if (failure) return;
      error_code ignored;
      self->socket_.next_layer().socket().set_option(tcp::no_delay(true), ignored);
      self->client_ = self->server_.next_client++;
      self->server_.clients.emplace(self->client_, self.get());
      self->buffer_.clear();
      self->read();
      self->server_.events.joined(self->client_);
    });
  }

  void read() {
    socket_.async_read(buffer_, [self = shared_from_this()](error_code failure, std::size_t) {
      if (failure) return self->drop();
      if (self->closing_) {
        self->buffer_.clear();
        return self->read();
      }
      // A write that failed has let it go while this message waited.
      if (self->client_ == 0) return;
      const asio::const_buffer data = self->buffer_.cdata();
      if (self->socket_.got_text()) {
        self->server_.events.message(self->client_, {static_cast<const char*>(data.data()), data.size()});
      } else {
        self->close("messages are text");
      }
      self->buffer_.clear();
      self->read();
    });
  }

  void close_now() {
    socket_.async_close(*closing_, [self = shared_from_this()](error_code) {});
  }

  void leave() {
    if (client_ == 0) return;
    const ClientId left = std::exchange(client_, 0);
    server_.clients.erase(left);
    server_.events.left(left);
  }

  Impl& server_;
  websocket::stream<beast::tcp_stream> socket_;
  beast::flat_buffer buffer_;
  http::request_parser<http::empty_body> parser_;
  WebMessage sending_;
  std::optional<websocket::close_reason> closing_;
  ClientId client_ = 0;  // 0: not yet, or not any more
};

Status WebServer::Impl::listen(const WebSettings& wanted) {
  const int wake = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  const int stop = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  if (wake >= 0) wakes.assign(wake);
  if (stop >= 0) stops.assign(stop);
  if (wake < 0 || stop < 0)
    return Error{ErrorKind::OutputFailed,
                 fmt::format("nothing can be served: {}", std::generic_category().message(errno))};
  error_code failure;
  const asio::ip::address address = asio::ip::make_address(wanted.address, failure);
  const tcp::endpoint at(address, wanted.port);
  if (!failure) acceptor.open(at.protocol(), failure);
  if (!failure) acceptor.set_option(tcp::acceptor::reuse_address(true), failure);
  if (!failure) acceptor.bind(at, failure);
  if (!failure) acceptor.listen(tcp::acceptor::max_listen_connections, failure);
  if (failure) {
    return Error{ErrorKind::OutputFailed, fmt::format("address {}, port {}: cannot be served: {}", wanted.address,
                                                      wanted.port, failure.message())};
  }
  port = acceptor.local_endpoint().port();
  check.emplace(wanted.token, wanted.address, port);
  return Done{};
}

void WebServer::Impl::accept() {
  acceptor.async_accept([this](error_code failure, tcp::socket socket) {
    if (!acceptor.is_open()) return;
    // One that is too many is closed by its end here.
    if (!failure && connections < kMostConnections) std::make_shared<Connection>(*this, std::move(socket))->begin();
    if (!failure) return accept();
    // The system has no room for more.
    pause.expires_after(kPause);
    pause.async_wait([this](error_code) { accept(); });
  });
}

void WebServer::Impl::wait_for_wake() {
  wakes.async_wait(asio::posix::stream_descriptor::wait_read, [this](error_code failure) {
    if (failure) return;
    std::uint64_t count = 0;
    if (::read(wakes.native_handle(), &count, sizeof(count)) > 0) events.woken();
    wait_for_wake();
  });
}

void WebServer::Impl::wait_for_stop() {
  stops.async_wait(asio::posix::stream_descriptor::wait_read, [this](error_code failure) {
    if (!failure) end();
  });
}

void WebServer::Impl::end() {
  error_code ignored;
  acceptor.close(ignored);
  wakes.close(ignored);
  stops.close(ignored);
  while (!clients.empty()) clients.begin()->second->drop();
  context.stop();
}

WebServer::WebServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebServer::WebServer(WebServer&&) noexcept = default;
WebServer& WebServer::operator=(WebServer&&) noexcept = default;
WebServer::~WebServer() = default;

Result<WebServer> WebServer::open(const WebSettings& settings, WebEvents events) {
  auto impl = std::make_unique<Impl>(settings, std::move(events));
  const Status listening = impl->listen(settings);
  if (!listening) return listening.error();
  return WebServer(std::move(impl));
}

std::uint16_t WebServer::port() const { return impl_->port; }

void WebServer::run() {
  impl_->accept();
  impl_->wait_for_wake();
  impl_->wait_for_stop();
  impl_->context.run();
}

namespace {
void raise(asio::posix::stream_descriptor& counter) {
  const std::uint64_t one = 1;
  // It fails only where it was raised 2^64 times before.
  [[maybe_unused]] const ssize_t written = ::write(counter.native_handle(), &one, sizeof(one));
}
}  // namespace

void WebServer::wake() { raise(impl_->wakes); }
void WebServer::stop() { raise(impl_->stops); }

void WebServer::send(ClientId client, const WebMessage& message) {
  if (const auto found = impl_->clients.find(client); found != impl_->clients.end()) found->second->send(message);
}

void WebServer::close(ClientId client, std::string_view reason) {
  if (const auto found = impl_->clients.find(client); found != impl_->clients.end()) found->second->close(reason);
}

}  // namespace poise::app
