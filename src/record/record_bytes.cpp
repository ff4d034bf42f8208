// SPDX-License-Identifier: MIT
#include "record/record_bytes.h"

#include <algorithm>
#include <array>
#include <limits>

#include "frame/stage_list.h"

namespace poise::io {
namespace {

constexpr std::size_t kMostWorkers = 256;
constexpr unsigned kKindBits = 2;
// Bits of the byte of marks of a frame.
constexpr std::uint8_t kLearns = 1, kCrowded = 2, kUnfinished = 4, kStopped = 8;

// Seven bits a byte, the lowest first; the top bit means that more bytes follow (LEB128 of the DWARF standard).
void put(std::uint64_t value, std::string& out) {
  while (value >= 0x80U) {
    out.push_back(static_cast<char>(value | 0x80U));
    value >>= 7U;
  }
  out.push_back(static_cast<char>(value));
}

void put(Nanoseconds time, std::string& out) {
  put(static_cast<std::uint64_t>(std::max<std::int64_t>(time.count(), 0)), out);
}

void put_fixed(std::uint64_t value, std::string& out) {
  for (int byte = 0; byte < 8; ++byte) out.push_back(static_cast<char>(value >> (8 * byte)));
}

// Maps small differences of either sign to small numbers.
std::uint64_t folded(std::uint32_t value, std::uint32_t before) {
  const std::int64_t change = static_cast<std::int64_t>(value) - static_cast<std::int64_t>(before);
  return change < 0 ? (static_cast<std::uint64_t>(-(change + 1)) << 1U) | 1U : static_cast<std::uint64_t>(change) << 1U;
}

// Adds a folded change to a number below `end`, which is at most 2^32. False if the sum is not such a number.
bool unfold(std::uint64_t change, std::uint64_t end, std::uint32_t& number) {
  const std::uint64_t half = change >> 1U;
  // Also keeps the sums below within 64 bits.
  if (half >= end) return false;
  const std::uint64_t sum = (change & 1U) != 0 ? std::uint64_t{number} - half - 1 : std::uint64_t{number} + half;
  if (sum >= end) return false;
  number = static_cast<std::uint32_t>(sum);
  return true;
}

class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  std::uint64_t number() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const std::uint8_t byte = this->byte();
      if (shift == 63 && byte > 1) sound_ = false;
      value |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
      if ((byte & 0x80U) == 0) return value;
    }
    sound_ = false;
    return 0;
  }
  std::uint8_t byte() {
    if (at_ == bytes_.size()) {
      sound_ = false;
      return 0;
    }
    return static_cast<std::uint8_t>(bytes_[at_++]);
  }
  std::uint64_t fixed() {
    std::uint64_t value = 0;
    for (int i = 0; i < 8; ++i) value |= static_cast<std::uint64_t>(byte()) << (8 * i);
    return value;
  }
  std::uint32_t number32() {
    const std::uint64_t value = number();
    if (value > std::numeric_limits<std::uint32_t>::max()) sound_ = false;
    return static_cast<std::uint32_t>(value);
  }
  Nanoseconds time() {
    const std::uint64_t value = number();
    if (value > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) sound_ = false;
    return Nanoseconds(static_cast<std::int64_t>(value));
  }
  // Reads a count of items that take at least a byte each.
  std::size_t count() {
    const std::uint64_t value = number();
    if (value > left()) sound_ = false;
    return sound_ ? static_cast<std::size_t>(value) : 0;
  }
  void refuse() { sound_ = false; }
  [[nodiscard]] bool sound() const { return sound_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] Status end(const char* what) const {
    if (sound_ && left() == 0) return Done{};
    return bad_input(std::string(what) + " has a form that no writer makes");
  }

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
  bool sound_ = true;
};

// Each step is stored relative to the previous one of the same worker, whose pairs ascend within a band. The workers
// are stored separately, since they compress to almost nothing.
void put_steps(const std::vector<RefinementStep>& steps, std::string& out) {
  put(steps.size(), out);
  std::array<std::uint32_t, kMostWorkers> before{};
  bool alone = true;
  for (const RefinementStep& step : steps) {
    put(folded(step.pair, before[step.worker]) << kKindBits | static_cast<std::uint64_t>(step.kind), out);
    before[step.worker] = step.pair;
    alone = alone && step.worker == 0;
  }
  out.push_back(alone ? '\0' : '\1');
  if (alone) return;
  for (const RefinementStep& step : steps) out.push_back(static_cast<char>(step.worker));
}

void take_steps(std::uint32_t pairs, Reader& reader, std::vector<RefinementStep>& steps) {
  steps.assign(reader.count(), {});
  // Passed over first, because decoding them needs the workers, which are stored after them.
  Reader words = reader;
  for (std::size_t i = 0; i < steps.size(); ++i) reader.number();
  const std::uint8_t several = reader.byte();
  if (several > 1) reader.refuse();
  if (several == 1) {
    for (RefinementStep& step : steps) step.worker = reader.byte();
  }
  if (!reader.sound()) return;
  std::array<std::uint32_t, kMostWorkers> before{};
  for (RefinementStep& step : steps) {
    const std::uint64_t word = words.number();
    const std::uint64_t kind = word & ((1U << kKindBits) - 1U);
    if (kind > static_cast<std::uint64_t>(RefinementStep::Kind::Full) ||
        !unfold(word >> kKindBits, pairs, before[step.worker]))
      return reader.refuse();
    step.kind = static_cast<RefinementStep::Kind>(kind);
    step.pair = before[step.worker];
  }
}

void put_ascending(const std::vector<std::uint32_t>& numbers, std::string& out) {
  put(numbers.size(), out);
  std::uint32_t before = 0;
  for (const std::uint32_t number : numbers) {
    put(folded(number, before), out);
    before = number;
  }
}

// Numbers below `end`.
void take_ascending(std::uint64_t end, Reader& reader, std::vector<std::uint32_t>& numbers) {
  numbers.assign(reader.count(), 0);
  std::uint32_t sum = 0;
  for (std::uint32_t& number : numbers) {
    if (!unfold(reader.number(), end, sum)) return reader.refuse();
    number = sum;
  }
}

constexpr std::uint64_t kMostSlots = std::uint64_t{1} << 32U;

// Whether all took part again, the islands that wait for several steps, and for how many.
void put_paused(const FrameDecisions& d, std::string& out) {
  out.push_back(d.resumed ? '\1' : '\0');
  std::vector<std::uint32_t> roots;
  for (const PausedIsland& island : d.paused) roots.push_back(island.root);
  put_ascending(roots, out);
  for (const PausedIsland& island : d.paused) out.push_back(static_cast<char>(island.steps));
}

void take_paused(Reader& reader, FrameDecisions& d) {
  const std::uint8_t resumed = reader.byte();
  if (resumed > 1) reader.refuse();
  d.resumed = resumed == 1;
  std::vector<std::uint32_t> roots;
  take_ascending(kMostSlots, reader, roots);
  d.paused.clear();
  for (const std::uint32_t root : roots) d.paused.push_back({root, reader.byte()});
}

// One a substep, if there are any.
void put_stopped(const FrameDecisions& d, std::string& out) {
  if (d.stopped_after.empty()) return;
  put(d.stopped_after.size(), out);
  for (const std::uint32_t iterations : d.stopped_after) put(iterations, out);
}

void take_stopped(bool there, Reader& reader, FrameDecisions& d) {
  constexpr std::uint32_t kMostSubsteps = 16;
  d.stopped_after.clear();
  if (!there) return;
  const std::uint32_t count = reader.number32();
  if (count == 0 || count > kMostSubsteps) return reader.refuse();
  for (std::uint32_t k = 0; k < count; ++k) d.stopped_after.push_back(reader.number32());
}

// 0, or 1 and the times.
void put_times(const std::optional<RecordedTimes>& times, std::string& out) {
  out.push_back(times ? '\1' : '\0');
  if (!times) return;
  out.push_back(static_cast<char>(times->cause));
  put(times->release_delay, out);
  put(times->host, out);
  for (const simulation::StageMember& stage : simulation::kStages) put(times->stages.*stage.time, out);
  put(times->piece, out);
  put(times->piece_a, out);
  put(times->piece_b, out);
}

void take_times(Reader& reader, std::optional<RecordedTimes>& times) {
  times.reset();
  const std::uint8_t there = reader.byte();
  if (there > 1) reader.refuse();
  if (there != 1) return;
  times.emplace();
  const std::uint8_t cause = reader.byte();
  if (cause > static_cast<std::uint8_t>(MissCause::Release)) return reader.refuse();
  times->cause = static_cast<MissCause>(cause);
  times->release_delay = reader.time();
  times->host = reader.time();
  for (const simulation::StageMember& stage : simulation::kStages) times->stages.*stage.time = reader.time();
  times->piece = reader.time();
  times->piece_a = reader.number32();
  times->piece_b = reader.number32();
}

}  // namespace

void write_frame(const RecordedFrame& frame, std::string& out) {
  const FrameDecisions& d = frame.decisions;
  put(d.frame, out);
  put_fixed(frame.state_hash, out);
  for (const Nanoseconds time : {frame.budget, frame.refine_available, frame.reserve, frame.lateness}) put(time, out);
  put_times(frame.times, out);
  put(d.active_pairs, out);
  put(d.substeps, out);
  put(d.point_iterations, out);
  out.push_back(static_cast<char>((d.learns ? kLearns : 0) | (d.crowded_partners > 0 ? kCrowded : 0) |
                                  (d.unfinished ? kUnfinished : 0) | (d.stopped_after.empty() ? 0 : kStopped)));
  if (d.crowded_partners > 0) put(d.crowded_partners, out);
  put_stopped(d, out);
  put_ascending(d.reused, out);
  put_ascending(d.held, out);
  put_paused(d, out);
  put_steps(d.steps, out);
}

Status read_frame(std::string_view bytes, RecordedFrame& frame) {
  Reader reader(bytes);
  FrameDecisions& d = frame.decisions;
  d.frame = reader.number();
  frame.state_hash = reader.fixed();
  for (Nanoseconds* time : {&frame.budget, &frame.refine_available, &frame.reserve, &frame.lateness})
    *time = reader.time();
  take_times(reader, frame.times);
  d.active_pairs = reader.number32();
  d.substeps = reader.number32();
  d.point_iterations = reader.number32();
  const std::uint8_t marks = reader.byte();
  if (marks > (kLearns | kCrowded | kUnfinished | kStopped)) reader.refuse();
  d.unfinished = (marks & kUnfinished) != 0;
  d.learns = (marks & kLearns) != 0;
  d.crowded_partners = (marks & kCrowded) != 0 ? reader.number32() : 0;
  take_stopped((marks & kStopped) != 0, reader, d);
  take_ascending(d.active_pairs, reader, d.reused);
  take_ascending(kMostSlots, reader, d.held);
  take_paused(reader, d);
  take_steps(d.active_pairs, reader, d.steps);
  return reader.end("the frame");
}

void write_end(const RecordEnd& end, std::string& out) {
  put(end.frames, out);
  out.push_back(end.stopped ? '\1' : '\0');
}

Status read_end(std::string_view bytes, RecordEnd& end) {
  Reader reader(bytes);
  end.frames = reader.number();
  const std::uint8_t stopped = reader.byte();
  if (stopped > 1) reader.refuse();
  end.stopped = stopped == 1;
  return reader.end("the end");
}

}  // namespace poise::io
