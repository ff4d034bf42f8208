// SPDX-License-Identifier: MIT
#include "scene/run/trace_document.h"
#include "scene/run/milliseconds.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

namespace poise::io {
namespace {

double us(Nanoseconds time) { return static_cast<double>(time.count()) / 1e3; }

// A JSON string, quotes included.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

std::string name_event(const char* what, int lane, const std::string& name) {
  return fmt::format(R"({{"name":"{}","ph":"M","pid":1,"tid":{},"args":{{"name":{}}}}})", what, lane, quoted(name));
}

}  // namespace

std::string trace_begin(const TraceHead& head) {
  std::string out = "[\n" + name_event("process_name", 0, head.process);
  for (int lane = 0; lane < head.threads; ++lane) {
    out += ",\n" +
           name_event("thread_name", lane, lane == 0 ? std::string("calling thread") : fmt::format("worker {}", lane));
  }
  return out;
}

void append_spans(std::span<const TraceSpan> spans, std::span<const std::array<std::uint64_t, 2>> pairs,
                  SteadyClock::time_point zero, std::string& out) {
  const auto end = std::back_inserter(out);
  std::size_t pieces = 0;
  for (const TraceSpan& span : spans) {
    fmt::format_to(
        end,
        ",\n{{\"name\":\"{}\",\"ph\":\"X\",\"pid\":1,\"tid\":{},\"ts\":{:.3f},\"dur\":{:.3f},\"args\":{{\"frame\":{}",
        trace_name(span.stage), span.lane, us(span.begin - zero), us(span.end - span.begin), span.frame);
    if (span.stage == TraceStage::Worker) fmt::format_to(end, ",\"levels\":{}", span.jobs);
    if (span.stage == TraceStage::Piece) {
      const std::array<std::uint64_t, 2> pair =
          pieces < pairs.size() ? pairs[pieces++] : std::array<std::uint64_t, 2>{};
      fmt::format_to(end, ",\"body_a\":{},\"body_b\":{},\"units\":{}", pair[0], pair[1], span.units);
    }
    out += "}}";
  }
}

void append_counters(const simulation::RunFrame& frame, SteadyClock::time_point zero, std::uint64_t& misses,
                     std::string& out) {
  const auto end = std::back_inserter(out);
  const FrameReport& r = frame.report;
  const bool late = r.lateness.count() > 0;
  misses += frame.releases_skipped + (late ? 1 : 0);
  const double at = us(r.started + r.times.total - zero);
  const auto counter = [&](const char* name) {
    fmt::format_to(end, ",\n{{\"name\":\"{}\",\"ph\":\"C\",\"pid\":1,\"tid\":0,\"ts\":{:.3f},\"args\":{{", name, at);
  };
  counter("budget");
  fmt::format_to(end, "\"ms\":{}}}}}", ms(r.budget));
  counter("reserve");
  fmt::format_to(end, "\"ms\":{}}}}}", ms(r.reserve_at_cut));
  counter("misses");
  fmt::format_to(end, "\"count\":{}}}}}", misses);
  counter("contacts by level");
  for (std::size_t level = 0; level <= kMaxTreeDepth; ++level)
    fmt::format_to(end, "\"{}\":{},", level, r.level_histogram[level]);
  fmt::format_to(end, "\"polygons\":{}}}}}", r.level_histogram[kPolygonBin]);
  if (late) {
    fmt::format_to(
        end,
        ",\n{{\"name\":\"miss: "
        "{}\",\"ph\":\"i\",\"s\":\"t\",\"pid\":1,\"tid\":0,\"ts\":{:.3f},\"args\":{{\"frame\":{},\"late_ms\":{}}}}}",
        simulation::cause_name(r.cause), at, r.frame, ms(r.lateness));
  }
}

std::string trace_end(const TraceHead& head) {
  return ",\n" +
         fmt::format(R"({{"name":"poise.trace","ph":"M","pid":1,"tid":0,"args":{{"discarded":{}}}}})", head.discarded) +
         "\n]\n";
}

}  // namespace poise::io
