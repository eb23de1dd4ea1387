#include "impedraw/experiment/experiment.h"

#include "impedraw/experiment/plan_notes.h"
#include "impedraw/experiment/rotor_check.h"
#include "impedraw/experiment/spring_check.h"

namespace impedraw {

ControlSetup control_for(PlannedDrawing* drawing, const Places& places) {
  const Scenario& given = drawing->scenario;
  ControlSettings& s = drawing->scenario.control;
  // The force tells more than the cloud does of rough ground, and of the surface under a pad. A
  // canvas that moves is followed better by the estimate alone.
  const bool feels =
      drawing->plan.rough || (given.tool.kind == ToolKind::pad && s.source != WrenchSource::none &&
                              !given.perception.frames.enabled);
  const bool leans = given.path.lean_deg > 0.0;
  if (!s.pen_axis) s.pen_axis = feels || leans ? PenAxis::plan : PenAxis::surface;
  if (!s.normal_error_deg) s.normal_error_deg = feels ? kRoughNormalError : 0.0;
  if (!s.felt_normal.share) s.felt_normal.share = feels ? kRoughFeltShare : 0.0;
  const SettingErrors setting_errors(places);
  ControlSetup control =
      make_control_setup(drawing->scenario, drawing->belief, drawing->plan, setting_errors);
  bear_joint_springs(drawing->scenario, drawing->belief.arm, drawing->belief.start_q,
                     drawing->plan.rest_q, &control, &drawing->plan.notes, setting_errors);
  check_rotors(drawing->scenario, control, drawing->belief.arm, drawing->plan.rest_q,
               &drawing->plan.notes, setting_errors);
  return control;
}

std::vector<std::string> notes_of(const PlannedDrawing& drawing) {
  std::vector<std::string> notes = drawing.artwork.notes;
  notes.insert(notes.end(), drawing.belief.notes.begin(), drawing.belief.notes.end());
  notes.insert(notes.end(), drawing.plan.notes.begin(), drawing.plan.notes.end());
  return notes;
}

}  // namespace impedraw
