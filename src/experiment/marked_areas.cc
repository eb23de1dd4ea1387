#include "impedraw/experiment/marked_areas.h"

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"

namespace impedraw {

MarkedAreas marked_areas(const std::vector<std::vector<Eigen::Vector2d>>& outlines) {
  Eigen::AlignedBox2d box;
  for (const auto& outline : outlines) {
    if (outline.size() < 3)
      throw InputError(fmt::format("an area has {} points; valid are 3 or more", outline.size()));
    for (const Eigen::Vector2d& p : outline) box.extend(p);
  }
  if (!(box.sizes().minCoeff() > 0.0)) throw InputError("no area is marked");
  MarkedAreas marked;
  marked.placement.scale = 1.0;
  marked.placement.about_page_origin = true;
  marked.placement.centre_m = box.max();
  // As Placement has it: the page's X runs along −y, and its Y along −x.
  const auto page = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return 1e3 * (box.max() - p).reverse();
  };
  const Eigen::Vector2d size = page(box.min());
  marked.svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.3f}mm\" height=\"{1:.3f}mm\" "
      "viewBox=\"0 0 {0:.3f} {1:.3f}\">\n",
      size.x(), size.y());
  for (const auto& outline : outlines) {
    marked.svg += "<path d=\"M";
    for (const Eigen::Vector2d& p : outline)
      marked.svg += fmt::format(" {:.3f},{:.3f}", page(p).x(), page(p).y());
    marked.svg += " Z\"/>\n";
  }
  marked.svg += "</svg>\n";
  return marked;
}

}  // namespace impedraw
