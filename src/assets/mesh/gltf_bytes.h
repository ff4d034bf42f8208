// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "poise/result.h"

namespace poise::geometry {

/// Text and binary part of a glTF file; the binary part may be empty.
struct GltfParts {
  std::string_view text;
  std::string_view binary;
};

/// Splits a GLB container of version 1 or 2; anything else is text.
Result<GltfParts> split_gltf(std::string_view bytes);

/// The bytes of `data:TYPE;base64,DIGITS`; digits may be written as %2B and similar.
Result<std::string> data_of_uri(std::string_view uri);

/// A part of a URI with %20 and similar as bytes: of a relative reference, the name of a file.
std::string decoded_uri(std::string_view part);

}  // namespace poise::geometry
