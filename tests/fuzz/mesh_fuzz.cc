// Meshes. The first byte says the format of the rest: 'o', OBJ; 's', STL; 'f', OFF; 'g', glb; 't',
// gltf; 'm', 3mf; 'd', dae; else PLY.
#include <algorithm>
#include <string>

#include "fuzz.h"
#include "impedraw/canvas/mesh_check.h"
#include "impedraw/canvas/mesh_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  static const std::string kinds = "osfgtmd";
  static const char* const names[] = {"fuzz.obj",  "fuzz.stl", "fuzz.off", "fuzz.glb",
                                      "fuzz.gltf", "fuzz.3mf", "fuzz.dae", "fuzz.ply"};
  const char* name = names[std::min(kinds.find(static_cast<char>(input.byte())), kinds.size())];
  return fuzz::expect_value_or_input_error([&] {
    const CheckedMesh mesh = check_mesh(parse_mesh(input.rest(), name, 0.001));
    require_drawable(mesh, name);
  });
}
