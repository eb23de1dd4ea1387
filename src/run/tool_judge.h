// Judges a tool's work by the truth of every step.
#pragma once

#include <memory>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/experiment/experiment.h"
#include "impedraw/log/log.h"

namespace impedraw {

inline constexpr const char* kGrooveFile = "groove.json";
inline constexpr const char* kBladeFile = "blade.json";
inline constexpr const char* kJetFile = "jet.json";

class ToolJudge {
 public:
  virtual ~ToolJudge() = default;
  virtual void add(const LogRow& row) = 0;
  // Under "metrics" what metrics.json has, too; null where nothing was judged.
  virtual nlohmann::ordered_json results() const = 0;
  virtual const char* file() const = 0;  // in the run's folder
};

// Null for a pen and a pad.
std::unique_ptr<ToolJudge> tool_judge(const Experiment& experiment);

}  // namespace impedraw
