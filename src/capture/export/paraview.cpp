// SPDX-License-Identifier: MIT
#include "capture/export/paraview.h"

#include <fmt/format.h>

#include <type_traits>

#include "capture/bytes.h"
#include "capture/export/drawn_mesh.h"

namespace poise::capture {
namespace {

/// A .vtp with its arrays appended as they are, each with its size before it. Invariant: offsets in `xml_` are of
/// `data_`.
class PolyData {
 public:
  PolyData(std::size_t points, std::size_t vertices, std::size_t polygons) {
    xml_ = fmt::format(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "<PolyData><Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
        "NumberOfPolys=\"{}\">\n",
        points, vertices, polygons);
  }
  void open(const char* element) { xml_ += fmt::format("<{}>\n", element); }
  void close(const char* element) { xml_ += fmt::format("</{}>\n", element); }
  template <class T>
  void array(const char* name, int width, const std::vector<T>& values) {
    const char* type = std::is_same_v<T, float>          ? "Float32"
                       : std::is_same_v<T, double>       ? "Float64"
                       : std::is_same_v<T, std::uint8_t> ? "UInt8"
                                                         : "Int64";
    xml_ += fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, width, data_.size());
    put(std::uint64_t{values.size() * sizeof(T)}, data_);
    for (const T value : values) put(value, data_);
  }
  std::string made() {
    return xml_ + "</Piece></PolyData>\n<AppendedData encoding=\"raw\">\n_" + data_ + "\n</AppendedData>\n</VTKFile>\n";
  }

 private:
  std::string xml_, data_;
};

/// Cells of `corners` points each, in the order of the list.
void cells(PolyData& file, const char* element, const std::vector<std::int64_t>& points, std::int64_t corners) {
  std::vector<std::int64_t> ends;
  for (std::int64_t end = corners; end <= static_cast<std::int64_t>(points.size()); end += corners) ends.push_back(end);
  file.open(element);
  file.array("connectivity", 1, points);
  file.array("offsets", 1, ends);
  file.close(element);
}

}  // namespace

std::string FrameDrawer::vtp(const PackedFrame& frame) {
  constexpr double kNever = -1;
  position_m_.resize(reader_.bodies().size(), Vec3::Zero());
  time_s_.resize(reader_.bodies().size(), kNever);
  std::vector<double> points, orientation, radius, speed, mass;
  std::vector<std::int64_t> number, shape, order;
  for (std::size_t i = 0; i < frame.rows.size(); ++i) {
    const std::uint32_t row = frame.rows[i];
    const CapturedBody& body = reader_.bodies()[row];
    const Pose pose = reader_.pose(frame.poses[i]);
    points.insert(points.end(), {pose.position_m.x(), pose.position_m.y(), pose.position_m.z()});
    const Quat& q = pose.orientation;
    orientation.insert(orientation.end(), {q.w(), q.x(), q.y(), q.z()});
    number.push_back(static_cast<std::int64_t>(body.number));
    shape.push_back(body.shape);
    order.push_back(static_cast<std::int64_t>(i));
    radius.push_back(reader_.header().shapes[body.shape].radius_m);
    mass.push_back(body.mass_kg);
    const double passed_s = frame.facts.time_s - time_s_[row];
    const bool known = time_s_[row] >= 0 && passed_s > 0;
    speed.push_back(known ? (pose.position_m - position_m_[row]).norm() / passed_s : 0);
    position_m_[row] = pose.position_m;
    time_s_[row] = frame.facts.time_s;
  }
  PolyData file(frame.rows.size(), frame.rows.size(), 0);
  file.open("PointData");
  file.array("number", 1, number);
  file.array("shape", 1, shape);
  file.array("radius", 1, radius);
  file.array("orientation", 4, orientation);
  file.array("state", 1, frame.activity);
  file.array("level", 1, frame.level);
  file.array("priority", 1, frame.priority);
  file.array("speed", 1, speed);
  file.array("mass", 1, mass);
  file.close("PointData");
  file.open("Points");
  file.array("Points", 3, points);
  file.close("Points");
  cells(file, "Verts", order, 1);
  return file.made();
}

std::string shape_vtp(const CapturedShape& shape, double reach_m) {
  const DrawnMesh mesh = drawn_mesh(shape, reach_m);
  std::vector<float> points;
  for (const std::array<float, 3>& vertex : mesh.vertices_m) points.insert(points.end(), vertex.begin(), vertex.end());
  std::vector<std::int64_t> corners;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles)
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  PolyData file(mesh.vertices_m.size(), 0, mesh.triangles.size());
  file.open("Points");
  file.array("Points", 3, points);
  file.close("Points");
  cells(file, "Polys", corners, 3);
  return file.made();
}

std::string pvd(const std::vector<std::pair<double, std::string>>& frames) {
  std::string xml =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (const auto& [time_s, file] : frames)
    xml += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", time_s, file);
  return xml + "</Collection>\n</VTKFile>\n";
}

}  // namespace poise::capture
