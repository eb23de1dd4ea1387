// ./impedraw film: a film or a picture of a finished run, rendered without a screen.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace impedraw {

struct FilmOptions {
  std::filesystem::path
      run;  // a folder with report.html, plan.html or compare.html, or such a page
  std::filesystem::path out;      // .webp or .mp4: a film; .png: one picture
  std::string size = "1280x720";  // [px]
  double fps = 25.0;              // frames a second of the film
  double speed = 1.0;             // seconds of the run a second of the film
  std::string view = "free", colour, theme = "light";
  std::string hide;                // parts, separated by commas
  std::optional<double> from, to;  // [s]; default: all; a picture shows `to`
  bool plain = false;              // without legend, state and clock
};

// Hands over to web/film.mjs, which renders the page in headless Chromium and has ffmpeg encode it.
// Returns only by throwing: InputError for an option that is not valid or a page that is missing.
int film(const FilmOptions& options);

}  // namespace impedraw
