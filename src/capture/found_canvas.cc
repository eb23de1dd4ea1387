#include "impedraw/capture/found_canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <set>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kSparse = 0.005, kGap = 0.01, kOnTable = 0.004, kAbove = 0.01;  // [m]
constexpr double kLeastOfTable = 0.15, kMostBehind = 0.02, kLeastOnTable = 0.02;
constexpr double kAboutMiddle = 0.03;  // [m]
constexpr double kLeastOfDrawing = 0.1;
constexpr int kTriples = 400;

struct TablePlane {
  Vector3d n = Vector3d::UnitZ();
  double d = 0.0;  // n·p = d
  double height(const Vector3d& p) const { return n.dot(p) - d; }
};

TablePlane fitted(const std::vector<Vector3d>& points, const TablePlane& about) {
  Vector3d mean = Vector3d::Zero();
  double n = 0.0;
  for (const Vector3d& p : points)
    if (std::abs(about.height(p)) < kOnTable) mean += p, ++n;
  mean /= std::max(n, 1.0);
  Eigen::Matrix3d C = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points)
    if (std::abs(about.height(p)) < kOnTable) C += (p - mean) * (p - mean).transpose();
  Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(C).eigenvectors().col(0);
  if (normal.dot(about.n) < 0.0) normal = -normal;
  return {normal, normal.dot(mean)};
}

std::optional<TablePlane> table_in(const std::vector<Vector3d>& points, const Vector3d& z_W) {
  constexpr double kFacing = 0.7;  // cosine
  const Vector3d up = Vector3d::UnitZ();
  std::mt19937 random(1);
  const auto any = [&] { return points[random() % points.size()]; };
  const auto count = [&](auto&& is) {
    return static_cast<double>(std::count_if(points.begin(), points.end(), is));
  };
  TablePlane best;
  double most = 0.0;
  for (int i = 0; i < kTriples; ++i) {
    const Vector3d a = any(), b = any(), c = any();
    TablePlane plane;
    plane.n = (b - a).cross(c - a).normalized();
    if (plane.n.dot(z_W + up) < 0.0) plane.n = -plane.n;
    if (!(std::max(plane.n.dot(z_W), plane.n.dot(up)) > kFacing)) continue;
    plane.d = plane.n.dot(a);
    const double on =
        count([&](const Vector3d& p) { return std::abs(plane.height(p)) < kOnTable; });
    if (on > most) best = plane, most = on;
  }
  if (most == 0.0) return {};
  best = fitted(points, fitted(points, best));
  const double n = static_cast<double>(points.size());
  const double on = count([&](const Vector3d&p) { return std::abs(best.height(p)) < kOnTable; }),
               behind = count([&](const Vector3d&p) { return best.height(p) < -kAbove; }),
               above = count([&](const Vector3d&p) { return best.height(p) > kAbove; });
  if (on < kLeastOfTable * n || behind > kMostBehind * n || above < kLeastOnTable * n) return {};
  return best;
}

using CubeKey = std::array<long, 3>;

CubeKey cube_at(const Vector3d& p, double side) {
  return {std::lround(std::floor(p.x() / side)), std::lround(std::floor(p.y() / side)),
          std::lround(std::floor(p.z() / side))};
}

// A number for each connected part of the cubes that hold the points.
std::map<CubeKey, int> parts_of(const std::vector<Vector3d>& points, int* parts) {
  std::map<CubeKey, int> part;
  for (const Vector3d& p : points) part[cube_at(p, kGap)] = -1;
  *parts = 0;
  for (auto& [first, number] : part) {
    if (number >= 0) continue;
    std::vector<CubeKey> open = {first};
    number = *parts;
    while (!open.empty()) {
      const CubeKey at = open.back();
      open.pop_back();
      for (int k = 0; k < 27; ++k) {
        const auto next = part.find({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1});
        if (next == part.end() || next->second >= 0) continue;
        next->second = *parts;
        open.push_back(next->first);
      }
    }
    ++*parts;
  }
  return part;
}

// Height up to which a point belongs to the table [m]: what lies beneath the plane is noise and
// waves of the table, and as much lies above. So a bowl's floor of 2 mm is not taken for the table
// where the cameras are good enough.
double height_on_table(const TablePlane& table, const std::vector<Vector3d>& points) {
  constexpr double kLeast = 1e-3, kShare = 0.99, kReserve = 2.0;
  std::vector<double> beneath;
  for (const Vector3d& p : points)
    if (const double h = table.height(p); h < 0.0 && h > -kOnTable) beneath.push_back(-h);
  if (beneath.empty()) return kLeast;
  const auto at =
      beneath.begin() + static_cast<std::ptrdiff_t>(kShare * static_cast<double>(beneath.size()));
  std::nth_element(beneath.begin(), at, beneath.end());
  return std::clamp(kReserve * *at, kLeast, kOnTable);
}

// The highest of the points over each square of P within `radius` of the middle.
std::vector<Vector3d> upper_points(const std::vector<Vector3d>& points, const DrawnAbout& drawing,
                                   double radius) {
  std::map<std::array<long, 2>, Vector3d> top;  // in P
  const Pose X_PW = drawing.X_WP.inverse();
  for (const Vector3d& p_W : points) {
    const Vector3d p = X_PW * p_W;
    if ((p.head<2>() - drawing.middle).norm() > radius) continue;
    const CubeKey at = cube_at(p, kGap);
    const auto [kept, is_new] = top.try_emplace({at[0], at[1]}, p);
    if (p.z() > kept->second.z()) kept->second = p;
  }
  std::vector<Vector3d> upper;
  for (const auto& [at, p] : top) upper.push_back(drawing.X_WP * p);
  return upper;
}

// A part that stands on the table is as wide, seen along the drawing axis, as a quarter of the
// drawing's circle.
bool bears_drawing(const std::vector<Vector3d>& standing, const DrawnAbout& drawing) {
  constexpr double kShare = 0.25;
  int parts = 0;
  const std::map<CubeKey, int> part = parts_of(standing, &parts);
  std::vector<std::set<std::array<long, 2>>> squares(static_cast<std::size_t>(parts));
  const Pose X_PW = drawing.X_WP.inverse();
  double most = 0.0;
  for (const Vector3d& p : standing) {
    const CubeKey at = cube_at(X_PW * p, kGap);
    auto& of_part = squares[static_cast<std::size_t>(part.at(cube_at(p, kGap)))];
    of_part.insert({at[0], at[1]});
    most = std::max(most, kGap * kGap * static_cast<double>(of_part.size()));
  }
  return most > kShare * std::numbers::pi * drawing.radius * drawing.radius;
}

// Keeps the parts that are above or beneath the largest one, seen along the drawing axis: a head
// over a body whose neck no camera sees.
void keep_what_hides(const std::vector<Vector3d>& standing, const std::map<CubeKey, int>& part,
                     const Pose& X_WP, std::ptrdiff_t largest, std::vector<char>* kept) {
  const Pose X_PW = X_WP.inverse();
  const auto square = [&](const Vector3d& p) {
    const CubeKey at = cube_at(X_PW * p, kGap);
    return std::array<long, 2>{at[0], at[1]};
  };
  std::set<std::array<long, 2>> under;
  for (const Vector3d& p : standing)
    if (part.at(cube_at(p, kGap)) == largest) under.insert(square(p));
  for (const Vector3d& p : standing)
    if (under.count(square(p)) > 0)
      (*kept)[static_cast<std::size_t>(part.at(cube_at(p, kGap)))] = 1;
}

}  // namespace

FoundCanvas find_canvas(const PointCloud& cloud, const DrawnAbout& drawing,
                        const std::vector<std::string>& views) {
  FoundCanvas found;
  found.canvas.eyes = found.beside.eyes = cloud.eyes;
  const std::vector<Vector3d> sparse = thin(cloud, kSparse).points;
  std::optional<TablePlane> table;
  if (sparse.size() > 100) table = table_in(sparse, drawing.X_WP.R.col(2));
  const double highest = table ? height_on_table(*table, cloud.points) : 0.0;
  const auto on_table = [&](const Vector3d& p) { return table->height(p) < highest; };
  const auto above_table = [&] {
    std::vector<Vector3d> standing;
    for (const Vector3d& p : sparse)
      if (!table || !on_table(p)) standing.push_back(p);
    return standing;
  };
  if (table && !drawing.placed) {
    if (!bears_drawing(above_table(), drawing)) table.reset();
  } else if (table) {
    const std::vector<Vector3d> middle = upper_points(sparse, drawing, kAboutMiddle);
    if (2 * std::count_if(middle.begin(), middle.end(), on_table) >
        static_cast<std::ptrdiff_t>(middle.size()))
      table.reset();  // the drawing lies on it
  }
  const std::vector<Vector3d> standing = above_table();
  int parts = 0;
  const std::map<CubeKey, int> part = parts_of(standing, &parts);
  std::vector<Vector3d> upper;
  if (drawing.placed) upper = upper_points(standing, drawing, drawing.radius);
  std::vector<std::size_t> drawn_on(static_cast<std::size_t>(parts)), size(drawn_on);
  for (const Vector3d& p : upper) ++drawn_on[static_cast<std::size_t>(part.at(cube_at(p, kGap)))];
  for (const Vector3d& p : standing) ++size[static_cast<std::size_t>(part.at(cube_at(p, kGap)))];
  std::vector<char> kept(drawn_on.size());
  for (std::size_t k = 0; k < kept.size(); ++k)
    kept[k] = static_cast<double>(drawn_on[k]) >=
              std::max(1.0, kLeastOfDrawing * static_cast<double>(upper.size()));
  if (std::count(kept.begin(), kept.end(), 1) == 0 && !kept.empty()) {
    const auto largest = std::max_element(size.begin(), size.end()) - size.begin();
    kept[static_cast<std::size_t>(largest)] = 1;
    if (!drawing.placed) keep_what_hides(standing, part, drawing.X_WP, largest, &kept);
  }

  struct Removed {
    int table = 0, beside = 0;
  };
  std::vector<Removed> removed(cloud.eyes.size());
  Removed all;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const Vector3d& p = cloud.points[i];
    const bool lies = table && on_table(p);
    const auto at = part.find(cube_at(p, kGap));
    // A cube that holds no point of the thinned cloud is at a part's fringe.
    const bool strange = !lies && at != part.end() && !kept[static_cast<std::size_t>(at->second)];
    append(cloud, i, lies || strange ? &found.beside : &found.canvas);
    Removed& of = removed[static_cast<std::size_t>(cloud.camera[i])];
    of.table += lies, all.table += lies;
    of.beside += strange, all.beside += strange;
  }
  if (found.beside.points.empty()) return found;
  std::string text = "left out of the cloud:";
  if (table) {
    const Vector3d& n = table->n;
    text += fmt::format(
        " the table, a plane through ({:.2f}, {:.2f}, {:.3f}) m with the normal "
        "({:.2f}, {:.2f}, {:.2f}), {} points;",
        table->d * n.x(), table->d * n.y(), table->d * n.z(), n.x(), n.y(), n.z(), all.table);
  }
  text += fmt::format(" {} points of {} other parts, which the drawing does not lie on", all.beside,
                      parts - std::count(kept.begin(), kept.end(), 1));
  found.notes.push_back(text + " (perception.find_canvas=false keeps all)");
  for (std::size_t v = 0; v < removed.size() && removed.size() > 1; ++v)
    found.notes.push_back(fmt::format("{}: {} points on the table and {} on other parts left out",
                                      v < views.size() ? views[v] : fmt::format("view {}", v),
                                      removed[v].table, removed[v].beside));
  return found;
}

}  // namespace impedraw
