// load_artwork() of artwork.h, with its progress told.
#pragma once

#include <functional>

#include "impedraw/experiment/artwork.h"

namespace impedraw {

// `progress`: called now and then with the share of the ordering, which takes longest.
PlacedArtwork load_artwork(const DrawingSettings& settings, const SettingErrors& setting_errors,
                           const std::function<void(double)>& progress);

}  // namespace impedraw
