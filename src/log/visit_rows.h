// The rows of run.h5, one after the other.
#pragma once

#include <filesystem>
#include <functional>

#include "impedraw/log/log.h"

namespace impedraw {

// Hands over the rows of a log, one after the other, with time, stroke, measured joint positions,
// pose of the tip, contact force and normal, measured wrench, estimated normal and poses of the
// canvas. Throws InputError as read_rows(), or if rows cannot be read.
void visit_rows(const std::filesystem::path& path, const std::function<void(const LogRow&)>& visit);

}  // namespace impedraw
