#include "impedraw/capture/clean_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace impedraw {

namespace {

constexpr double kGrazing = 5.67;  // tan 80°
constexpr double kSigmas = 6.0;
constexpr int kEdge = 2;    // pixels beside a step that are not trusted
constexpr int kSpeck = 60;  // pixels of the smallest part that is kept

// The largest difference of neighbouring depths on one surface [m].
double step_at(const CapturedView& view, double sigma_at_1m, double z) {
  const double pitch = z / std::min(view.lens.fx, view.lens.fy);
  return std::max({kGrazing * pitch, kSigmas * sigma_at_1m * z * z, 2 * view.quantum});
}

}  // namespace

double noise_at_1m(const CapturedView& view) {
  if (view.sigma_at_1m > 0) return view.sigma_at_1m;
  std::vector<double> curved;
  const DepthImage& image = view.depth;
  for (int j = 0; j < image.height; j += 3) {
    for (int i = 1; i + 1 < image.width; i += 2) {
      const double z = image.at(i, j), c = image.at(i - 1, j) - 2 * z + image.at(i + 1, j);
      if (std::isfinite(c)) curved.push_back(std::abs(c) / (z * z));
    }
  }
  if (curved.empty()) return 0;
  const auto middle = curved.begin() + static_cast<std::ptrdiff_t>(curved.size() / 2);
  std::nth_element(curved.begin(), middle, curved.end());
  return *middle / (std::sqrt(6.0) * 0.6745);
}

CleanedCounts clean(CapturedView* view) {
  DepthImage& image = view->depth;
  const int width = image.width, height = image.height;
  const double sigma = noise_at_1m(*view);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto at = [width](int i, int j) { return static_cast<std::size_t>(j) * width + i; };
  const std::vector<double> seen = image.depth;
  CleanedCounts counts;
  for (const double z : seen) counts.measured += std::isfinite(z);

  // A step between two neighbours takes the pixels beside it, along the row or the column.
  const auto part = [&](int i, int j, int di, int dj) {
    const double a = seen[at(i, j)], b = seen[at(i + di, j + dj)];
    if (!std::isfinite(a) || !std::isfinite(b)) return;
    if (std::abs(a - b) <= step_at(*view, sigma, std::min(a, b))) return;
    for (int k = 1 - kEdge; k <= kEdge; ++k) {
      const int x = i + k * di, y = j + k * dj;
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      double& z = image.depth[at(x, y)];
      counts.edges += std::isfinite(z);
      z = nan;
    }
  };
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      if (i + 1 < width) part(i, j, 1, 0);
      if (j + 1 < height) part(i, j, 0, 1);
    }
  }

  std::vector<char> reached(seen.size());
  std::vector<std::size_t> component;
  for (std::size_t first = 0; first < seen.size(); ++first) {
    if (reached[first] || !std::isfinite(image.depth[first])) continue;
    component.assign(1, first);
    reached[first] = 1;
    for (std::size_t k = 0; k < component.size(); ++k) {
      const std::size_t p = component[k];
      const int i = static_cast<int>(p % width), j = static_cast<int>(p / width);
      const auto go = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= width || y >= height || reached[at(x, y)]) return;
        const double z = image.depth[at(x, y)];
        if (!(std::abs(z - image.depth[p]) <= step_at(*view, sigma, z))) return;
        reached[at(x, y)] = 1;
        component.push_back(at(x, y));
      };
      go(i - 1, j), go(i + 1, j), go(i, j - 1), go(i, j + 1);
    }
    if (component.size() >= kSpeck) continue;
    for (const std::size_t p : component) image.depth[p] = nan;
    counts.specks += static_cast<int>(component.size());
  }
  return counts;
}

}  // namespace impedraw
