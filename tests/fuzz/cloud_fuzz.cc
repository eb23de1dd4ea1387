// Point clouds. The first byte says the format of the rest: 'c', PCD; 'x', XYZ; else PLY.
#include "fuzz.h"
#include "impedraw/capture/cloud_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  const std::uint8_t kind = input.byte();
  return fuzz::expect_value_or_input_error([&] {
    parse_cloud_file(input.rest(), kind == 'c'   ? "fuzz.pcd"
                                   : kind == 'x' ? "fuzz.xyz"
                                                 : "fuzz.ply");
  });
}
