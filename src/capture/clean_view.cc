#include "impedraw/capture/clean_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "impedraw/common/in_parallel.h"

namespace impedraw {
namespace {

constexpr int kStrides[] = {8, 4, 2, 1};  // [px]
constexpr int kPasses = 10;               // with each
constexpr float kGain = 0.375F;           // λ: the wave of two pixels vanishes in one pass

}  // namespace

void smooth_quanta(double quantum, DepthImage* image) {
  const int width = image->width, height = image->height;
  const auto half = static_cast<float>(0.5 * quantum);
  // In units that leave a float's digits to what is measured.
  std::vector<float> measured(image->depth.size());
  std::transform(image->depth.begin(), image->depth.end(), measured.begin(),
                 [](double z) { return static_cast<float>(1.0 / z); });
  std::vector<float> w = measured, next = w;
  for (const int s : kStrides)
    for (int pass = 0; pass < kPasses; ++pass) {
      in_halves(height, [&](int begin, int end) {
        for (int j = begin; j < end; ++j)
          for (int i = 0; i < width; ++i) {
            const std::size_t at = static_cast<std::size_t>(j) * width + i;
            const float own = measured[at];
            if (!std::isfinite(own)) continue;
            const float most = half * own * own;  // of a change of w
            float sum = 0.0F;
            int n = 0;
            const auto along = [&](std::size_t step) {
              const std::size_t far = 2 * s * step;
              const float told =
                  (4 * (w[at - far / 2] + w[at + far / 2]) - w[at - far] - w[at + far]) / 6;
              if (!(std::abs(told - own) < most)) return;  // or it is not finite
              sum += told - w[at];
              ++n;
            };
            if (i >= 2 * s && i + 2 * s < width) along(1);
            if (j >= 2 * s && j + 2 * s < height) along(static_cast<std::size_t>(width));
            if (n > 0)
              next[at] =
                  std::clamp(w[at] + kGain * sum / static_cast<float>(n), own - most, own + most);
          }
      });
      std::swap(w, next);
    }
  for (std::size_t k = 0; k < w.size(); ++k)
    if (std::isfinite(w[k])) image->depth[k] = 1.0 / static_cast<double>(w[k]);
}

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
