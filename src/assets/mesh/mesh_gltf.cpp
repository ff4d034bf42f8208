// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "assets/mesh/mesh_files.h"

namespace poise::geometry {
namespace {

using Json = nlohmann::json;

/// Text and binary part of a container; the binary part may be empty.
struct Parts {
  std::string_view text;
  std::string_view binary;
};

std::uint32_t number_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  return value;
}

/// Splits a GLB container of version 1 or 2; anything else is text.
Result<Parts> take_apart(std::string_view bytes) {
  if (!bytes.starts_with("glTF")) return Parts{bytes.starts_with("\xef\xbb\xbf") ? bytes.substr(3) : bytes, {}};
  if (bytes.size() < 20) return bad_input("GLB: ends within its header");
  const std::uint32_t version = number_at(bytes, 4);
  if (version != 1 && version != 2) return bad_input(fmt::format("GLB: version {}, must be 1 or 2", version));
  const std::size_t length = number_at(bytes, 12);
  if (length > bytes.size() - 20)
    return bad_input(
        fmt::format("GLB: {} bytes of JSON are announced in {} bytes, must have room", length, bytes.size()));
  Parts parts{bytes.substr(20, length), bytes.substr(20 + length)};
  if (version == 1) return parts;
  // Version 2 has chunks; the second one, if present, is the binary part.
  if (parts.binary.size() < 8) return Parts{parts.text, {}};
  const std::size_t size = number_at(parts.binary, 0);
  if (size > parts.binary.size() - 8)
    return bad_input(fmt::format("GLB: its binary part of {} bytes is cut off", size));
  return Parts{parts.text, parts.binary.substr(8, size)};
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8U | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63U];
  }
  return text;
}

/// Decodes a relative reference to a file name: %20 and similar become bytes.
std::string decoded(std::string_view uri) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    const char low = static_cast<char>(c | 0x20);
    return low >= 'a' && low <= 'f' ? low - 'a' + 10 : -1;
  };
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0) {
      name += static_cast<char>(16 * digit(uri[i + 1]) + digit(uri[i + 2]));
      i += 2;
    } else {
      name += uri[i];
    }
  }
  return name;
}

/// The members of an object that have one of these names. A value that is not an object is returned unchanged; the
/// reader refuses it.
Json only(const Json& value, std::initializer_list<const char*> names) {
  if (!value.is_object()) return value;
  Json kept = Json::object();
  for (const char* name : names) {
    if (const auto found = value.find(name); found != value.end()) kept[name] = *found;
  }
  return kept;
}

/// Applies `change` to each entry of a list or of a dictionary (used by version 1).
template <class Change>
Json each(const Json& list, Change&& change) {
  Json changed = list;
  if (!list.is_array() && !list.is_object()) return changed;
  for (auto entry = changed.begin(); entry != changed.end(); ++entry) *entry = change(*entry);
  return changed;
}

constexpr const char* kDraco = "KHR_draco_mesh_compression";

Json plain_primitive(const Json& primitive) {
  Json plain = only(primitive, {"attributes", "indices", "mode", "primitive"});
  if (!plain.is_object()) return plain;
  if (plain.contains("attributes")) plain["attributes"] = only(plain["attributes"], {"POSITION"});
  const auto extensions = primitive.find("extensions");
  if (extensions != primitive.end() && extensions->is_object() && extensions->contains(kDraco)) {
    Json draco = only((*extensions)[kDraco], {"bufferView", "attributes"});
    if (draco.is_object() && draco.contains("attributes"))
      draco["attributes"] = only(draco["attributes"], {"POSITION"});
    plain["extensions"][kDraco] = std::move(draco);
  }
  return plain;
}

/// A member that is an integer >= 0, else `otherwise`.
std::uint64_t whole_number(const Json& object, const char* name, std::uint64_t otherwise) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number_unsigned() ? found->get<std::uint64_t>() : otherwise;
}

/// Whether [offset, offset + length) lies in [0, room).
bool fits(std::uint64_t offset, std::uint64_t length, std::uint64_t room) {
  return length <= room && offset <= room - length;
}

/// Removes views that reach beyond their buffers, and for version 1 also accessors that reach beyond their views, which
/// the reader does not check. The reader refuses a file that needs one of them.
void leave_out_what_is_cut_off(Json& plain) {
  const auto entry_of = [&plain](const char* list, const Json& owner, const char* name) -> const Json* {
    const auto entries = plain.find(list);
    const auto key = owner.find(name);
    if (entries == plain.end() || key == owner.end()) return nullptr;
    if (entries->is_array() && key->is_number_unsigned() && key->get<std::uint64_t>() < entries->size())
      return &(*entries)[key->get<std::size_t>()];
    if (entries->is_object() && key->is_string() && entries->contains(key->get<std::string>()))
      return &(*entries)[key->get<std::string>()];
    return nullptr;
  };
  const auto leave_out = [&plain](const char* list, auto&& stays) {
    const auto entries = plain.find(list);
    if (entries == plain.end()) return;
    Json kept = entries->is_array() ? Json::array() : Json::object();
    for (const auto& [name, entry] : entries->items()) {
      const bool good = entry.is_object() && stays(entry);
      if (entries->is_array()) {
        kept.push_back(good ? entry : Json::object());
      } else if (good) {
        kept[name] = entry;
      }
    }
    *entries = std::move(kept);
  };
  leave_out("bufferViews", [&](const Json& view) {
    const Json* buffer = entry_of("buffers", view, "buffer");
    return buffer != nullptr && fits(whole_number(view, "byteOffset", 0), whole_number(view, "byteLength", 0),
                                     whole_number(*buffer, "byteLength", 0));
  });
  const auto accessors = plain.find("accessors");
  if (accessors == plain.end() || !accessors->is_object()) return;
  leave_out("accessors", [&](const Json& accessor) {
    const Json* view = entry_of("bufferViews", accessor, "bufferView");
    if (view == nullptr) return false;
    const std::uint64_t component = whole_number(accessor, "componentType", 0);
    const std::uint64_t width = component >= 5125 ? 4 : (component >= 5122 ? 2 : 1);  // 5120 byte .. 5126 float
    const std::uint64_t size = width * (accessor.value("type", Json()) == "SCALAR" ? 1 : 3);
    const std::uint64_t stride = std::max(size, whole_number(accessor, "byteStride", 0));
    const std::uint64_t count = whole_number(accessor, "count", 0);
    constexpr std::uint64_t kMost = std::uint64_t{1} << 31U;
    if (stride > kMost || count > kMost) return false;
    return fits(whole_number(accessor, "byteOffset", 0), count == 0 ? 0 : (count - 1) * stride + size,
                whole_number(*view, "byteLength", 0));
  });
}

/// Moves the bytes of a buffer into its own entry, from another file or from the container.
Status embed(Json& buffer, const std::string& name, std::string_view binary, bool owns_binary,
             const std::filesystem::path& folder) {
  const auto uri = buffer.find("uri");
  const bool has_uri = uri != buffer.end() && uri->is_string();
  std::string bytes;
  if (owns_binary) {
    bytes = binary;
  } else if (!has_uri) {
    return bad_input(fmt::format("buffer {} names no file, and nothing is in this one", name));
  } else {
    const std::string reference = uri->get<std::string>();
    if (reference.starts_with("data:")) return Done{};
    std::ifstream stream(folder / decoded(reference), std::ios::binary);
    if (!stream)
      return bad_input(
          fmt::format("buffer {} names the file '{}', which cannot be read", name, reference.substr(0, 100)));
    bytes.assign(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  // If bytes are missing, the parts that need them are refused below; often only a picture needs them.
  bytes.resize(std::min<std::uint64_t>(bytes.size(), whole_number(buffer, "byteLength", bytes.size())));
  buffer["byteLength"] = bytes.size();
  buffer["uri"] = "data:application/octet-stream;base64," + base64(bytes);
  return Done{};
}

/// Selects the scene; a single scene is used whatever the file says.
Status choose_scene(Json& plain) {
  const auto scenes = plain.find("scenes");
  if (scenes == plain.end() || scenes->empty()) return bad_input("has no scene, so nothing of it is to be shown");
  if (scenes->size() == 1) {
    plain["scene"] = scenes->is_array() ? Json(0) : Json(scenes->begin().key());
    return Done{};
  }
  if (!plain.contains("scene")) return Done{};
  const Json& scene = plain["scene"];
  const bool known = scenes->is_array() ? scene.is_number_unsigned() && scene.get<std::uint64_t>() < scenes->size()
                                        : scene.is_string() && scenes->contains(scene.get<std::string>());
  if (known) return Done{};
  return bad_input(fmt::format("scene = {}, must be one of {} scenes",
                               scene.dump(-1, ' ', true, Json::error_handler_t::replace).substr(0, 40),
                               scenes->size()));
}

}  // namespace

Result<std::string> plain_gltf(const std::string& bytes, const std::filesystem::path& folder) {
  const Result<Parts> parts = take_apart(bytes);
  if (!parts) return parts.error();
  Json whole;
  try {
    whole = Json::parse(parts.value().text);
  } catch (const Json::exception& failure) {
    return bad_input(fmt::format("not valid JSON: {}", failure.what()));
  }
  if (!whole.is_object()) return bad_input("not a glTF file: must be a JSON object");
  Json plain = only(whole, {"asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"});
  plain["asset"] = only(plain["asset"].is_null() ? Json::object() : plain["asset"], {"version"});
  if (Status chosen = choose_scene(plain); !chosen) return chosen.error();
  plain["scenes"] = each(plain["scenes"], [](const Json& scene) { return only(scene, {"nodes"}); });
  if (plain.contains("nodes")) {
    plain["nodes"] = each(plain["nodes"], [](const Json& node) {
      return only(node, {"children", "matrix", "rotation", "scale", "translation", "mesh", "meshes"});
    });
  }
  if (plain.contains("meshes")) {
    plain["meshes"] = each(plain["meshes"], [](const Json& mesh) {
      Json kept = only(mesh, {"primitives"});
      if (kept.is_object() && kept.contains("primitives") && kept["primitives"].is_array()) {
        kept["primitives"] = each(kept["primitives"], plain_primitive);
      }
      return kept;
    });
  }
  if (plain.contains("buffers") && (plain["buffers"].is_array() || plain["buffers"].is_object())) {
    bool first = true;
    for (const auto& [name, buffer] : plain["buffers"].items()) {
      if (!buffer.is_object()) return bad_input(fmt::format("buffer {}: must be an object", name));
      const bool in_container = !parts.value().binary.empty();
      const bool owns_binary =
          in_container && (name == "binary_glTF" || (plain["buffers"].is_array() && first && !buffer.contains("uri")));
      if (Status embedded = embed(buffer, name, parts.value().binary, owns_binary, folder); !embedded)
        return embedded.error();
      first = false;
    }
  }
  leave_out_what_is_cut_off(plain);
  const auto used = whole.find("extensionsUsed");
  if (used != whole.end() && used->is_array() && std::ranges::find(*used, Json(kDraco)) != used->end())
    plain["extensionsUsed"] = {kDraco};
  return plain.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace poise::geometry
