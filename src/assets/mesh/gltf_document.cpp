// SPDX-License-Identifier: MIT
#include "assets/mesh/gltf_document.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "assets/files/text_cursor.h"
#include "assets/files/text_file.h"
#include "assets/mesh/byte_cursor.h"
#include "assets/mesh/gltf_bytes.h"

namespace poise::geometry {
namespace {

using io::JsonValue;

constexpr std::array<const char*, 6> kListNames{"scenes", "nodes", "meshes", "accessors", "bufferViews", "buffers"};
constexpr std::uint64_t kMostBufferBytes = std::uint64_t{4} << 30U;
/// Of the values of an accessor without a view, which are 0 and take no room in the file. Chosen.
constexpr std::uint64_t kMostZeros = 1U << 20U;

// Types of components, by the numbers of OpenGL.
constexpr std::uint64_t kInt8 = 5120, kUint8 = 5121, kInt16 = 5122, kUint16 = 5123, kUint32 = 5125, kFloat = 5126;

std::size_t size_of_component(std::uint64_t component) {
  switch (component) {
    case kInt8:
    case kUint8:
      return 1;
    case kInt16:
    case kUint16:
      return 2;
    case kUint32:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

/// Whether it may be that of indices.
bool is_without_sign(std::uint64_t component) {
  return component == kUint8 || component == kUint16 || component == kUint32;
}

const char* name_of(GltfList list) { return kListNames[static_cast<std::size_t>(list)]; }

std::uint32_t read_index(const char* bytes, std::uint64_t component) {
  if (component == kUint8) return number_of_bytes<std::uint8_t>(bytes, false);
  if (component == kUint16) return number_of_bytes<std::uint16_t>(bytes, false);
  return number_of_bytes<std::uint32_t>(bytes, false);
}

/// Whole numbers are coordinates as they are or, if `normalized`, as shares of the largest (KHR_mesh_quantization).
double read_coordinate(const char* bytes, std::uint64_t component, bool normalized) {
  const auto share = [normalized](auto value) {
    const auto number = static_cast<double>(value);
    return normalized ? std::max(number / static_cast<double>(std::numeric_limits<decltype(value)>::max()), -1.0)
                      : number;
  };
  switch (component) {
    case kInt8:
      return share(number_of_bytes<std::int8_t>(bytes, false));
    case kUint8:
      return share(number_of_bytes<std::uint8_t>(bytes, false));
    case kInt16:
      return share(number_of_bytes<std::int16_t>(bytes, false));
    case kUint16:
      return share(number_of_bytes<std::uint16_t>(bytes, false));
    case kUint32:
      return share(number_of_bytes<std::uint32_t>(bytes, false));
    default:
      return static_cast<double>(number_of_bytes<float>(bytes, false));
  }
}

/// Refuses what asks for a later version, or for an extension that changes shapes or places and is not read here.
Status check_requirements(const JsonValue& root) {
  constexpr std::array<std::string_view, 10> kSoundWithout{"KHR_mesh_quantization",
                                                           "KHR_draco_mesh_compression",
                                                           "EXT_meshopt_compression",
                                                           "KHR_materials_",
                                                           "KHR_texture_",
                                                           "EXT_texture_",
                                                           "MSFT_texture_",
                                                           "KHR_lights_",
                                                           "KHR_technique",
                                                           "KHR_xmp_"};
  const JsonValue* asset = root.find("asset");
  const JsonValue* least = asset != nullptr && asset->is_object() ? asset->find("minVersion") : nullptr;
  if (least != nullptr && !least->text().starts_with("2.") && !least->text().starts_with("1."))
    return bad_input(fmt::format("asset.minVersion = {}, must be 1 or 2", io::shown(*least)));
  const JsonValue* required = root.find("extensionsRequired");
  if (required == nullptr || !required->is_array()) return Done{};
  const JsonValue::Items extensions = required->items();
  for (std::size_t i = 0; i < extensions.size(); ++i) {
    const JsonValue& extension = extensions[i];
    const std::string_view name = extension.text();
    const bool known =
        std::ranges::any_of(kSoundWithout, [&](std::string_view begin) { return name.starts_with(begin); });
    if (!known)
      return bad_input(fmt::format("extensionsRequired has {}, must be extensions that are read or change no shape",
                                   io::shown(extension)));
  }
  return Done{};
}

}  // namespace

std::optional<std::uint64_t> whole_member(const JsonValue& object, std::string_view name, std::uint64_t otherwise) {
  const JsonValue* value = object.find(name);
  if (value == nullptr) return otherwise;
  return value->is_unsigned() ? std::optional(value->magnitude()) : std::nullopt;
}

/// The values of an accessor: those of its view, with some replaced if it is sparse.
struct GltfDocument::Accessor {
  std::string place;
  std::uint64_t count = 0;
  bool normalized = false;
  std::optional<Span> dense;
  std::uint64_t replaced = 0;
  Span at, by;

  /// Calls take(index, bytes, component) for each value that is not 0.
  template <class Take>
  Status each(Take&& take) const {
    for (std::uint64_t i = 0; dense && i < count; ++i)
      take(i, dense->bytes.data() + i * dense->stride, dense->component);
    for (std::uint64_t i = 0; i < replaced; ++i) {
      const std::uint32_t index = read_index(at.bytes.data() + i * at.stride, at.component);
      if (index >= count)
        return bad_input(fmt::format("{}.sparse: index {} = {}, must be below {}", place, i, index, count));
      take(index, by.bytes.data() + i * by.stride, by.component);
    }
    return Done{};
  }
};

Result<GltfDocument> GltfDocument::open(std::string_view bytes, const std::filesystem::path& folder) {
  const Result<GltfParts> parts = split_gltf(bytes);
  if (!parts) return parts.error();
  Result<JsonValue> root = io::parse_json(parts.value().text, "JSON");
  if (!root) return root.error();
  if (!root.value().is_object()) return bad_input("not a glTF file: must be a JSON object");
  const Status loads = check_requirements(root.value());
  if (!loads) return loads.error();
  GltfDocument document;
  document.root_ = std::move(root).value();
  document.binary_ = parts.value().binary;
  document.folder_ = folder;
  document.bytes_read_ = bytes.size();
  for (std::size_t list = 0; list < kListNames.size(); ++list) {
    const JsonValue* entries = document.lists_[list] = document.root_.find(kListNames[list]);
    if (entries == nullptr || !entries->is_object()) continue;
    const JsonValue::Keys keys = entries->keys();
    std::vector<std::uint32_t>& order = document.by_name_[list];
    order.resize(keys.size());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::sort(order, {}, [&](std::uint32_t i) { return keys[i]; });
  }
  return document;
}

Status GltfDocument::charge(std::uint64_t numbers) {
  charged_ += numbers;
  const std::uint64_t most = kMostRepeatedNumbers + bytes_read_;
  if (charged_ <= most) return Done{};
  return bad_input(fmt::format(
      "its nodes, meshes and accessors repeat so much that {} numbers and members would be read up to here, "
      "must be at most {} with the {} bytes that were read",
      charged_, most, bytes_read_));
}

JsonValue::Items GltfDocument::entries(GltfList list) const {
  const JsonValue* value = lists_[static_cast<std::size_t>(list)];
  return value != nullptr ? value->items() : JsonValue::Items(nullptr, 0);
}

std::optional<std::size_t> GltfDocument::find(GltfList list, const JsonValue& name) const {
  const JsonValue* value = lists_[static_cast<std::size_t>(list)];
  if (value == nullptr) return std::nullopt;
  if (value->is_array()) {
    if (!name.is_unsigned() || name.magnitude() >= value->items().size()) return std::nullopt;
    return static_cast<std::size_t>(name.magnitude());
  }
  if (!value->is_object() || !name.is_string()) return std::nullopt;
  const JsonValue::Keys keys = value->keys();
  const std::vector<std::uint32_t>& order = by_name_[static_cast<std::size_t>(list)];
  const auto at = std::ranges::lower_bound(order, name.text(), {}, [&](std::uint32_t i) { return keys[i]; });
  if (at == order.end() || keys[*at] != name.text()) return std::nullopt;
  return *at;
}

std::string GltfDocument::place(GltfList list, std::size_t entry) const {
  const JsonValue* value = lists_[static_cast<std::size_t>(list)];
  if (value != nullptr && value->is_object()) return io::member_path(name_of(list), value->keys()[entry]);
  return io::item_path(name_of(list), entry);
}

// Bytes of another file or in the uri itself.
Result<std::string_view> GltfDocument::load(const JsonValue& uri, const std::string& place) {
  const std::string name = decoded_uri(uri.text());
  const auto refuse = [&](const std::string& why) {
    return bad_input(fmt::format("{} names the file '{}', which {}", place, shown_word(uri.text()), why));
  };
  if (name.find('\0') != std::string::npos) return refuse("has no name that a file can have");
  std::error_code failure;
  const std::filesystem::path path = std::filesystem::weakly_canonical(folder_ / name, failure);
  if (failure) return refuse("cannot be read: " + failure.message());
  const auto held = files_.find(path.string());
  if (held != files_.end()) return std::string_view(held->second);
  Result<std::string> bytes = read_bytes(path, kMostBufferBytes);
  if (!bytes) return refuse(bytes.error().message);
  bytes_read_ += bytes.value().size();
  return std::string_view(files_.emplace(path.string(), std::move(bytes).value()).first->second);
}

Result<std::string_view> GltfDocument::buffer(std::size_t entry) {
  if (const auto held = buffers_.find(entry); held != buffers_.end()) return held->second;
  Result<std::string_view> bytes = read_buffer(entry);
  if (bytes) buffers_.emplace(entry, bytes.value());
  return bytes;
}

Result<std::string_view> GltfDocument::read_buffer(std::size_t entry) {
  const JsonValue& value = entries(GltfList::Buffers)[entry];
  const JsonValue* list = lists_[static_cast<std::size_t>(GltfList::Buffers)];
  const std::string name = list->is_object() ? std::string(list->keys()[entry]) : fmt::format("{}", entry);
  const std::string place = "buffer " + io::printable(std::string_view(name).substr(0, 40));
  const auto length = whole_member(value, "byteLength", std::numeric_limits<std::uint64_t>::max());
  if (!value.is_object() || !length) return bad_input(place + ": must be an object with a length");
  const JsonValue* uri = value.find("uri");
  const bool in_container = !binary_.empty() && (name == "binary_glTF" || (list->is_array() && entry == 0 && !uri));
  std::string_view bytes = binary_;
  if (!in_container) {
    if (uri == nullptr || !uri->is_string()) return bad_input(place + " names no file, and nothing is in this one");
    if (uri->text().starts_with("data:")) {
      Result<std::string> data = data_of_uri(uri->text());
      if (!data) return bad_input(place + ": " + data.error().message);
      bytes = embedded_.emplace(entry, std::move(data).value()).first->second;
    } else {
      const Result<std::string_view> file = load(*uri, place);
      if (!file) return file;
      bytes = file.value();
    }
  }
  return bytes.substr(0, std::min<std::uint64_t>(*length, bytes.size()));
}

Result<std::string_view> GltfDocument::view(const JsonValue& name, const std::string& place, std::uint64_t& stride) {
  if (const Status charged = charge(name); !charged) return charged.error();
  const auto entry = find(GltfList::BufferViews, name);
  if (!entry) return bad_input(fmt::format("{}.bufferView = {}, must exist", place, io::shown(name)));
  const std::string view_place = this->place(GltfList::BufferViews, *entry);
  const JsonValue& value = entries(GltfList::BufferViews)[*entry];
  const JsonValue* extensions = value.find("extensions");
  const JsonValue* buffer_name = value.find("buffer");
  for (const JsonValue* looked_at : {&value, extensions, buffer_name}) {
    if (looked_at == nullptr) continue;
    if (const Status charged = charge(*looked_at); !charged) return charged.error();
  }
  if (extensions != nullptr && extensions->find("EXT_meshopt_compression") != nullptr)
    return bad_input(view_place + " is compressed by EXT_meshopt_compression, must be decompressed before");
  const auto buffer_entry = buffer_name != nullptr ? find(GltfList::Buffers, *buffer_name) : std::nullopt;
  if (!buffer_entry) return bad_input(view_place + ".buffer must exist");
  const Result<std::string_view> bytes = buffer(*buffer_entry);
  if (!bytes) return bytes;
  const auto offset = whole_member(value, "byteOffset", 0);
  const auto length = whole_member(value, "byteLength", 0);
  const auto step = whole_member(value, "byteStride", 0);
  const std::size_t size = bytes.value().size();
  if (!offset || !length || !step || *length > size || *offset > size - *length)
    return bad_input(fmt::format("{} must lie in the {} bytes of its buffer", view_place, size));
  stride = *step;
  return bytes.value().substr(*offset, *length);
}

// `owner` is an accessor or a part of a sparse one; its own `stride` is that of version 1.
Result<GltfDocument::Span> GltfDocument::span(const JsonValue& owner, const std::string& place, std::uint64_t count,
                                              std::size_t components, std::uint64_t component,
                                              const JsonValue* stride) {
  const JsonValue* name = owner.find("bufferView");
  if (name == nullptr) return bad_input(place + ".bufferView is missing");
  std::uint64_t step = 0;
  const Result<std::string_view> bytes = view(*name, place, step);
  if (!bytes) return bytes.error();
  if (step == 0 && stride != nullptr) step = stride->magnitude();
  const std::uint64_t size = components * size_of_component(component);
  if (step == 0) step = size;
  const auto offset = whole_member(owner, "byteOffset", 0);
  const std::uint64_t room = bytes.value().size();
  // The first comparisons keep the product within 64 bits.
  const bool fits = offset && step >= size && step <= room + size && count <= room && size <= room && count > 0 &&
                    *offset <= room - size && (count - 1) <= (room - size - *offset) / step;
  if (!fits)
    return bad_input(fmt::format("{}: {} values of {} bytes, {} apart, must lie in the {} bytes of its view", place,
                                 count, size, step, room));
  return Span{bytes.value().substr(*offset), step, component};
}

Result<GltfDocument::Accessor> GltfDocument::accessor(const JsonValue& name, const Wanted& wanted) {
  if (const Status charged = charge(name); !charged) return charged.error();
  const auto entry = find(GltfList::Accessors, name);
  if (!entry) return bad_input(fmt::format("accessor {}, must exist", io::shown(name)));
  const JsonValue& value = entries(GltfList::Accessors)[*entry];
  if (const Status charged = charge(value); !charged) return charged.error();
  Accessor made;
  made.place = place(GltfList::Accessors, *entry);
  const JsonValue* type = value.find("type");
  if (type == nullptr || type->text() != wanted.type)
    return bad_input(fmt::format("{}.type must be \"{}\"", made.place, wanted.type));
  const auto component = whole_member(value, "componentType", 0);
  if (!component || size_of_component(*component) == 0 || (wanted.whole && !is_without_sign(*component)))
    return bad_input(fmt::format("{}.componentType must be {}", made.place,
                                 wanted.whole ? "5121, 5123 or 5125" : "from 5120 to 5126, without 5124"));
  const auto count = whole_member(value, "count", 0);
  if (!count || *count < 1) return bad_input(made.place + ".count must be a whole number from 1");
  made.count = *count;
  const JsonValue* normalized = value.find("normalized");
  made.normalized = normalized != nullptr && normalized->boolean();
  const JsonValue* sparse = value.find("sparse");
  if (value.find("bufferView") != nullptr) {
    Result<Span> dense = span(value, made.place, made.count, wanted.components, *component, value.find("byteStride"));
    if (!dense) return dense.error();
    made.dense = std::move(dense).value();
  } else if (made.count > kMostZeros) {
    return bad_input(
        fmt::format("{}.count = {}, must be at most {} without a bufferView", made.place, made.count, kMostZeros));
  }
  if (sparse == nullptr) return made;
  made.by.component = *component;
  const Status read = read_sparse(*sparse, wanted, made);
  if (!read) return read.error();
  return made;
}

Status GltfDocument::read_sparse(const JsonValue& sparse, const Wanted& wanted, Accessor& accessor) {
  const std::string place = accessor.place + ".sparse";
  const auto count = whole_member(sparse, "count", 0);
  const JsonValue* indices = sparse.find("indices");
  const JsonValue* values = sparse.find("values");
  if (!count || *count < 1 || indices == nullptr || values == nullptr)
    return bad_input(place + " must have count, indices and values");
  for (const JsonValue* looked_at : {&sparse, indices, values}) {
    if (const Status charged = charge(*looked_at); !charged) return charged.error();
  }
  const auto component = whole_member(*indices, "componentType", 0);
  if (!component || !is_without_sign(*component))
    return bad_input(place + ".indices.componentType must be 5121, 5123 or 5125");
  Result<Span> at = span(*indices, place + ".indices", *count, 1, *component, nullptr);
  if (!at) return at.error();
  Result<Span> by = span(*values, place + ".values", *count, wanted.components, accessor.by.component, nullptr);
  if (!by) return by.error();
  accessor.replaced = *count;
  accessor.at = at.value();
  accessor.by = by.value();
  return Done{};
}

Status GltfDocument::add_points(const JsonValue& name, std::vector<Vec3>& points) {
  const Result<Accessor> read = accessor(name, {"VEC3", 3, false});
  if (!read) return read.error();
  if (const Status charged = charge(3 * (read.value().count + read.value().replaced)); !charged) return charged;
  const std::size_t base = points.size();
  points.resize(base + read.value().count, Vec3::Zero());
  return read.value().each([&](std::uint64_t i, const char* bytes, std::uint64_t component) {
    for (int axis = 0; axis < 3; ++axis, bytes += size_of_component(component))
      points[base + i][axis] = read_coordinate(bytes, component, read.value().normalized);
  });
}

Status GltfDocument::read_indices(const JsonValue& name, std::vector<std::uint32_t>& indices) {
  const Result<Accessor> read = accessor(name, {"SCALAR", 1, true});
  if (!read) return read.error();
  if (const Status charged = charge(read.value().count + read.value().replaced); !charged) return charged;
  indices.assign(read.value().count, 0);
  return read.value().each(
      [&](std::uint64_t i, const char* bytes, std::uint64_t component) { indices[i] = read_index(bytes, component); });
}

}  // namespace poise::geometry
