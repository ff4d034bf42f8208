// SPDX-License-Identifier: MIT
#include "app/live/live_network.h"

#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "app/live/live_feed.h"
#include "app/live/live_message.h"
#include "parallel/background_thread.h"

namespace poise::app {

struct LiveNetwork::Impl {
  /// A browser that is connected.
  struct Browser {
    bool is_sending = false;
    int wrong = 0;  ///< messages
  };

  explicit Impl(LiveLink& both) : link(both) {}
  ~Impl() {
    if (thread) server->stop();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // All on the thread.
  void send_to(ClientId client, Browser& browser) {
    if (browser.is_sending) return;
    const WebMessage message = feed->next(client);
    if (!message) return;
    browser.is_sending = true;
    server->send(client, message);
  }
  void send_all() {
    for (auto& [client, browser] : browsers) send_to(client, browser);
  }
  void joined(ClientId client) {
    browsers.emplace(client, Browser{});
    feed->join(client);
    send_all();
  }
  void left(ClientId client) {
    browsers.erase(client);
    feed->leave(client);
  }
  void sent(ClientId client) {
    const auto found = browsers.find(client);
    if (found == browsers.end()) return;
    found->second.is_sending = false;
    send_to(client, found->second);
  }
  void woken() {
    while (link.records.take(record)) {
      feed->take(record);
      send_all();
    }
  }
  void received(ClientId client, std::string_view text) {
    const auto found = browsers.find(client);
    if (found == browsers.end()) return;
    Browser& browser = found->second;
    const Result<LiveMessage> message = parse_live_message(text);
    if (!message) {
      feed->refuse(client, message.error().message);
      if (++browser.wrong >= kMostWrong) return server->close(client, "too many wrong messages");
    } else if (const auto* shown = std::get_if<FrameShown>(&message.value())) {
      feed->shown(client, shown->number);
    } else {
      LiveRequest request{client, message.value()};
      if (!link.requests.give(request)) feed->refuse(client, "message: too many wait to be done; try again");
    }
    send_to(client, browser);
  }

  LiveLink& link;
  std::optional<WebServer> server;
  std::optional<LiveFeed> feed;
  std::map<ClientId, Browser> browsers;
  LiveRecord record;
  std::optional<parallel::BackgroundThread> thread;  // the last member: it uses the others
};

LiveNetwork::LiveNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LiveNetwork::LiveNetwork(LiveNetwork&&) noexcept = default;
LiveNetwork& LiveNetwork::operator=(LiveNetwork&&) noexcept = default;
LiveNetwork::~LiveNetwork() = default;

Result<LiveNetwork> LiveNetwork::open(const WebSettings& settings, LiveLink& link) {
  auto impl = std::make_unique<Impl>(link);
  Impl* const at = impl.get();
  WebEvents events;
  events.joined = [at](ClientId client) { at->joined(client); };
  events.left = [at](ClientId client) { at->left(client); };
  events.message = [at](ClientId client, std::string_view text) { at->received(client, text); };
  events.sent = [at](ClientId client) { at->sent(client); };
  events.woken = [at] { at->woken(); };
  Result<WebServer> server = WebServer::open(settings, std::move(events));
  if (!server) return server.error();
  impl->server.emplace(std::move(server).value());
  return LiveNetwork(std::move(impl));
}

std::uint16_t LiveNetwork::port() const { return impl_->server->port(); }

void LiveNetwork::begin(const capture::CaptureHeader& header) {
  impl_->feed.emplace(header);
  impl_->thread.emplace([impl = impl_.get()] { impl->server->run(); });
}

void LiveNetwork::wake() { impl_->server->wake(); }

}  // namespace poise::app
