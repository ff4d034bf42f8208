// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <random>
#include <vector>

#include "frame/stage_list.h"
#include "record/record_bytes.h"
#include "record/record_file.h"
#include "record/record_shapes.h"
#include "scene/temporary_folder.h"

namespace poise::io {
namespace {

using testing::TemporaryFolder;
using Kind = RefinementStep::Kind;

RecordHeader some_header() {
  RecordHeader header;
  header.scene_name = "a \"scene\"";
  header.scene_source = "scenes/a.json";
  header.scene_folder = "/somewhere";
  header.scene_text = "{\"name\": \"a\"} // with a comment";
  header.bodies = 12;
  header.gaze = "0,1,2\n";
  header.gaze_loop = true;
  header.start_hash = 0xfedcba9876543210U;
  header.shapes = {{"ball", {}, 7}, {"jack", {{"meshes/jack.obj", 1234, 0xffffffffffffffffU}, {"jack.sph", 5, 6}}, 9}};
  header.world.contact = ContactModel::Paper;
  header.world.policy.kind = scheduler::PolicyKind::Random;
  header.world.policy.size = 0.1;
  header.world.executor = ExecutorKind::Serial;
  header.world.threads = 3;
  header.world.sleeping = true;
  header.world.substeps = 5;
  header.world.max_partners = 17;
  header.world.max_front_entries = 100;
  header.dt_s = 1.0 / 60;
  header.max_level = 4;
  header.polygons = true;
  header.frames = 9;
  header.clock = "wall";
  header.paced = true;
  header.deadline_ms = 16.7;
  header.machine = {"Linux", "a processor", 8};
  header.build = {"1.2.3", "abc", "GNU", "-O3"};
  return header;
}

RecordedFrame some_frame(std::uint64_t number) {
  std::mt19937_64 random(number + 5);
  RecordedFrame frame;
  frame.decisions.frame = number;
  frame.decisions.active_pairs = 5000;
  frame.decisions.substeps = number % 3 == 2 ? 1 : 0;
  frame.decisions.point_iterations = number % 4 == 1 ? 300 * static_cast<std::uint32_t>(number) : 0;
  frame.decisions.crowded_partners = number % 5 == 3 ? 130 : 0;
  frame.decisions.learns = number % 2 == 0;
  if (number % 3 == 1) frame.decisions.stopped_after = {static_cast<std::uint32_t>(number), 0, 70};
  for (std::uint32_t pair = 3; pair < 40 * number && pair < 5000; pair += 7) frame.decisions.reused.push_back(pair);
  for (std::uint32_t slot = 1; slot < 3 * number; slot += 5) frame.decisions.held.push_back(slot);
  for (std::uint64_t i = 0; i < 20 * (number % 4); ++i)
    frame.decisions.steps.push_back({static_cast<std::uint32_t>(random() % 5000),
                                     static_cast<std::uint8_t>(number % 2 == 0 ? 0 : random() % 256),
                                     static_cast<Kind>(random() % 3)});
  frame.state_hash = random();
  frame.budget = Nanoseconds(16'666'667);
  frame.refine_available = Nanoseconds(static_cast<std::int64_t>(random() % 10'000'000));
  frame.lateness = Nanoseconds(static_cast<std::int64_t>(number));
  if (number % 2 == 1) {
    RecordedTimes& times = frame.times.emplace();
    times.cause = static_cast<MissCause>(number % 6);
    times.release_delay = Nanoseconds(70 * static_cast<std::int64_t>(number));
    times.host = Nanoseconds(5);
    for (const simulation::StageMember& stage : simulation::kStages)
      times.stages.*stage.time = Nanoseconds(static_cast<std::int64_t>(random() % 10'000'000));
    times.piece = Nanoseconds(9);
    times.piece_a = 3;
    times.piece_b = 4'000'000'000U;
  }
  return frame;
}

void expect_equal(const RecordedFrame& read, const RecordedFrame& written) {
  EXPECT_EQ(read.decisions, written.decisions);
  EXPECT_EQ(read.state_hash, written.state_hash);
  EXPECT_EQ(read.budget, written.budget);
  EXPECT_EQ(read.refine_available, written.refine_available);
  EXPECT_EQ(read.reserve, written.reserve);
  EXPECT_EQ(read.lateness, written.lateness);
  ASSERT_EQ(read.times.has_value(), written.times.has_value());
  if (!read.times) return;
  EXPECT_EQ(read.times->cause, written.times->cause);
  EXPECT_EQ(read.times->release_delay, written.times->release_delay);
  EXPECT_EQ(read.times->host, written.times->host);
  for (const simulation::StageMember& stage : simulation::kStages)
    EXPECT_EQ(read.times->stages.*stage.time, written.times->stages.*stage.time) << stage.name;
  EXPECT_EQ(read.times->piece, written.times->piece);
  EXPECT_EQ(read.times->piece_a, written.times->piece_a);
  EXPECT_EQ(read.times->piece_b, written.times->piece_b);
}

/// The bytes of a record of this many frames.
std::string record_of(const TemporaryFolder& folder, std::uint64_t frames, bool stopped = false) {
  Result<RecordWriter> writer = RecordWriter::open(folder.file("made"));
  EXPECT_TRUE(writer.ok());
  EXPECT_TRUE(writer.value().begin(some_header()).ok());
  for (std::uint64_t i = 0; i < frames; ++i) EXPECT_TRUE(writer.value().frame(some_frame(i), {}).ok());
  EXPECT_TRUE(writer.value().finish(stopped).ok());
  const std::string bytes = testing::contents(folder.file("made"));
  EXPECT_EQ(bytes.size(), writer.value().bytes());
  return bytes;
}

void put(const std::string& file, const std::string& bytes) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Result of reading a file: the number of frames, whether each is as written, and how the record ended.
struct Read {
  bool opened = false;
  std::string refusal;
  std::uint64_t frames = 0;
  bool whole = false;
  std::optional<RecordReader::Damage> damage;
};

Read read_all(const std::string& file) {
  Read read;
  Result<RecordReader> reader = RecordReader::open(file);
  read.opened = reader.ok();
  if (!reader) {
    read.refusal = reader.error().message;
    return read;
  }
  RecordedFrame frame;
  for (;;) {
    const RecordReader::Next next = reader.value().next(frame);
    read.whole = next == RecordReader::Next::End;
    read.damage = reader.value().damage();
    if (next != RecordReader::Next::Frame) return read;
    expect_equal(frame, some_frame(read.frames));
    ++read.frames;
  }
}

TEST(Record, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  record_of(folder, 9, true);
  Result<RecordReader> reader = RecordReader::open(folder.file("made"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  const RecordHeader& h = reader.value().header();
  const RecordHeader was = some_header();
  EXPECT_EQ(header_json(h), header_json(was)) << "every member";
  EXPECT_EQ(h.scene_text, was.scene_text);
  EXPECT_EQ(h.bodies, was.bodies);
  EXPECT_FALSE(h.seed.has_value());
  EXPECT_EQ(h.dt_s, was.dt_s) << "to the bit";
  EXPECT_EQ(h.start_hash, was.start_hash);
  ASSERT_EQ(h.shapes.size(), 2U);
  EXPECT_EQ(h.shapes[1].files[0].hash, 0xffffffffffffffffU);
  RecordedFrame frame;
  for (std::uint64_t i = 0; i < 9; ++i) {
    ASSERT_EQ(reader.value().next(frame), RecordReader::Next::Frame);
    expect_equal(frame, some_frame(i));
  }
  EXPECT_EQ(reader.value().next(frame), RecordReader::Next::End);
  EXPECT_EQ(reader.value().next(frame), RecordReader::Next::End);
  EXPECT_EQ(reader.value().end().frames, 9U);
  EXPECT_TRUE(reader.value().end().stopped);
}

TEST(Record, CutShortAnywhereIsReadUpToTheCutAndSaysSo) {
  const TemporaryFolder folder;
  const std::string file = folder.file("made");
  const std::size_t whole = record_of(folder, 6).size();
  std::uint64_t before = 6;
  bool first = true;
  for (std::size_t size = whole; size-- > 0;) {
    std::filesystem::resize_file(file, size);
    const Read read = read_all(file);
    if (!read.opened) {
      EXPECT_EQ(read.refusal.find(file), 0U);
      continue;
    }
    ASSERT_FALSE(read.whole) << size;
    ASSERT_TRUE(read.damage.has_value()) << size;
    EXPECT_LE(read.damage->byte, size);
    EXPECT_LE(read.frames, before);
    EXPECT_GE(read.frames + 1, before) << "what was written before the cut counts";
    if (first) {
      EXPECT_EQ(read.frames, 6U);
    }
    first = false;
    before = read.frames;
  }
  EXPECT_EQ(before, 0U);
}

TEST(Record, OneChangedBitAnywhereIsSeen) {
  const TemporaryFolder folder;
  const std::string file = folder.file("made");
  const std::string whole = record_of(folder, 6);
  // Changed in place: writing a new file for each byte would take too long on the disk.
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  const auto set = [&](std::size_t at, unsigned change) {
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(static_cast<char>(static_cast<unsigned char>(whole[at]) ^ change));
    stream.flush();
  };
  std::size_t read_on = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    set(at, 1U << (at % 8));
    const Read read = read_all(file);
    set(at, 0);
    ASSERT_FALSE(read.whole) << at;
    ASSERT_TRUE(!read.opened || read.damage.has_value()) << at;
    if (read.opened) {
      EXPECT_LE(read.damage->byte, at) << "the block that it is in";
    }
    read_on += read.frames > 0 ? 1U : 0U;
  }
  EXPECT_GT(read_on, 100U) << "frames before the damage are read";
  EXPECT_TRUE(read_all(file).whole) << "put right again";
}

TEST(Record, SomethingBehindTheEndIsSeen) {
  const TemporaryFolder folder;
  put(folder.file("more"), record_of(folder, 2) + "x");
  const Read read = read_all(folder.file("more"));
  EXPECT_EQ(read.frames, 2U);
  ASSERT_TRUE(read.damage.has_value());
  EXPECT_EQ(read.damage->what, "something stands behind the end");
}

TEST(Record, RefusesWhatIsNoneWithTheFile) {
  const TemporaryFolder folder;
  const std::string file = folder.file("none");
  EXPECT_EQ(read_all(file).refusal, file + ": no such file");
  EXPECT_EQ(read_all(folder.path().string()).refusal,
            folder.path().string() + ": not a file: a folder, a pipe or a device");
  put(file, "{\"name\": \"a scene\"}");
  EXPECT_EQ(read_all(file).refusal, file + ": not a record of poise run --record");
  put(file, "");
  EXPECT_EQ(read_all(file).refusal, file + ": not a record of poise run --record");
  put(file, "poise.record/1\n and so on");
  EXPECT_EQ(read_all(file).refusal, file + ": a record of another version, must be poise.record/6");
}

/// What can be read of a record whose writer is killed after frames that ended at these times, invented ones.
Read read_of_killed(const std::vector<std::chrono::milliseconds>& ends) {
  const TemporaryFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    Result<RecordWriter> writer = RecordWriter::open(folder.file("r"));
    bool sound = writer.ok() && writer.value().begin(some_header()).ok();
    for (std::size_t i = 0; sound && i < ends.size(); ++i)
      sound = writer.value().frame(some_frame(i), SteadyClock::time_point(ends[i])).ok();
    // As if by a signal: nothing is closed and nothing that is buffered is written.
    ::_exit(sound ? 0 : 1);
  }
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(folder.entries(), 1U);
  const std::string part = std::filesystem::directory_iterator(folder.path())->path().string();
  EXPECT_TRUE(part.ends_with("/.r.0.part")) << part;
  Read read = read_all(part);
  EXPECT_TRUE(read.opened) << read.refusal;
  EXPECT_EQ(read.damage.value().what, "the file ends here, before the end of the run");
  return read;
}

TEST(Record, OfARunThatIsKilledReplaysFromItsFirstFrameOn) {
  using std::chrono::milliseconds;
  EXPECT_EQ(read_of_killed({milliseconds(7'000'000)}).frames, 1U);
  EXPECT_EQ(read_of_killed({milliseconds(0), milliseconds(250), milliseconds(600), milliseconds(5000)}).frames, 4U);
}

// Frames of 10 ms: whichever is the last, those that ended 250 ms before it are there, and so are those at 0, 250, ...
TEST(Record, OfARunThatIsKilledReplaysWhatEndedAQuarterOfASecondBefore) {
  std::vector<std::chrono::milliseconds> ends;
  for (std::size_t last = 0; last <= 60; ++last) {
    ends.emplace_back(10 * last);
    const std::uint64_t frames = read_of_killed(ends).frames;
    EXPECT_EQ(frames, 1 + last / 25 * 25) << ends.back().count() << " ms";
  }
}

/// A frame of about two bytes for each of `steps` steps, that compresses to almost nothing.
RecordedFrame uniform_frame(std::uint32_t steps) {
  RecordedFrame frame;
  frame.decisions.active_pairs = 5000;
  frame.decisions.steps.assign(steps, {7, 1, Kind::Completed});
  return frame;
}

TEST(Record, AFrameOutOfProportionIsStoredLargerAndReadAgain) {
  const TemporaryFolder folder;
  constexpr std::uint32_t kSteps = 2'000'000;
  Result<RecordWriter> writer = RecordWriter::open(folder.file("r"));
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(writer.value().begin(some_header()).ok());
  ASSERT_TRUE(writer.value().frame(uniform_frame(kSteps), {}).ok());
  RecordedFrame second = some_frame(1);
  ASSERT_TRUE(writer.value().frame(second, {}).ok());
  ASSERT_TRUE(writer.value().finish(false).ok());
  EXPECT_GT(writer.value().bytes(), 2 * kSteps) << "not compressed 100 times";
  Result<RecordReader> reader = RecordReader::open(folder.file("r"));
  ASSERT_TRUE(reader.ok()) << reader.error().message;
  RecordedFrame frame;
  ASSERT_EQ(reader.value().next(frame), RecordReader::Next::Frame) << reader.value().damage()->what;
  expect_equal(frame, uniform_frame(kSteps));
  ASSERT_EQ(reader.value().next(frame), RecordReader::Next::Frame) << "what follows is compressed against it";
  expect_equal(frame, second);
  EXPECT_EQ(reader.value().next(frame), RecordReader::Next::End);
}

/// A block of this many zeros as a record has it; the first of its stream.
std::string block_of_zeros(char kind, std::size_t size) {
  const std::string raw(size, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit(&stream, 9), Z_OK);
  std::string packed(deflateBound(&stream, size) + 100, '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(raw.data()));
  stream.avail_in = static_cast<uInt>(raw.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_SYNC_FLUSH), Z_OK);
  packed.resize(packed.size() - stream.avail_out);
  deflateEnd(&stream);
  const auto number = [](std::size_t value) {
    const auto small = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&small), sizeof small);
  };
  std::string block = kind + number(raw.size()) + number(packed.size()) + packed;
  return block + number(crc32_z(0, reinterpret_cast<const Bytef*>(block.data()), block.size()));
}

TEST(Record, ABlockOfZerosThatIsOutOfProportionToTheFileIsRefusedBeforeItIsUnpacked) {
  const TemporaryFolder folder;
  put(folder.file("zeros"), "poise.record/6\n" + block_of_zeros('H', std::size_t{200} << 20U));
  EXPECT_LT(std::filesystem::file_size(folder.file("zeros")), 300'000U);
  EXPECT_NE(read_all(folder.file("zeros")).refusal.find("the block's length is damaged"), std::string::npos);
  put(folder.file("few"), "poise.record/6\n" + block_of_zeros('H', std::size_t{1} << 20U));
  EXPECT_NE(read_all(folder.file("few")).refusal.find("not valid JSON"), std::string::npos) << "unpacked";
}

TEST(Record, APipeIsRefusedInsteadOfWaitedFor) {
  const TemporaryFolder folder;
  ASSERT_EQ(::mkfifo(folder.file("pipe").c_str(), 0600), 0);
  EXPECT_EQ(read_all(folder.file("pipe")).refusal, folder.file("pipe") + ": not a file: a folder, a pipe or a device");
  EXPECT_EQ(read_all("/dev/zero").refusal, "/dev/zero: not a file: a folder, a pipe or a device");
}

TEST(Record, ChangesThatLeadBeyondAllNumbersAreRefused) {
  // Numbers of a list are stored as changes: 5 and then the largest that there is, of either sign.
  for (const char parity : {'\xfe', '\xff'}) {
    std::string bytes;
    write_frame({}, bytes);
    // Behind the frame's number, hash, four times and what they are of, three counts, `learns`, and the first list.
    const std::size_t second_list = 1 + 8 + 4 + 1 + 3 + 1 + 1;
    ASSERT_EQ(bytes[second_list], '\0') << "an empty list";
    bytes.replace(second_list, 1, std::string("\2\x0a") + parity + std::string(8, '\xff') + "\1");
    RecordedFrame read;
    EXPECT_FALSE(read_frame(bytes, read).ok());
  }
}

TEST(Record, IsNotThereUntilItIsWhole) {
  const TemporaryFolder folder;
  {
    Result<RecordWriter> writer = RecordWriter::open(folder.file("r"));
    ASSERT_TRUE(writer.ok());
    EXPECT_TRUE(writer.value().begin(some_header()).ok());
    EXPECT_FALSE(std::filesystem::exists(folder.file("r")));
  }
  EXPECT_EQ(folder.entries(), 0U) << "a run that fails leaves nothing";
  const Result<RecordWriter> refused = RecordWriter::open(folder.file("no/such/r"));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().kind, ErrorKind::OutputFailed);
}

TEST(Record, FramesOfAnyNumbersComeBack) {
  RecordedFrame frame;
  frame.decisions.frame = std::numeric_limits<std::uint64_t>::max();
  frame.decisions.active_pairs = std::numeric_limits<std::uint32_t>::max();
  frame.decisions.substeps = std::numeric_limits<std::uint32_t>::max();
  frame.decisions.reused = {0, frame.decisions.active_pairs - 1};
  frame.decisions.held = {0, std::numeric_limits<std::uint32_t>::max()};
  frame.decisions.steps = {
      {frame.decisions.active_pairs - 1, 255, Kind::Full}, {0, 255, Kind::Completed}, {0, 0, Kind::Cut}};
  frame.state_hash = frame.decisions.frame;
  frame.budget = Nanoseconds::max();
  std::string bytes;
  write_frame(frame, bytes);
  RecordedFrame read;
  ASSERT_TRUE(read_frame(bytes, read).ok());
  expect_equal(read, frame);
}

TEST(Record, BytesThatNoWriterMakesAreRefusedWhateverTheyAre) {
  std::string good;
  write_frame(some_frame(3), good);
  RecordedFrame read;
  ASSERT_TRUE(read_frame(good, read).ok());
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_FALSE(read_frame(good.substr(0, size), read).ok()) << size;
  EXPECT_FALSE(read_frame(good + '\0', read).ok());
  // For any bytes, no pair may result that the frame does not have, and memory stays proportional to the given bytes.
  std::mt19937_64 random(1);
  std::size_t taken = 0;
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = good;
    for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
    if (!read_frame(bytes, read).ok()) continue;
    ++taken;
    for (const RefinementStep& step : read.decisions.steps) ASSERT_LT(step.pair, read.decisions.active_pairs);
    for (const std::uint32_t pair : read.decisions.reused) ASSERT_LT(pair, read.decisions.active_pairs);
    ASSERT_LE(read.decisions.steps.size() + read.decisions.reused.size(), bytes.size());
  }
  EXPECT_GT(taken, 0U);
}

TEST(Record, ACauseThatThereIsNotIsRefused) {
  RecordedFrame frame;
  frame.times.emplace().cause = MissCause::Release;
  std::string bytes;
  write_frame(frame, bytes);
  // Number of the frame, hash, four times, and the byte that says that times are there.
  const std::size_t at = 1 + 8 + 4 + 1;
  ASSERT_EQ(bytes[at], static_cast<char>(MissCause::Release));
  ASSERT_TRUE(read_frame(bytes, frame).ok());
  ++bytes[at];
  const Status refused = read_frame(bytes, frame);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().message, "the frame has a form that no writer makes");
}

TEST(Record, HeadersWithAWrongMemberAreRefusedByName) {
  const std::string good = header_json(some_header());
  ASSERT_TRUE(read_header(good, "header").ok());
  const auto refusal = [&](const std::string& part, const std::string& other) {
    std::string text = good;
    const std::size_t at = text.find(part);
    EXPECT_NE(at, std::string::npos) << part;
    text.replace(at, part.size(), other);
    const Result<RecordHeader> read = read_header(text, "header");
    return read ? std::string("accepted") : read.error().message;
  };
  EXPECT_EQ(refusal("\"contact\":\"paper\"", "\"contact\":\"glue\""),
            "header: world.contact = \"glue\", must be a name that this program knows");
  EXPECT_EQ(refusal("fedcba9876543210", "fedcba987654321"),
            "header: scene.start_hash = \"fedcba987654321\", must be 16 hexadecimal digits");
  EXPECT_EQ(refusal("\"threads\":3", "\"threads\":0").find("header: world.threads = 0"), 0U);
  EXPECT_EQ(refusal("\"polygons\":true,", "").find("header: step.polygons"), 0U);
  EXPECT_EQ(refusal("\"max_partners\":17", "\"max_partners\":17.5").find("header: world.max_partners = 17.5"), 0U);
}

TEST(Record, AFileOfTheSceneThatHasChangedIsRefusedWithItsName) {
  const TemporaryFolder folder;
  put(folder.file("tree.sph"), "one");
  Scene scene;
  scene.source = "a.json";
  scene.base = folder.path();
  scene.shapes.push_back({"rock", TreeSource{"tree.sph", 1, "", false, 0}});
  const std::vector<ShapePtr> shapes{make_sphere_shape(1).value()};
  const Result<std::vector<RecordedShape>> recorded = recorded_shapes(scene, shapes);
  ASSERT_TRUE(recorded.ok());
  EXPECT_EQ(recorded.value()[0].files.at(0).bytes, 3U);
  EXPECT_TRUE(check_files(scene, recorded.value()).ok());
  EXPECT_TRUE(check_shapes(scene, shapes, recorded.value()).ok());
  put(folder.file("tree.sph"), "two");
  const Status changed = check_files(scene, recorded.value());
  ASSERT_FALSE(changed.ok());
  EXPECT_EQ(changed.error().message.find("a.json: shapes.rock: " + folder.file("tree.sph") +
                                         " is another file than when the run was recorded: 3 bytes"),
            0U);
  std::filesystem::remove(folder.file("tree.sph"));
  EXPECT_FALSE(check_files(scene, recorded.value()).ok());
  const std::vector<ShapePtr> others{make_sphere_shape(std::nextafter(1.0, 2.0)).value()};
  const Status rebuilt = check_shapes(scene, others, recorded.value());
  ASSERT_FALSE(rebuilt.ok());
  EXPECT_EQ(rebuilt.error().message.find("a.json: shapes.rock: its sphere tree or mass comes out as "), 0U);
}

}  // namespace
}  // namespace poise::io
