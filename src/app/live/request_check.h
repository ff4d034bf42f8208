// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "poise/result.h"

/// Who may talk to a live run: those who know its token, and no page of another origin. Names are checked, so that a
/// foreign name that a server of its owner lets stand for this machine (DNS rebinding) is refused.
namespace poise::app {

/// 128 random bits of the system, as 32 hexadecimal digits. Refused: where the system has none.
Result<std::string> random_token();

/// What a request is answered with.
enum class RequestAnswer : std::uint8_t { Page, Socket, WrongMethod, NotFound, Forbidden };

/// The parts of a request that decide on it.
struct RequestHead {
  std::string_view method, target, host;
  std::optional<std::string_view> origin;
  bool upgrade = false;  ///< asks for a WebSocket
};

/// Decides on requests. Invariant: `token` has at least 32 characters.
class RequestCheck {
 public:
  /// `address`: what the server is bound to, as plain_address() writes it.
  RequestCheck(std::string token, std::string address, std::uint16_t port)
      : token_(std::move(token)), address_(std::move(address)), port_(port) {}
  [[nodiscard]] RequestAnswer answer(const RequestHead& head) const;

 private:
  [[nodiscard]] bool knows_host(std::string_view host) const;

  std::string token_, address_;
  std::uint16_t port_;
};

/// An IPv4 or IPv6 address as a number, the latter without brackets, in the one spelling that all of its spellings have
/// in common: `0:0:0:0:0:0:0:1` is `::1`. An IPv4 address within IPv6 (`::ffff:127.0.0.1`) is that IPv4 address. None
/// for anything else.
std::optional<std::string> plain_address(std::string_view text);
/// `127.0.0.0/8` and `::1`.
bool is_loopback(std::string_view address);

}  // namespace poise::app
