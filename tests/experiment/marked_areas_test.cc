// Areas marked on an object, read again as the region of a `cover`.
#include "impedraw/experiment/marked_areas.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/artwork_file.h"

namespace impedraw {
namespace {

using Outlines = std::vector<std::vector<Eigen::Vector2d>>;

TEST(MarkedAreas, LieWhereTheyWereMarked) {
  const Outlines marked = {{{0.61, -0.02}, {0.65, 0.03}, {0.58, 0.041}, {0.55, -0.01}},
                           {{0.3, -0.2}, {0.31, -0.2}, {0.31, -0.21}}};
  const MarkedAreas areas = marked_areas(marked);
  const std::filesystem::path file = std::filesystem::temp_directory_path() /
                                     ("marked_areas_" + std::to_string(getpid()) + ".svg");
  std::ofstream(file) << areas.svg;
  const Artwork artwork = read_artwork(file);
  std::filesystem::remove(file);
  const Placement placement = place(artwork, areas.placement);
  ASSERT_EQ(artwork.areas.size(), marked.size());
  for (std::size_t a = 0; a < marked.size(); ++a)
    for (const Eigen::Vector2d& p : marked[a]) {
      double off = 1.0;
      for (const Eigen::Vector2d& read : artwork.areas[a].outlines.at(0))
        off = std::min(off, (placement.to_plane(read) - p).norm());
      EXPECT_LT(off, 2e-6) << "area " << a << " at " << p.transpose();
    }
}

TEST(MarkedAreas, EncloseSomething) {
  for (const Outlines& nothing : {Outlines{}, Outlines{{{0.1, 0.1}, {0.2, 0.2}}},
                                  Outlines{{{0.1, 0.1}, {0.2, 0.1}, {0.3, 0.1}}}})
    EXPECT_THROW(marked_areas(nothing), InputError);
}

}  // namespace
}  // namespace impedraw
