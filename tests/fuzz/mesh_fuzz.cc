// Meshes. The first byte says the format of the rest: 'o', OBJ; 's', STL; else PLY.
#include "fuzz.h"
#include "impedraw/canvas/mesh_check.h"
#include "impedraw/canvas/mesh_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  const std::uint8_t kind = input.byte();
  const char* name = kind == 'o' ? "fuzz.obj" : kind == 's' ? "fuzz.stl" : "fuzz.ply";
  return fuzz::expect_value_or_input_error([&] {
    const CheckedMesh mesh = check_mesh(parse_mesh(input.rest(), name, 0.001));
    require_drawable(mesh, name);
  });
}
