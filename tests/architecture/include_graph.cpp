// SPDX-License-Identifier: MIT
#include "architecture/include_graph.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <sstream>
#include <string_view>
#include <vector>

#include "architecture/source_rules.h"

namespace poise::tests {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 6> kCode{"include", "scheduler", "src", "bench", "examples", "python"};

/// A box of the picture: rooms that are linked into one library.
struct Library {
  std::string_view name, color, edge;
  std::vector<std::string_view> rooms;
};

// The latest first; a room that is in no library is drawn alone.
const std::vector<Library>& libraries() {
  static const std::vector<Library> all{
      {"bench, examples and the Python module", "#f3f1ee", "#a39c92", {"bench", "examples", "python"}},
      {"command poise (poise_app, poise_capture, poise_sweep)", "#fdeee3", "#d9894f", {"app", "capture", "sweep"}},
      {"poise::scene", "#fdf6dc", "#c9a227", {"scene", "record"}},
      {"poise::assets", "#e9f5e6", "#6aa85c", {"assets"}},
      {"poise::poise",
       "#e6f0fa",
       "#4f86c0",
       {"api", "verify", "frame", "world", "query", "solver", "collision", "dynamics", "interface", "geometry",
        "parallel", "values"}},
      {"poise::scheduler", "#f1e8f8", "#8d64b0", {"scheduler", "math"}},
  };
  return all;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// The path in the checkout of an include in quotes.
std::optional<std::string> led_to(const fs::path& root, const fs::path& from, const std::string& name) {
  for (const fs::path& base : {fs::path("include"), fs::path("src"), fs::path("bench"), from.parent_path()}) {
    if (fs::exists(root / base / name)) return (base / name).lexically_normal().generic_string();
  }
  return std::nullopt;
}

void read_file(IncludeGraph& graph, const fs::path& root, const std::string& path) {
  static const std::regex include(R"re(^\s*#\s*include\s*"([^"]+)")re");
  const std::optional<RoomInOrder> room = room_in_order(path);
  if (!room) return;
  const std::string name(room->name);
  RoomContent& content = graph.rooms[name];
  content.rank = room->rank;
  ++content.files;
  const fs::path relative(path);
  std::vector<std::string> parts;
  for (const fs::path& part : relative) parts.push_back(part.string());
  if (parts.size() > 3 && parts[0] == "src") content.folders.insert(parts[2]);
  if (parts.size() > 2 && (parts[0] == "bench" || parts[0] == "examples")) content.folders.insert(parts[1]);
  std::istringstream lines(text_of(root / relative));
  for (std::string line; std::getline(lines, line); ++content.lines) {
    std::smatch match;
    if (!std::regex_search(line, match, include)) continue;
    const std::optional<std::string> other = led_to(root, relative, match[1].str());
    const std::optional<RoomInOrder> target = other ? room_in_order(*other) : std::nullopt;
    if (target && target->name != name) ++graph.includes[{name, std::string(target->name)}];
  }
}

/// 12345 as 12,345.
std::string grouped(std::size_t number) {
  std::string text = std::to_string(number);
  for (std::size_t i = text.size(); i > 3; i -= 3) text.insert(i - 3, ",");
  return text;
}

/// Name of a folder of public headers in the picture.
std::string title_of(const std::string& room) {
  if (room == "interface") return "include/poise";
  if (room == "values") return "include/poise: values";
  return room;
}

constexpr double kRow = 54, kBox = 42, kLeft = 60, kBoxWidth = 380, kTitle = 22, kGap = 10;

/// Position of a room in the picture, and of the arrows at its right edge.
struct Row {
  const Library* library = nullptr;
  double top = 0;
  std::size_t place = 0;  // number of rows from the top
  std::size_t in = 0, out = 0;
};

/// An #include from one room to another.
struct Arrow {
  std::string from, to;
  std::size_t count = 0, span = 0;
  double start = 0, end = 0;  // heights
};

std::string number(double value) {
  std::ostringstream text;
  text << std::round(value * 10) / 10;
  return text.str();
}

std::string box_of(const std::string& name, const RoomContent& room, const Row& row) {
  std::string folders;
  for (const std::string& folder : room.folders) folders += (folders.empty() ? "" : " \xc2\xb7 ") + folder;
  const double middle = row.top + kBox / 2;
  const double first = folders.empty() ? middle + 5 : middle - 3;
  std::string svg = "<rect x=\"" + number(kLeft + 12) + "\" y=\"" + number(row.top) + "\" width=\"" +
                    number(kBoxWidth - 24) + "\" height=\"" + number(kBox) + "\" rx=\"7\" fill=\"white\" stroke=\"" +
                    std::string(row.library->edge) + "\" stroke-width=\"1.3\"/>\n";
  svg += "<text x=\"" + number(kLeft + 24) + "\" y=\"" + number(first) + "\" class=\"room\">" + title_of(name) +
         "</text>\n";
  svg += "<text x=\"" + number(kLeft + kBoxWidth - 22) + "\" y=\"" + number(first) + "\" class=\"size\">" +
         grouped(room.files) + " files, " + grouped(room.lines) + " lines</text>\n";
  if (!folders.empty())
    svg += "<text x=\"" + number(kLeft + 24) + "\" y=\"" + number(middle + 13) + "\" class=\"folders\">" + folders +
           "</text>\n";
  return svg;
}

/// Arrows in the order of the picture; every room includes values, so those are left out.
std::vector<Arrow> arrows_of(const IncludeGraph& graph, std::map<std::string, Row>& rows) {
  std::vector<Arrow> arrows;
  for (const auto& [ends, count] : graph.includes) {
    if (ends.second == "values") continue;
    const std::size_t from = rows[ends.first].place;
    const std::size_t to = rows[ends.second].place;
    arrows.push_back({ends.first, ends.second, count, from < to ? to - from : from - to, 0, 0});
    ++rows[ends.first].out;
    ++rows[ends.second].in;
  }
  // Shorter arrows are drawn inside longer ones: at the room that they enter they end above those, at the room that
  // they leave they begin below.
  std::ranges::stable_sort(arrows, {}, &Arrow::span);
  std::map<std::string, std::size_t> begun, ended;
  for (Arrow& arrow : arrows) {
    const Row& from = rows[arrow.from];
    const Row& to = rows[arrow.to];
    const auto spread = [](std::size_t index, std::size_t all) {
      return (static_cast<double>(index) + 0.5) / static_cast<double>(all) * (kBox / 2 - 4);
    };
    arrow.start = from.top + kBox - 3 - spread(begun[arrow.from]++, from.out);
    arrow.end = to.top + 3 + spread(ended[arrow.to]++, to.in);
  }
  std::ranges::reverse(arrows);
  return arrows;
}

std::string path_of(const Arrow& arrow, bool wrong, std::string_view color) {
  const double side = wrong ? kLeft + 12 : kLeft + kBoxWidth - 12;
  const double reach = wrong ? -20 - 15 * static_cast<double>(arrow.span) : 34 + 40 * static_cast<double>(arrow.span);
  const double wide = 0.7 + 0.5 * std::log2(static_cast<double>(arrow.count));
  const double head = (wrong ? -1 : 1) * (4 + 1.6 * wide);
  const std::string paint = wrong ? "#d00000" : std::string(color);
  const std::string opacity = number(std::min(0.95, 0.45 + 0.1 * std::log2(static_cast<double>(arrow.count))));
  const double half = 1.6 + wide;
  return "<g opacity=\"" + opacity + "\"><title>" + arrow.from + " includes " + arrow.to + ", " +
         std::to_string(arrow.count) + " lines</title><path d=\"M" + number(side) + " " + number(arrow.start) + " C" +
         number(side + reach) + " " + number(arrow.start) + " " + number(side + reach) + " " + number(arrow.end) + " " +
         number(side + head) + " " + number(arrow.end) + "\" fill=\"none\" stroke=\"" + paint + "\" stroke-width=\"" +
         number(wide) + "\"/><path d=\"M" + number(side) + " " + number(arrow.end) + " l" + number(head) + " " +
         number(-half) + " v" + number(2 * half) + " z\" fill=\"" + paint + "\"/></g>\n";
}

}  // namespace

IncludeGraph read_include_graph(const fs::path& root) {
  IncludeGraph graph;
  for (const std::string_view folder : kCode) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string ending = entry.path().extension().string();
      if (entry.is_regular_file() && (ending == ".h" || ending == ".cpp"))
        read_file(graph, root, entry.path().lexically_relative(root).generic_string());
    }
  }
  return graph;
}

std::set<std::string> against_order(const IncludeGraph& graph) {
  std::set<std::string> wrong;
  for (const auto& [arrow, count] : graph.includes) {
    const int from = graph.rooms.at(arrow.first).rank;
    const auto other = graph.rooms.find(arrow.second);
    if (other != graph.rooms.end() && other->second.rank > from) wrong.insert(arrow.first + " -> " + arrow.second);
  }
  return wrong;
}

std::string to_svg(const IncludeGraph& graph) {
  std::map<std::string, Row> rows;
  std::string bands;
  double y = 12;
  std::size_t place = 0;
  for (const Library& library : libraries()) {
    const double top = y;
    y += kTitle;
    for (const std::string_view name : library.rooms) {
      if (!graph.rooms.contains(std::string(name))) continue;
      rows[std::string(name)] = {&library, y, place++, 0, 0};
      y += kRow;
    }
    bands += "<rect x=\"" + number(kLeft) + "\" y=\"" + number(top) + "\" width=\"" + number(kBoxWidth) +
             "\" height=\"" + number(y - top - 2) + "\" rx=\"9\" fill=\"" + std::string(library.color) +
             "\" stroke=\"" + std::string(library.edge) + "\"/>\n<text x=\"" + number(kLeft + 13) + "\" y=\"" +
             number(top + 16) + "\" class=\"library\" fill=\"" + std::string(library.edge) + "\">" +
             std::string(library.name) + "</text>\n";
    y += kGap;
  }
  std::string body;
  double reach = 0;
  for (const Arrow& arrow : arrows_of(graph, rows)) {
    const bool wrong = rows[arrow.from].place > rows[arrow.to].place;
    body += path_of(arrow, wrong, rows[arrow.from].library->edge);
    reach = std::max(reach, 0.75 * (34 + 40 * static_cast<double>(arrow.span)));
  }
  for (const auto& [name, row] : rows) body += box_of(name, graph.rooms.at(name), row);
  const std::string width = number(kLeft + kBoxWidth + reach + 10);
  const std::string height = number(y + 34);
  return "<!-- Made by the target architecture_picture from the #include lines of the code. -->\n"
         "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" +
         width + "\" height=\"" + height + "\" viewBox=\"0 0 " + width + " " + height +
         "\" font-family=\"Helvetica, Arial, sans-serif\">\n"
         "<style>.room{font-size:15px;font-weight:bold;fill:#1d2733}.folders{font-size:11px;fill:#41505f}"
         ".size{font-size:10.5px;fill:#7a8794;text-anchor:end}.library{font-size:12.5px;font-weight:bold}"
         ".note{font-size:12px;fill:#5a6672}.ground{fill:#ffffff}"
         "@media (prefers-color-scheme: dark){.ground{fill:#14191f}.note{fill:#a3adb8}}</style>\n"
         "<rect width=\"100%\" height=\"100%\" class=\"ground\"/>\n" +
         bands + body + "<text x=\"" + number(kLeft) + "\" y=\"" + number(y + 14) +
         "\" class=\"note\">An arrow: a room includes headers of another; the thicker, the more lines. Arrows to the "
         "values, which all rooms include, are left out.</text>\n</svg>\n";
}

}  // namespace poise::tests
