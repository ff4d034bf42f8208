// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::app {

/// A browser that is connected; numbers are not given again.
using ClientId = std::uint64_t;

/// Bytes for browsers, shared by those they are sent to.
struct WebBytes {
  bool is_text = false;
  std::string bytes;
};
using WebMessage = std::shared_ptr<const WebBytes>;

struct WebSettings {
  std::string address = "127.0.0.1";  ///< as plain_address() writes it
  std::uint16_t port = 0;             ///< 0: any that is free
  std::string token;                  ///< the first part of each path
  std::string page;                   ///< HTML
};

/// What the server tells, on the thread that runs it. None may be empty, and none may throw.
struct WebEvents {
  std::function<void(ClientId)> joined;
  std::function<void(ClientId)> left;  ///< once for each that joined
  std::function<void(ClientId, std::string_view text)> message;
  std::function<void(ClientId)> sent;  ///< what was given to send() has been sent
  std::function<void()> woken;         ///< after one or more calls of wake()
};

/// Serves a page at `/TOKEN/` and WebSockets at `/TOKEN/socket` (request_check.h says to whom). The only part that
/// knows how: Boost.Beast. Invariant: at most kMostClients WebSockets and kMostConnections connections are open.
///
/// One thread runs it, and gets all events; the methods but wake() and stop() are that thread's, from events.
class WebServer {
 public:
  static constexpr std::size_t kMostClients = 16;
  static constexpr std::size_t kMostConnections = 64;

  /// Begins to listen. Refused: an address or port that cannot be bound.
  static Result<WebServer> open(const WebSettings& settings, WebEvents events);
  WebServer(WebServer&&) noexcept;
  WebServer& operator=(WebServer&&) noexcept;
  ~WebServer();

  [[nodiscard]] std::uint16_t port() const;
  /// Serves until stop().
  void run();
  /// Any thread; neither waits for anything.
  void wake();
  void stop();

  /// Sends to a client, to which nothing may be being sent: one message until `sent`.
  void send(ClientId client, const WebMessage& message);
  /// Closes the connection of a client, which is told the reason (at most 100 bytes).
  void close(ClientId client, std::string_view reason);

 private:
  struct Impl;
  explicit WebServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace poise::app
