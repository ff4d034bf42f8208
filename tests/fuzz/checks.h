// SPDX-License-Identifier: MIT
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "poise/mesh.h"
#include "poise/result.h"

namespace poise::fuzz {

/// Ends the program, so that a fuzzer keeps the bytes that led here.
inline void require(bool holds, const char* promise, const std::string& what = {}) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s: %s\n", promise, what.c_str());
  std::abort();
}

inline bool checked(const Error& error) {
  require(!error.message.empty() && error.message.find('\n') == std::string::npos, "an error is one line",
          error.message);
  return false;
}

template <class T>
bool checked(const Result<T>& result) {
  return result.ok() || checked(result.error());
}

inline bool checked_mesh(const Result<TriangleMesh>& mesh) {
  if (!mesh.ok()) return checked(mesh.error());
  for (const Vec3& v : mesh.value().vertices_m) require(v.allFinite(), "a vertex is finite");
  for (const auto& t : mesh.value().triangles) {
    for (const std::uint32_t corner : t) require(corner < mesh.value().vertices_m.size(), "a corner exists");
  }
  return true;
}

/// Bytes as a file that exists in memory alone, for readers that open one.
class MemoryFile {
 public:
  MemoryFile(std::string_view bytes, const char* ending) : descriptor_(::memfd_create(ending, 0)) {
    for (std::size_t at = 0; at < bytes.size();) {
      const ssize_t written = ::write(descriptor_, bytes.data() + at, bytes.size() - at);
      require(written > 0, "a file in memory can be written");
      at += static_cast<std::size_t>(written);
    }
  }
  ~MemoryFile() { ::close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace poise::fuzz
