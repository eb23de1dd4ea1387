#include "impedraw/capture/unquantised.h"

#include <algorithm>
#include <cmath>
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

}  // namespace impedraw
