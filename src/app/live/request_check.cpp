// SPDX-License-Identifier: MIT
#include "app/live/request_check.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cerrno>
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

/// An address with its port, as a URL has it.
std::string with_port(std::string_view name, std::uint16_t port) {
  return name.find(':') == std::string_view::npos ? fmt::format("{}:{}", name, port)
                                                  : fmt::format("[{}]:{}", name, port);
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

bool is_address(std::string_view text) {
  const std::string name(text);
  in6_addr bytes{};
  return ::inet_pton(AF_INET, name.c_str(), &bytes) == 1 || ::inet_pton(AF_INET6, name.c_str(), &bytes) == 1;
}

bool is_loopback(std::string_view address) {
  const std::string name(address);
  in_addr bytes{};
  constexpr std::uint32_t kFirstByte = 24, kLoopback = 127;
  if (::inet_pton(AF_INET, name.c_str(), &bytes) == 1) return ntohl(bytes.s_addr) >> kFirstByte == kLoopback;
  in6_addr wide{};
  return ::inet_pton(AF_INET6, name.c_str(), &wide) == 1 && IN6_IS_ADDR_LOOPBACK(&wide);
}

bool RequestCheck::knows_host(std::string_view host) const {
  for (const std::string_view name : {std::string_view("127.0.0.1"), std::string_view("localhost"),
                                      std::string_view("::1"), std::string_view(address_)}) {
    if (host == with_port(name, port_)) return true;
  }
  // Bound to all addresses of the machine: any of them, but no name, which another's server may give it.
  if (address_ != "0.0.0.0" && address_ != "::") return false;
  const std::string ending = fmt::format(":{}", port_);
  if (!host.ends_with(ending)) return false;
  host.remove_suffix(ending.size());
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  return is_address(host);
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
