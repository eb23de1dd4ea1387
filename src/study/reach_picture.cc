#include "impedraw/study/reach_picture.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "impedraw/files/durable_file.h"
#include "impedraw/report/relief.h"

namespace impedraw {

namespace {

constexpr double kHalf = 130.0;   // of the square that is shown [mm]
constexpr double kSpacing = 1.0;  // of the points of a line [mm]
constexpr int kCells = 90;

nlohmann::json point(const Eigen::Vector2d& p) {
  return {std::round(10.0 * p.x()) / 10.0, std::round(10.0 * p.y()) / 10.0};
}

}  // namespace

void write_reach_picture(const Experiment& e, const RunData* run, const InkMatch* drawn,
                         const std::filesystem::path& file) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  const Eigen::Vector2d centre = e.artwork.placement.centre_m;
  const auto right_up = [&](const Eigen::Vector2d& p) {
    return Eigen::Vector2d(1e3 * (centre.y() - p.y()), 1e3 * (p.x() - centre.x()));
  };

  nlohmann::json json = {{"area", {-kHalf, kHalf, -kHalf, kHalf}},
                         {"ink", nlohmann::json::array()}};
  const auto parts = [&](const char* name, const std::vector<PlacedStroke>& strokes) {
    json[name] = nlohmann::json::array();
    for (const PlacedStroke& stroke : strokes) {
      nlohmann::json line = nlohmann::json::array();
      for (const Eigen::Vector2d& p : stroke.p_P) line.push_back(point(right_up(p)));
      json[name].push_back(line);
    }
  };
  parts("promised", e.plan.strokes);
  const std::vector<PlacedStroke>& asked = e.artwork.strokes;
  std::vector<PlacedStroke> lost;
  for (const Finding& f : e.plan.preflight.findings)
    lost.push_back(part_of(asked[static_cast<std::size_t>(f.part.stroke)], f.part.from, f.part.to));
  parts("undrawable", lost);

  for (std::size_t i = 0; drawn && i < drawn->lines.size(); ++i) {
    nlohmann::json line = nlohmann::json::array();
    Eigen::Vector2d last = Eigen::Vector2d::Constant(1e9);
    for (std::size_t row = drawn->lines[i].begin; row < drawn->lines[i].end; ++row) {
      const Eigen::Vector2d p = right_up((X_PW * run->contact_point[row]).head<2>());
      if ((p - last).norm() < kSpacing && row + 1 < drawn->lines[i].end) continue;
      line.push_back(point(p));
      last = p;
    }
    json["ink"].push_back(line);
  }

  const auto view = [&](const Eigen::Vector3d& v_W) {
    const Eigen::Vector3d p = X_PW * v_W;
    const Eigen::Vector2d q = right_up(p.head<2>());
    return Eigen::Vector3d(q.x(), -q.y(), 1e3 * p.z());
  };
  const Relief relief = make_relief(e.scene.canvas->mesh().vertices,
                                    e.scene.canvas->mesh().triangles, view, 2 * kCells);
  json["shade"] = nlohmann::json::array();
  for (int i = 0; i < kCells; ++i) {
    nlohmann::json row = nlohmann::json::array();
    for (int j = 0; j < kCells; ++j) {
      const Eigen::Vector2d p(kHalf * (2.0 * (j + 0.5) / kCells - 1.0),
                              kHalf * (2.0 * (i + 0.5) / kCells - 1.0));
      const Eigen::Vector2d at = (p - relief.area.min()).cwiseQuotient(relief.area.sizes());
      const int column = static_cast<int>(std::floor(at.x() * relief.columns)),
                line = static_cast<int>(std::floor(at.y() * relief.rows));
      const bool inside = column >= 0 && column < relief.columns && line >= 0 && line < relief.rows;
      const double shade = inside ? relief.shade(line, column) : std::nan("");
      row.push_back(std::isnan(shade)
                        ? nlohmann::json(nullptr)
                        : nlohmann::json(static_cast<int>(std::lround(255.0 * shade))));
    }
    json["shade"].push_back(row);
  }
  write_whole(file, json.dump());
}

}  // namespace impedraw
