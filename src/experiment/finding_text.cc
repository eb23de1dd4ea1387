#include "impedraw/experiment/finding_text.h"

#include <fmt/format.h>

namespace impedraw {

std::string refusal_text(const Finding& f, bool seen) {
  const auto words = [&f]() -> const char* {
    switch (f.problem) {
      case Problem::off_canvas:
        return "leaves the canvas";
      case Problem::fold:
        return "crosses a fold of the surface";
      case Problem::crease:
        return "crosses a crease of the surface";
      case Problem::too_rough:
        return "crosses what is too rough";
      case Problem::too_steep:
        return "lies on too steep a slope";
      case Problem::out_of_reach:
        return "leaves the arm's reach";
      case Problem::joint_limit:
        return "brings a joint to its limit";
      case Problem::near_singular:
        return "brings the arm near a singular posture";
      case Problem::torque:
        return "needs too much torque";
      case Problem::arm_collision:
        return "makes the arm touch the canvas or the table";
      case Problem::pen_collision:
        return "makes the pen's shaft touch the canvas or the table";
      case Problem::joint_jump:
        return "cannot be followed without a jump of the joints";
      case Problem::crawls:
        return "would have to crawl";
      case Problem::too_short:
        return "leaves too short a remainder";
    }
    return "fails";
  };
  return fmt::format(
      "stroke {} {}{}: {}, farthest at page ({:.1f}, {:.1f}) mm, world ({:.4f}, {:.4f}, {:.4f}) m",
      f.part.stroke, words(),
      seen && f.problem == Problem::off_canvas ? ", as the cameras see it" : "", f.text,
      f.page_mm.x(), f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

std::string finding_text(const Finding& f) {
  return fmt::format(
      "stroke {}, {:.1f} to {:.1f} mm of it: {}: {}; worst at page ({:.1f}, {:.1f}) mm, world "
      "({:.3f}, {:.3f}, {:.3f}) m",
      f.part.stroke, 1e3 * f.part.from, 1e3 * f.part.to, name_of(f.problem), f.text, f.page_mm.x(),
      f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

}  // namespace impedraw
