// SPDX-License-Identifier: MIT
#include "app/picture/picture.h"

#include <fmt/format.h>
#include <png.h>

namespace poise::io {

Result<std::string> png_bytes(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = image.width_px;
  header.height = image.height_px;
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string bytes;
  bool made = png_image_write_to_memory(&header, nullptr, &size, 0, image.rgb.data(), 0, nullptr) != 0;
  if (made) {
    bytes.resize(size);
    made = png_image_write_to_memory(&header, bytes.data(), &size, 0, image.rgb.data(), 0, nullptr) != 0;
  }
  if (!made) return Error{ErrorKind::OutputFailed, fmt::format("PNG: {}", header.message)};
  bytes.resize(size);
  return bytes;
}

}  // namespace poise::io
