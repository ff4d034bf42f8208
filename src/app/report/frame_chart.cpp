// SPDX-License-Identifier: MIT
#include "app/report/frame_chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/picture/pixel_text.h"
#include "frame/stage_list.h"
#include "scene/run/milliseconds.h"

namespace poise::app {
namespace {

using Color = std::array<std::uint8_t, 3>;
constexpr double kLeft = 80, kRight = 20, kTop = 96, kBottom = 52;
constexpr std::uint32_t kTextScale = 2;

// As the page of the viewer has them: distinct for most people with impaired colour vision (Okabe and Ito 2008).
constexpr std::array<Color, 8> kStageColors{{{0x56, 0xb4, 0xe9},
                                             {0x00, 0x72, 0xb2},
                                             {0xcc, 0x79, 0xa7},
                                             {0x00, 0x9e, 0x73},
                                             {0xf0, 0xe4, 0x42},
                                             {0xe6, 0x9f, 0x00},
                                             {0x8c, 0x8c, 0x8c},
                                             {0xc4, 0xc4, 0xc4}}};
constexpr Color kDeadline{0xd5, 0x5e, 0x00}, kGrid{0xdd, 0xdd, 0xdd}, kInk{0x1a, 0x20, 0x27}, kWhite{255, 255, 255};

struct Cause {
  MissCause cause;
  Color color;
};
constexpr std::array<Cause, 5> kCauses{{{MissCause::Infeasible, kDeadline},
                                        {MissCause::Machine, {0x7a, 0x7a, 0x7a}},
                                        {MissCause::Overrun, {0xcc, 0x79, 0xa7}},
                                        {MissCause::Forecast, {0x00, 0x72, 0xb2}},
                                        {MissCause::Release, {0xe6, 0x9f, 0x00}}}};

Color color_of(MissCause cause) {
  for (const Cause& known : kCauses) {
    if (known.cause == cause) return known.color;
  }
  return kInk;
}

double total_ms(const simulation::RunFrame& frame) { return ms(frame.report.times.total); }

/// A round step of which four to ten make up the range.
double tick_step(double range) {
  const double power = std::pow(10, std::floor(std::log10(range / 4)));
  for (const double factor : {5.0, 2.0}) {
    if (4 * factor * power <= range) return factor * power;
  }
  return power;
}

/// Builds the chart part by part; `most_ms` is the top of its scale.
class Builder {
 public:
  Builder(std::span<const simulation::RunFrame> frames, double most_ms) : frames_(frames), most_ms_(most_ms) {
    chart_.boxes.push_back({0, 0, double(chart_.width_px), double(chart_.height_px), kWhite});
  }

  void axes() {
    for (double tick = 0; tick <= most_ms_; tick += tick_step(most_ms_)) {
      chart_.boxes.push_back({kLeft, y(tick), plot_width(), 1, kGrid});
      text(kLeft - 8, y(tick) + 6, ChartText::Anchor::End, fmt::format("{:g}", tick));
    }
    text(8, kTop - 10, ChartText::Anchor::Start, "ms");
    const auto count = static_cast<double>(frames_.size());
    const double step = std::max(1.0, tick_step(std::max(count, 4.0)));
    for (double frame = 0; frame < count; frame += step)
      text(x(frame), kTop + plot_height() + 20, ChartText::Anchor::Middle, fmt::format("{:g}", frame));
    text(kLeft + plot_width() / 2, kTop + plot_height() + 42, ChartText::Anchor::Middle, "frame");
  }

  void columns() {
    const std::size_t most = static_cast<std::size_t>(plot_width());
    const std::size_t count = std::min(most, frames_.size());
    for (std::size_t column = 0; column < count; ++column) {
      const std::size_t first = column * frames_.size() / count;
      const std::size_t last = (column + 1) * frames_.size() / count;
      const auto part = frames_.subspan(first, last - first);
      const auto slowest = std::max_element(part.begin(), part.end(),
                                            [](const auto& a, const auto& b) { return total_ms(a) < total_ms(b); });
      stack(*slowest, x(double(first)), x(double(last)) - x(double(first)));
    }
  }

  void deadline(double deadline_ms) {
    if (deadline_ms > most_ms_) return;
    for (double at = kLeft; at < kLeft + plot_width(); at += 16)
      chart_.boxes.push_back({at, y(deadline_ms) - 1, std::min(10.0, kLeft + plot_width() - at), 2, kDeadline});
  }

  void late_frames() {
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      const FrameReport& report = frames_[i].report;
      if (report.cause != MissCause::None)
        chart_.boxes.push_back({x(double(i) + 0.5) - 4, kTop - 14, 8, 8, color_of(report.cause)});
    }
  }

  void legend(const std::string& title) {
    text(kLeft, 22, ChartText::Anchor::Start, title);
    double at = kLeft;
    for (std::size_t stage = 0; stage < simulation::kStages.size(); ++stage)
      at = entry(at, 36, kStageColors[stage], simulation::kStages[stage].name);
    at = kLeft;
    for (const Cause& known : kCauses) {
      const auto late = std::count_if(frames_.begin(), frames_.end(),
                                      [&](const auto& frame) { return frame.report.cause == known.cause; });
      if (late > 0)
        at = entry(at, 58, known.color, fmt::format("late, {}: {}", simulation::cause_name(known.cause), late));
    }
  }

  FrameChart take() { return std::move(chart_); }

 private:
  [[nodiscard]] double plot_width() const { return chart_.width_px - kLeft - kRight; }
  [[nodiscard]] double plot_height() const { return chart_.height_px - kTop - kBottom; }
  [[nodiscard]] double x(double frame) const {
    return kLeft + plot_width() * frame / std::max(1.0, static_cast<double>(frames_.size()));
  }
  [[nodiscard]] double y(double time_ms) const {
    return kTop + plot_height() * (1 - std::min(1.0, time_ms / most_ms_));
  }
  void text(double x, double y, ChartText::Anchor anchor, std::string text) {
    chart_.texts.push_back({x, y, anchor, std::move(text)});
  }
  double entry(double x, double y, const Color& color, const std::string& name) {
    chart_.boxes.push_back({x, y, 14, 14, color});
    text(x + 20, y + 13, ChartText::Anchor::Start, name);
    return x + 20 + io::text_width_px(name, kTextScale) + 16;
  }
  void stack(const simulation::RunFrame& frame, double left, double width) {
    double sum_ms = 0;
    for (std::size_t stage = 0; stage < simulation::kStages.size(); ++stage) {
      const double from = y(sum_ms);
      sum_ms += ms(frame.report.times.*simulation::kStages[stage].time);
      if (from > y(sum_ms)) chart_.boxes.push_back({left, y(sum_ms), width, from - y(sum_ms), kStageColors[stage]});
    }
  }

  std::span<const simulation::RunFrame> frames_;
  double most_ms_;
  FrameChart chart_;
};

/// One frame that took very long must not press the others flat.
double top_of(std::optional<double> deadline_ms, std::span<const simulation::RunFrame> frames) {
  std::vector<double> times;
  for (const simulation::RunFrame& frame : frames) times.push_back(total_ms(frame));
  std::sort(times.begin(), times.end());
  const double slowest = times.empty() ? 1 : times.back();
  const double p99 = times.empty() ? 1 : times[(99 * times.size() + 99) / 100 - 1];
  const double shown = deadline_ms && *deadline_ms < 8 * slowest ? *deadline_ms : 0;
  return std::max({1.12 * shown, std::min(1.05 * slowest, 1.6 * p99), 1e-3});
}

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

}  // namespace

FrameChart frame_chart(const std::string& scene, std::optional<double> deadline_ms,
                       std::span<const simulation::RunFrame> frames) {
  Builder builder(frames, top_of(deadline_ms, frames));
  builder.axes();
  builder.columns();
  if (deadline_ms) builder.deadline(*deadline_ms);
  builder.late_frames();
  builder.legend(fmt::format("{}: {} frames{}", scene, frames.size(),
                             deadline_ms ? fmt::format(", deadline {:g} ms", *deadline_ms) : std::string()));
  return builder.take();
}

std::string frame_chart_svg(const FrameChart& chart) {
  constexpr std::array kAnchors{"start", "middle", "end"};
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"17\" shape-rendering=\"crispEdges\">\n",
      chart.width_px, chart.height_px);
  for (const ChartBox& box : chart.boxes) {
    svg += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"#{:02x}{:02x}{:02x}\"/>\n", box.left,
        box.top, box.width, box.height, box.color[0], box.color[1], box.color[2]);
  }
  for (const ChartText& text : chart.texts) {
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n", text.x, text.y,
                       kAnchors[static_cast<std::size_t>(text.anchor)], escaped(text.text));
  }
  return svg + "</svg>\n";
}

io::Image frame_chart_image(const FrameChart& chart) {
  io::Image image{chart.width_px, chart.height_px, {}};
  image.rgb.resize(std::size_t{3} * chart.width_px * chart.height_px);
  // A box covers the pixels whose middle it holds, and at least one: a narrow column must not vanish.
  const auto span = [](double from, double size, std::uint32_t most) {
    const auto first = static_cast<std::int64_t>(std::ceil(from - 0.5));
    const auto last = std::max(first + 1, static_cast<std::int64_t>(std::ceil(from + size - 0.5)));
    return std::pair(std::clamp<std::int64_t>(first, 0, most), std::clamp<std::int64_t>(last, 0, most));
  };
  for (const ChartBox& box : chart.boxes) {
    const auto [left, right] = span(box.left, box.width, chart.width_px);
    const auto [top, bottom] = span(box.top, box.height, chart.height_px);
    for (std::int64_t y = top; y < bottom; ++y) {
      for (std::int64_t x = left; x < right; ++x) {
        const auto at = static_cast<std::size_t>(3 * (y * chart.width_px + x));
        std::copy(box.color.begin(), box.color.end(), image.rgb.begin() + static_cast<std::ptrdiff_t>(at));
      }
    }
  }
  for (const ChartText& text : chart.texts) {
    const double width = io::text_width_px(text.text, kTextScale);
    const double left = text.x - width * static_cast<double>(text.anchor) / 2;
    io::draw_text(image, text.text, std::lround(left), std::lround(text.y - io::kTextHeight * kTextScale), kTextScale,
                  kInk);
  }
  return image;
}

}  // namespace poise::app
