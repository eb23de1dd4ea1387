// One run of a case of the force benchmark: a controller, an arm, a workpiece.
//
// The simulated arm gets the case's workpiece and starts anew for each run. An arm that is not
// simulated here keeps its session and its workpiece, which must be the standard bowl, and the pen
// goes from run to run. The force is the simulator's contact force along the true normal or, from
// another arm, the measured wrench along the believed one, or the readings of a sensor in a file.
//
// Differences between runs: noise and bias of the sensors, and where the controllers believe the
// workpiece to be, off by 0.5 mm along z and 0.5° about x and y (standard deviations). All
// controllers get the same ones.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "impedraw/experiment/prepare.h"
#include "impedraw/judge/force_case.h"
#include "impedraw/judge/force_metrics.h"
#include "impedraw/run/draw_into.h"
#include "impedraw/run/driver.h"

namespace impedraw {

enum class ForceController {
  ours,       // this program's (control/impedance.h)
  crisp,      // peer_laws.h
  impedance,  // peer_laws.h
};
inline constexpr std::string_view kForceControllerNames[] = {"ours", "crisp", "impedance"};
// As the page calls them.
inline constexpr std::string_view kForceControllerTitles[] = {
    "impedraw", "CRISP's law (written here)", "impedance with feed-forward (written here)"};

struct ForceRun {
  std::string ended;                 // why it ended early; empty: it did not
  double begin = 0.0;                // by the driver's clock [s]
  std::vector<JudgedSample> record;  // the whole of it; a force that nothing measures is NaN
  ForceQuestion question;            // for judge_force()
  std::optional<ForceProgramme> programme;

  // Finds the touch in the record, and with it the question.
  void ask();
};

// Readings of a sensor under the workpiece that is not the arm's own: a CSV file with the columns
// time, by the arm's clock since its session began [s], and force along the normal [N].
class SensorFile {
 public:
  // Waits for the file for `patience` [s]. Throws InputError that names the line at fault.
  SensorFile(const std::filesystem::path& file, double patience);
  void fill(ForceRun* run) const;  // the record's forces, between readings evenly

 private:
  std::vector<std::pair<double, double>> readings_;
};

class ForceBench {
 public:
  // experiment: with an arm and its control set-up; its canvas is replaced. make_driver: as
  // draw_into()'s. has_sensor: the force is in a file (SensorFile). Throws InputError where nothing
  // measures the force, and what starting throws.
  ForceBench(Prepared& experiment, const DriverMaker& make_driver, bool has_sensor);
  ~ForceBench();

  // seed: 1 for the first run. `go_on` is asked each cycle; false: the pen goes up, and the run
  // has ended early.
  ForceRun run(const ForceCase& c, ForceController controller, int seed,
               const std::function<bool()>& go_on);
  // Of a driven arm: why it can no longer be used; empty while it can.
  std::string fault() const;

 private:
  struct Law;
  void set_shape(Workpiece::Shape shape);
  CanvasMotion motion(const ForceCase& c, double start) const;

  Prepared& e_;
  Workpiece piece_;
  Scenario as_given_;
  std::unique_ptr<Driver> driver_;         // null: a simulated arm for each run
  const ArmState* state_ = nullptr;        // of the driven arm, not yet answered
  std::optional<Workpiece::Shape> shape_;  // of the simulated workpiece
};

}  // namespace impedraw
