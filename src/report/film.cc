#include "impedraw/report/film.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

std::filesystem::path page_in(const std::filesystem::path& run) {
  std::error_code error;
  if (std::filesystem::is_regular_file(run, error) && run.extension() == ".html") return run;
  for (const char* name : {"report.html", "plan.html", "compare.html"})
    if (std::filesystem::is_regular_file(run / name, error)) return run / name;
  throw InputError(
      fmt::format("{}: has no report.html; name the folder of a run, of a plan or of a comparison, "
                  "or write a run's page with ./impedraw report",
                  run.string()));
}

}  // namespace

int film(const FilmOptions& options) {
  const std::string kind = options.out.extension();
  if (kind != ".webp" && kind != ".mp4" && kind != ".png")
    throw InputError(fmt::format("--out {}: ends in '{}'; valid are .webp, .mp4, .png",
                                 options.out.string(), kind));
  const std::filesystem::path folder = std::filesystem::absolute(options.out).parent_path();
  if (!std::filesystem::is_directory(folder))
    throw InputError(
        fmt::format("--out {}: there is no folder {}", options.out.string(), folder.string()));
  int width = 0, height = 0, read = 0;
  constexpr int kLeast = 64, kMost = 4096;
  if (std::sscanf(options.size.c_str(), "%4dx%4d%n", &width, &height, &read) != 2 ||
      static_cast<std::size_t>(read) != options.size.size() || std::min(width, height) < kLeast ||
      std::max(width, height) > kMost || width % 2 != 0 || height % 2 != 0)
    throw InputError(
        fmt::format("--size {}: must be WIDTHxHEIGHT, even numbers from {} to {}, as in 1280x720",
                    options.size, kLeast, kMost));
  if (options.from && options.to && !(*options.from < *options.to))
    throw InputError(
        fmt::format("--from {} s must lie before --to {} s", *options.from, *options.to));
  nlohmann::json job = {
      {"page", std::filesystem::absolute(page_in(options.run)).lexically_normal().string()},
      {"out", std::filesystem::absolute(options.out).lexically_normal().string()},
      {"web", std::string(IMPEDRAW_ROOT) + "/build/web"},
      {"width", width},
      {"height", height},
      {"fps", options.fps},
      {"speed", options.speed},
      {"view", options.view},
      {"colour", options.colour},
      {"theme", options.theme},
      {"hide", options.hide},
      {"plain", options.plain}};
  if (options.from) job["from"] = *options.from;
  if (options.to) job["to"] = *options.to;
  const std::string program = std::string(IMPEDRAW_ROOT) + "/web/film.mjs", text = job.dump();
  std::fflush(stdout);
  execlp("node", "node", program.c_str(), text.c_str(), static_cast<char*>(nullptr));
  throw InputError(fmt::format("film needs node on PATH: {}", std::strerror(errno)));
}

}  // namespace impedraw
