#include "impedraw/experiment/page_context.h"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "impedraw/arm/plain_urdf.h"
#include "impedraw/canvas/mesh_file.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/settings/settings_doc.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;

// Nothing where the file is missing or unreadable: the page then draws what it has.
void add_link_mesh(const fs::path& file, int link, const VisualShape& shape,
                   std::vector<PageLinkMesh>* meshes) {
  std::error_code error;
  if (file.empty() || !fs::is_regular_file(file, error)) return;
  try {
    TriangleMesh mesh = read_mesh(file, {});
    for (Eigen::Vector3d& v : mesh.vertices)
      v = shape.X_LS * Eigen::Vector3d(v.cwiseProduct(shape.size));
    constexpr double kOff = 1e-3;  // [m]; a pixel of the whole scene
    meshes->push_back({link, page_mesh(mesh.vertices, mesh.triangles, 4000, kOff)});
  } catch (const InputError&) {
  }
}

fs::path own_meshes(const fs::path& urdf) {
  return data_folder() / "build/arm-meshes" / urdf.stem();
}

std::vector<PageLinkMesh> link_meshes(const fs::path& urdf, const std::vector<DrawnLink>& arm) {
  std::vector<PageLinkMesh> meshes;
  const fs::path own = own_meshes(urdf);
  std::error_code error;
  const bool has_own = fs::is_directory(own, error);
  for (std::size_t i = 0; i < arm.size(); ++i) {
    const int link = static_cast<int>(i);
    for (const VisualShape& shape : arm[i].shapes)
      if (shape.kind == VisualShape::Kind::mesh)
        add_link_mesh(urdf_mesh(urdf, shape.mesh), link, shape, &meshes);
    if (has_own)
      add_link_mesh(own / (arm[i].name + ".obj"), link, {.size = Eigen::Vector3d::Ones()}, &meshes);
  }
  return meshes;
}

}  // namespace

PageContext page_context(const Scenario& scenario, const PlacedArtwork& artwork,
                         const std::string& command) {
  PageContext page;
  try {
    const fs::path urdf = urdf_of(scenario.arm);
    page.arm = read_arm_shapes(urdf);
    page.meshes = link_meshes(urdf, page.arm);
    std::ifstream notice(own_meshes(urdf) / "NOTICE");
    page.meshes_notice.assign(std::istreambuf_iterator<char>(notice), {});
  } catch (const InputError&) {
  }
  if (scenario.perception.enabled)
    for (const CameraSettings& c : scenario.perception.cameras)
      page.cameras.push_back({look_at(c.p_WC, c.target_W), c.fov_y_deg, c.width, c.height});
  Scenario now = scenario, initial;
  const std::vector<SettingRow> rows = setting_rows(described(now)),
                                defaults = setting_rows(described(initial));
  for (const SettingRow& row : rows) {
    if (row.group) continue;
    const auto same = std::find_if(defaults.begin(), defaults.end(),
                                   [&row](const SettingRow& d) { return d.name == row.name; });
    page.settings.push_back(
        {row.name, row.initial, same == defaults.end() ? "" : same->initial, row.unit, row.help});
  }
  page.command = command;
  page.R_WP = artwork.X_WP.R;
  page.ink_width = scenario.pen.width;
  return page;
}

}  // namespace impedraw
