// Settings of the log: scenario group `log`.
#pragma once

namespace impedraw {

// reduced: for every step only what the metrics need; full rows every 16 ms and at the extremes of
// the force. full: a full row for every step.
enum class LogRate { reduced, full };

struct LogSettings {
  LogRate rate = LogRate::reduced;
};

}  // namespace impedraw
