// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <new>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "assets/files/atomic_file.h"
#include "fuzz/readers.h"
#include "poise/assets/mesh_file.h"
#include "scene/import/mjcf_import.h"
#include "scene/import/scene_draft.h"
#include "scene/temporary_folder.h"

// What readers hold at most while they read, beside the bytes themselves: a small multiple of these
// (docs/reliability.md). Memory of C libraries (zlib, Zstandard), which is constant, is not counted.
namespace {

std::atomic<std::size_t> held{0};
std::atomic<std::size_t> most_held{0};

void* counted(std::size_t size) noexcept {
  void* memory = std::malloc(size);
  if (memory == nullptr) return nullptr;
  const std::size_t now = held.fetch_add(::malloc_usable_size(memory)) + ::malloc_usable_size(memory);
  std::size_t most = most_held.load();
  while (most < now && !most_held.compare_exchange_weak(most, now)) {
  }
  return memory;
}

void freed(void* memory) noexcept {
  if (memory == nullptr) return;
  held.fetch_sub(::malloc_usable_size(memory));
  std::free(memory);
}

void* counted_or_thrown(std::size_t size) {
  void* memory = counted(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return counted_or_thrown(size); }
void* operator new[](std::size_t size) { return counted_or_thrown(size); }
void* operator new(std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return counted(size); }
void* operator new[](std::size_t size, const std::nothrow_t& /*tag*/) noexcept { return counted(size); }
void operator delete(void* memory) noexcept { freed(memory); }
void operator delete[](void* memory) noexcept { freed(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { freed(memory); }
void operator delete[](void* memory, std::size_t /*size*/) noexcept { freed(memory); }
void operator delete(void* memory, const std::nothrow_t& /*tag*/) noexcept { freed(memory); }
void operator delete[](void* memory, const std::nothrow_t& /*tag*/) noexcept { freed(memory); }

namespace poise::fuzz {
namespace {

constexpr std::size_t kBytes = 2'000'000;

/// `begin`, as many `part` as go into about `bytes`, `end`.
std::string repeated(const std::string& begin, const std::string& part, const std::string& end = "",
                     std::size_t bytes = kBytes) {
  std::string text = begin;
  while (text.size() < bytes) text += part;
  return text + end;
}

std::string members(const std::string& begin, const std::string& end) {
  std::string text = begin;
  for (int i = 0; text.size() < kBytes; ++i) text += fmt::format("\"{:x}\":0,", i);
  text.pop_back();
  return text + end;
}

/// The largest memory that `read` holds at a time.
template <class Read>
std::size_t peak_of(Read&& read) {
  const std::size_t before = held.load();
  most_held = before;
  read();
  return most_held.load() - before;
}

/// The largest memory for each byte that was read.
double multiple(std::string_view name, const std::string& bytes) {
  const Reader* reader = find_reader(name);
  if (reader == nullptr) return 0;
  const double share = static_cast<double>(peak_of([&] { reader->read(bytes); })) / static_cast<double>(bytes.size());
  ::testing::Test::RecordProperty(std::string(name), fmt::format("{:.1f}", share));
  fmt::print("{}: {:.1f} bytes for each byte of {:.30}...\n", name, share, bytes);
  return share;
}

TEST(ReaderMemory, OfJsonIsAtMost20TimesTheFile) {
  const std::string zeros = repeated("[0", ",0", "]");
  for (const char* reader :
       {"scene", "foam", "gltf", "priors", "policy", "capture", "record", "sweep", "trials", "outcome", "result"}) {
    const std::string part = reader == std::string_view("capture") || reader == std::string_view("record") ? "H" : "";
    EXPECT_LE(multiple(reader, part + zeros), 20) << reader;
  }
  EXPECT_LE(multiple("scene", repeated("[[0]", ",[0]", "]")), 20);
  EXPECT_LE(multiple("scene", repeated("[\"\"", ",\"\"", "]")), 20);
  EXPECT_LE(multiple("scene", repeated("[0.0000000", ",0.0000000", "]")), 20);
  EXPECT_LE(multiple("scene", repeated("[{}", ",{\"a\":{}}", "]")), 20);
  EXPECT_LE(multiple("scene", members("{", "}")), 20);
  EXPECT_LE(multiple("scene", members("{\"shapes\": {", "}}")), 40) << "with the shapes that it names";
  EXPECT_LE(multiple("gltf", members("{\"nodes\": {", "}}")), 20);
  EXPECT_LE(multiple("gltf", repeated("{\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{}", ",{}", "]}")), 20);
}

// What a sweep reads: lists of scenes, of trials, and figures under long names.
TEST(ReaderMemory, OfSweepsIsAtMost40TimesTheFile) {
  const std::string spec = R"({"schema":"poise.sweep/1","scenes":[)";
  EXPECT_LE(multiple("sweep", repeated(spec + R"("a")", R"(,"a")", "]}")), 40);
  std::string scenes = spec + R"("a")";
  for (int i = 0; scenes.size() < kBytes; ++i) scenes += fmt::format(",\"{:x}\"", i);
  EXPECT_LE(multiple("sweep", scenes + "]}"), 40);
  EXPECT_LE(multiple("sweep", repeated(spec + R"("a"],"axes":{"seed":[1)", ",1", "]}}")), 40);
  EXPECT_LE(multiple("sweep", repeated(spec + R"("a"],"settings":{"a":1)", R"(,"a":1)", "}}")), 40);
  EXPECT_LE(multiple("sweep", repeated(spec + R"("a"],"requirements":["alpha<1)", "&&alpha<1", "\"]}")), 40);
  EXPECT_LE(multiple("trials", repeated(R"({"schema":"poise.sweep-batch/1","trials":[{})", ",{}", "]}")), 40);
  EXPECT_LE(multiple("outcome", repeated(R"({"state":"done","affinity":[0)", ",0", "]}")), 40);
  const std::string name(1'000'000, 'n');
  EXPECT_LE(multiple("result", repeated(R"({"schema":"poise.run/2",")" + name + "\":[0", ",0", "]}")), 40);
  EXPECT_LE(multiple("result", repeated(R"({"schema":"poise.run/2","a":[[0])", ",[0]", "]}")), 40);
}

TEST(ReaderMemory, OfMeshesIsAtMost20TimesTheFile) {
  const std::string ply =
      "ply\nformat {} 1.0\nelement vertex {}\nproperty {} x\nproperty {} y\nproperty {} z\nelement "
      "face {}\nproperty list uchar uchar vertex_indices\nend_header\n";
  const auto ply_head = [&](const char* form, std::size_t vertices, const char* type, std::size_t faces) {
    return fmt::format(fmt::runtime(ply), form, vertices, type, type, type, faces);
  };
  EXPECT_LE(multiple("obj", repeated("", "v 0 0 0\n")), 20);
  EXPECT_LE(multiple("obj", repeated("v 0 0 0\n", "f 1 1 1\n")), 20);
  EXPECT_LE(multiple("obj", repeated("v 0 0 0\nf", " 1")), 20);
  EXPECT_LE(multiple("obj", repeated("v 0 0 0\n", "f 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n")), 20);
  EXPECT_LE(multiple("obj", repeated("", "\\\n")), 20);
  EXPECT_LE(multiple("off", repeated("OFF 300000 0\n", "0 0 0\n")), 20);
  EXPECT_LE(multiple("off", repeated("OFF 1 240000\n0 0 0\n", "3 0 0 0\n")), 20);
  EXPECT_LE(multiple("off", repeated("OFF 1 1\n0 0 0\n900000", " 0")), 20);
  EXPECT_LE(multiple("stl",
                     repeated("solid\n", "facet outer loop vertex 0 0 0 vertex 0 0 0 vertex 0 0 0 endloop endfacet\n")),
            20);
  EXPECT_LE(multiple("ply", repeated(ply_head("ascii", 300'000, "char", 1), "0 0 0\n")), 20);
  EXPECT_LE(multiple("ply", repeated(ply_head("ascii", 1, "char", 240'000) + "0 0 0\n", "3 0 0 0\n")), 20);
  EXPECT_LE(multiple("ply", repeated(ply_head("binary_little_endian", 600'000, "char", 1), std::string(3, '\0'))), 20);
  EXPECT_LE(multiple("ply", repeated(ply_head("binary_little_endian", 1, "char", 450'000) + std::string(3, '\0'),
                                     std::string("\3\0\0\0", 4))),
            20);
  const std::string gltf =
      R"({"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5120,"count":480000,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":1440000}],"buffers":[{"byteLength":1440000,"uri":"data:;base64,)";
  EXPECT_LE(multiple("gltf", repeated(gltf, "AAAA", "\"}]}")), 20);
}

/// A glTF file whose nodes place a mesh of `points` points and `corners` corners, all 0, `times` times.
std::string repeating_gltf(std::size_t times, int mode, std::size_t points, std::size_t corners,
                           const std::string& padding) {
  std::string names = "0";
  std::string nodes = R"({"mesh":0})";
  for (std::size_t i = 1; i < times; ++i) {
    names += fmt::format(",{}", i);
    nodes += R"(,{"mesh":0})";
  }
  return fmt::format(
      R"({{"scenes":[{{"nodes":[{}]}}],"nodes":[{}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,)"
      R"("mode":{}}}]}}],"accessors":[{{"componentType":5126,"count":{},"type":"VEC3"}},)"
      R"({{"componentType":5121,"count":{},"type":"SCALAR"}}]{}}})",
      names, nodes, mode, points, corners, padding);
}

// What is repeated is charged for, three of a vertex and one of a corner: 2,000,000 and the bytes of the file. JSON
// that is read and of no use adds to both.
TEST(ReaderMemory, OfGltfThatRepeatsIsAtMost60TimesTheFileAnd80MB) {
  const Reader* reader = find_reader("gltf");
  ASSERT_NE(reader, nullptr);
  double most_share = 0;
  // Lists grow by doubling, so that what they hold depends on where they end: a strip of 2^21 corners is the worst.
  for (const std::size_t padded : {0U, 110'000U, 2'000'000U}) {
    const std::string padding = ",\"x\":" + repeated("[0", ",0", "]", padded);
    for (const std::size_t times : {1U, 3U, 7U, 20U}) {
      for (const bool strip : {false, true}) {
        const std::size_t charged = (1'995'000 + padded) / times;
        const std::size_t count = std::min<std::size_t>(strip ? charged : charged / 3, 1U << 20U);
        const std::string text = repeating_gltf(times, strip ? 5 : 4, strip ? 1 : count, strip ? count : 3, padding);
        bool accepted = false;
        const std::size_t peak = peak_of([&] { accepted = reader->read(text); });
        const std::size_t bound = 80'000'000 + 60 * text.size();
        EXPECT_TRUE(accepted) << times << ' ' << count;
        EXPECT_LE(peak, bound) << times << ' ' << count;
        most_share = std::max(most_share, static_cast<double>(peak) / static_cast<double>(bound));
        fmt::print("gltf: {:.1f} MB of {} bytes, {} times {} {}\n", static_cast<double>(peak) / 1e6, text.size(), times,
                   count, strip ? "corners of a strip" : "vertices");
      }
    }
  }
  EXPECT_GE(most_share, 0.8) << "the bound is not far from what is needed";
}

// Refused at its first lines, a file is held once, whether or not a mark stands before it.
TEST(ReaderMemory, OfAMeshFileHoldsItsBytesOnce) {
  const testing::TemporaryFolder folder;
  const std::string points = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nend_header\n";
  for (const auto& [name, begin] : {std::pair<const char*, std::string>{"a.ply", points},
                                    {"a.stl", "solid\n?"},
                                    {"a.gltf", "?"},
                                    {"a.obj", "v x\n"},
                                    {"b.obj", "\xef\xbb\xbfv x\n"},
                                    {"b.off", "\xef\xbb\xbfOFF x\n"}}) {
    const std::string file = folder.file(name);
    ASSERT_TRUE(geometry::write_file(file, repeated(begin, "#")).ok());
    bool accepted = true;
    const std::size_t peak = peak_of([&] { accepted = read_mesh(file, {}).ok(); });
    EXPECT_FALSE(accepted);
    EXPECT_LE(peak, kBytes + kBytes / 2) << name;
  }
}

// The parser holds what is between brackets until these are closed; what is longer is refused.
TEST(ReaderMemory, OfYamlIsAtMost40TimesTheFileAndThatOfItsLongestBrackets) {
  for (const std::string& text :
       {repeated("collision_spheres:\n", "- 0\n"), repeated("- 0\n", "- 0\n"), repeated("", "- - - - - -\n"),
        repeated("", "0\n"), repeated("", "a: 0\n"), repeated("a: \"", "\\x41"), repeated("- &a 0\n", "- *a\n")})
    EXPECT_LE(multiple("yaml", text), 40);
  for (const std::string& text : {repeated("[0", ",0", "]"), repeated("{0", ",0", "}"), repeated("a: [0", ",\n 0", "]"),
                                  repeated("a: \"", "0", "\"")})
    EXPECT_LE(multiple("yaml", text) * static_cast<double>(text.size()), 60'000'000);
}

// Bodies, classes, meshes and kinds that are not modelled: a short element of each stands for a larger thing.
TEST(ReaderMemory, OfModelsOfMuJoCoIsAtMost40TimesTheFile) {
  const auto model = [](const std::string& begin, const std::string& part, const std::string& end) {
    std::string text = "<mujoco>" + begin;
    for (int i = 0; text.size() < kBytes; ++i) text += fmt::format(fmt::runtime(part), i);
    return text + end + "</mujoco>";
  };
  EXPECT_LE(multiple("mjcf", model("<worldbody>", "<geom size='1'/>", "</worldbody>")), 40);
  EXPECT_LE(multiple("mjcf", model("<worldbody>", "<a{:x}/>", "</worldbody>")), 40);
  EXPECT_LE(multiple("mjcf", model("<worldbody>", "<body><freejoint/><geom size='1'/></body>", "</worldbody>")), 40);
  EXPECT_LE(multiple("mjcf", model("<default>", "<default class='{:x}'/>", "</default>")), 40);
  EXPECT_LE(multiple("mjcf", model("<asset>", "<mesh file='{:x}'/>", "</asset>")), 40);
  EXPECT_LE(
      multiple("mjcf", "<mujoco><asset><mesh name='m' face='0' vertex='" + repeated("", "0 ") + "'/></asset></mujoco>"),
      40);
}

// What makes a scene of a model: the draft, each mesh and its text, the text of the scene and that scene. A line of the
// model may stand for a thousand triangles, so there is a constant beside the multiple: that of the largest mesh which
// is made of solids.
TEST(ReaderMemory, OfAWholeImportIsAtMost60TimesTheFileAnd250MB) {
  const testing::TemporaryFolder folder;
  std::string pyramids;
  for (int i = 0; pyramids.size() < kBytes; ++i)
    pyramids += fmt::format(
        "v {0} 0 0\nv {0}.5 0 0\nv {0} 1 0\nv {0} 0 1\nf -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n", i);
  ASSERT_TRUE(geometry::write_file(folder.file("pyramids.obj"), pyramids).ok());
  const auto bodies = [](const char* geom) {
    std::string text = "<mujoco><asset><mesh name='m' file='pyramids.obj'/></asset><worldbody>";
    for (int i = 1; text.size() < kBytes; ++i)
      text += "<body><freejoint/>" + fmt::format(fmt::runtime(geom), 1e-3 * i) + "</body>";
    return text + "</worldbody></mujoco>";
  };
  const std::string begin = "<mujoco><worldbody><body><freejoint/>";
  const std::string end = "</body></worldbody></mujoco>";
  double most_share = 0;
  for (const std::string& model :
       {repeated(begin, "<geom type='ellipsoid' size='1 2 3'/>", end, 2'083 * 37 + begin.size() - 36),
        repeated(begin, "<geom type='ellipsoid' size='1 2 3'/>", end), repeated(begin, "<geom size='1'/>", end),
        bodies("<geom type='ellipsoid' size='1 2 {}'/>"), bodies("<geom size='{}'/>"),
        bodies("<geom type='mesh' mesh='m'/>"), bodies("<geom type='mesh' mesh='m'/><geom size='{}'/>")}) {
    std::size_t written = 0;
    std::string refused;
    const std::size_t peak = peak_of([&] {
      const Result<io::SceneDraft> draft = io::import_mjcf(model, "model.xml", folder.path(), false);
      ASSERT_TRUE(draft.ok()) << draft.error().message;
      io::DraftSettings settings;
      settings.most_written = 5'000'000;  // in this test's time
      io::WrittenDraft made;
      const auto save = [&](const std::filesystem::path&, const std::string& text) {
        written += text.size();
        return Status(Done{});
      };
      const Result<std::string> text = io::draft_text(draft.value(), settings, folder.file("s.json"), save, made);
      refused = text ? "" : text.error().message;
    });
    const std::size_t bound = 250'000'000 + 60 * model.size();
    EXPECT_LE(peak, bound) << model.substr(0, 100);
    most_share = std::max(most_share, static_cast<double>(peak) / static_cast<double>(bound));
    fmt::print("import: {:.1f} MB of {} bytes, {:.1f} MB of meshes written; {:.60}; {:.90}...\n",
               static_cast<double>(peak) / 1e6, model.size(), static_cast<double>(written) / 1e6, refused,
               model.substr(begin.size()));
  }
  EXPECT_GE(most_share, 0.8) << "the bound is not far from what is needed";
}

TEST(ReaderMemory, OfTreesIsAtMost40TimesTheFile) {
  EXPECT_LE(multiple("urdf", repeated("<robot>", "<a/>", "</robot>")), 40);
  EXPECT_LE(multiple("urdf", repeated("<robot>", "<link name=''><collision/></link>", "</robot>")), 40);
  EXPECT_LE(multiple("urdf", repeated("<robot ", "a=''", "/>")), 40);
  EXPECT_LE(multiple("robot", repeated("<robot>", "<a/>", "</robot>")), 40);
  EXPECT_LE(
      multiple("robot", repeated("<robot><link name='a'>", "<visual><geometry><sphere radius='1'/></geometry></visual>",
                                 "</link></robot>")),
      40);
  EXPECT_LE(multiple("sph", repeated("6 8\n", "0 0 0 1\n")), 40);
  EXPECT_LE(multiple("sph", repeated("1 1\n", "0 ")), 40);
  EXPECT_LE(multiple("gaze", repeated("", "0,1,1\n")), 40);
}

}  // namespace
}  // namespace poise::fuzz
