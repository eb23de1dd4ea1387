// The true depth of a cutter's groove, place by place along the lines.
//
// d = n·(p_C − p_E) at every step in contact, on a line; the groove is as deep as the cutter has
// been within kBin, in any pass. A place of a promised line that nothing cut has the depth 0.
#pragma once

#include <vector>

#include "impedraw/run/tool_judge.h"

namespace impedraw {

class GrooveJudge : public ToolJudge {
 public:
  static constexpr double kBin = 2e-4;  // [m]

  explicit GrooveJudge(const Experiment& experiment);
  void add(const LogRow& row) override;
  // depth_error_rms, depth_error_max and depth_mean [mm], under "metrics"; null without a line.
  nlohmann::ordered_json results() const override;
  const char* file() const override { return kGrooveFile; }

 private:
  int lines_;                               // of one pass
  double asked_;                            // [m]
  std::vector<std::vector<double>> depth_;  // of each line, at each of its places [m]
  int last_stroke_ = -1;
  std::size_t last_bin_ = 0;
};

}  // namespace impedraw
