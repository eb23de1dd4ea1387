#include "live_bench.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <unistd.h>

#include "impedraw/live/live_server.h"
#include "impedraw/live/live_view.h"
#include "impedraw/run/simulated_arm.h"
#include "live/socket_client.h"

namespace impedraw {

namespace {

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double factor_of(const RunOutcome& outcome) {
  return outcome.simulated / (outcome.wall.loop + outcome.wall.writing);
}

// A run that one client watches.
double watched(Prepared& e, const std::filesystem::path& log, std::vector<double>* delays) {
  LiveOptions options;
  options.show = true;
  LiveView view(options);
  view.begin(e, "");
  LiveServer& server = *view.server();
  const std::string host = "127.0.0.1:" + std::to_string(server.port());
  const std::string address = view.address();
  SocketClient client(server.port());
  if (client.upgrade("/live" + address.substr(address.find('?')), host, "http://" + host) != 101)
    throw std::runtime_error("the live view refuses its own client");
  std::atomic<bool> over = false;
  std::thread reader([&] {
    const std::size_t width = server.rows().width();
    while (!over) {
      const auto frame = client.next(std::chrono::milliseconds(100));
      if (!frame) continue;
      const double now = server.milliseconds();
      const std::vector<float> rows = rows_of(*frame);
      for (std::size_t i = 0; i < rows.size(); i += width) delays->push_back(now - rows[i + 1]);
    }
  });
  const RunHooks hooks = view.hooks();
  const double factor = factor_of(run(e, log, 0.0, hooks));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  over = true;
  reader.join();
  return factor;
}

}  // namespace

LiveCosts live_costs(Prepared& e) {
  constexpr int kPairs = 9;
  const std::filesystem::path log = std::filesystem::temp_directory_path() /
                                    ("impedraw_live_bench_" + std::to_string(getpid()) + ".h5");
  std::vector<double> alone, seen, delays;
  for (int i = 0; i < kPairs; ++i) {
    alone.push_back(factor_of(run(e, log, 0.0)));
    seen.push_back(watched(e, log, &delays));
  }
  std::filesystem::remove(log);
  LiveCosts costs;
  costs.delay_ms = quantile(delays, 0.5);
  costs.delay_p99_ms = quantile(delays, 0.99);
  costs.factor = quantile(seen, 0.5);
  costs.slower = quantile(alone, 0.5) / costs.factor;
  return costs;
}

}  // namespace impedraw
