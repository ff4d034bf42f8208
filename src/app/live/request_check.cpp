// SPDX-License-Identifier: MIT
#include "app/live/request_check.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace poise::app {
namespace {

/// Takes as long for a wrong text as for the right one, so that its time tells nothing.
bool equal(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned>(static_cast<unsigned char>(b[i]));
  return difference == 0;
}

/// What browsers take a URL without a port to have, and leave out of `Host` and `Origin`.
constexpr std::uint16_t kUsualPort = 80;

/// The name or address in a `Host`, without port and brackets. None where the port is another one, and where brackets
/// are missing or not those of an IPv6 address.
std::optional<std::string_view> name_of(std::string_view host, std::uint16_t port) {
  const std::string ending = fmt::format(":{}", port);
  if (host.ends_with(ending)) {
    host.remove_suffix(ending.size());
  } else if (port != kUsualPort) {
    return std::nullopt;
  }
  const bool is_wide = host.starts_with('[') && host.ends_with(']');
  if (is_wide) host = host.substr(1, host.size() - 2);
  if (is_wide != (host.find(':') != std::string_view::npos)) return std::nullopt;
  return host;
}

}  // namespace

Result<std::string> random_token() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return bad_input(fmt::format("the system gives no random numbers: {}", std::generic_category().message(errno)));
  }
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

std::optional<std::string> plain_address(std::string_view text) {
  const std::string name(text);
  std::array<char, INET6_ADDRSTRLEN> plain{};
  in_addr narrow{};
  in6_addr wide{};
  bool is_narrow = ::inet_pton(AF_INET, name.c_str(), &narrow) == 1;
  if (!is_narrow && ::inet_pton(AF_INET6, name.c_str(), &wide) != 1) return std::nullopt;
  if (!is_narrow && IN6_IS_ADDR_V4MAPPED(&wide)) {
    constexpr std::size_t kBefore = sizeof(wide) - sizeof(narrow);
    std::memcpy(&narrow, &wide.s6_addr[kBefore], sizeof(narrow));
    is_narrow = true;
  }
  if (is_narrow) {
    ::inet_ntop(AF_INET, &narrow, plain.data(), plain.size());
  } else {
    ::inet_ntop(AF_INET6, &wide, plain.data(), plain.size());
  }
  return plain.data();
}

bool is_loopback(std::string_view address) {
  const std::optional<std::string> plain = plain_address(address);
  return plain && (plain->starts_with("127.") || *plain == "::1");
}

bool RequestCheck::knows_host(std::string_view host) const {
  const std::optional<std::string_view> name = name_of(host, port_);
  if (!name) return false;
  if (*name == "localhost") return true;
  const std::optional<std::string> address = plain_address(*name);
  if (!address) return false;
  // Bound to all addresses of the machine: any of them, but no name, which another's server may give it.
  const bool is_bound_to_all = address_ == "0.0.0.0" || address_ == "::";
  return is_bound_to_all || *address == "127.0.0.1" || *address == "::1" || *address == address_;
}

RequestAnswer RequestCheck::answer(const RequestHead& head) const {
  if (!knows_host(head.host)) return RequestAnswer::Forbidden;
  // Browsers name the origin of each WebSocket; a page's own is where it was fetched.
  const std::string own = fmt::format("http://{}", head.host);
  if (head.origin && *head.origin != own) return RequestAnswer::Forbidden;
  const std::string page = "/" + token_ + "/";
  const std::string socket = page + "socket";
  if (equal(head.target, socket) && head.upgrade) return head.origin ? RequestAnswer::Socket : RequestAnswer::Forbidden;
  if (!equal(head.target, page) || head.upgrade) return RequestAnswer::NotFound;
  return head.method == "GET" ? RequestAnswer::Page : RequestAnswer::WrongMethod;
}

}  // namespace poise::app
