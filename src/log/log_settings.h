// How much of a run its log keeps: scenario group `log`.
#pragma once

namespace impedraw {

// reduced: every step as far as the metrics need it, the rest at rows 16 ms apart and at the
// extremes of the force. full: everything of every step.
enum class LogRate { reduced, full };

struct LogSettings {
  LogRate rate = LogRate::reduced;
};

}  // namespace impedraw
