// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>

#include "app/live/live_record.h"
#include "app/live/web_server.h"
#include "capture/capture.h"
#include "poise/result.h"

namespace poise::app {

/// The network of a live run, on a thread of its own: sends what the link brings to browsers, and brings what they ask
/// for. Invariant: the thread runs from begin() to the end of this.
class LiveNetwork {
 public:
  /// Wrong messages of a browser after which its connection is closed. Chosen.
  static constexpr int kMostWrong = 20;

  /// Begins to listen. `link` must live longer. Refused as WebServer::open.
  static Result<LiveNetwork> open(const WebSettings& settings, LiveLink& link);
  LiveNetwork(LiveNetwork&&) noexcept;
  LiveNetwork& operator=(LiveNetwork&&) noexcept;
  ~LiveNetwork();

  [[nodiscard]] std::uint16_t port() const;
  /// Starts the thread; once.
  void begin(const capture::CaptureHeader& header);
  /// Something was put into the link. Never waits.
  void wake();

 private:
  struct Impl;
  explicit LiveNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace poise::app
