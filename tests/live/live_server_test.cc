#include "impedraw/live/live_server.h"

#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "allocations.h"
#include "impedraw/common/errors.h"
#include "impedraw/live/live_view.h"
#include "live/socket_client.h"
#include "run/prepared.h"

namespace impedraw {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class LiveServerTest : public ::testing::Test {
 protected:
  LiveServerTest() { start({}); }

  void start(LiveSettings settings) {
    settings.row_width = kWidth;
    server_ = std::make_unique<LiveServer>(settings);
    server_->serve("<p>the page</p>");
    const std::string address = server_->address();
    token_ = address.substr(address.find("token=") + 6);
    host_ = fmt::format("127.0.0.1:{}", server_->port());
  }

  std::string socket_target() const { return "/live?token=" + token_; }

  int join(SocketClient& client) const {
    return client.upgrade(socket_target(), host_, "http://" + host_);
  }

  void hand_over(int from, int to) const {
    for (int i = from; i < to; ++i) {
      const std::span<float> row = server_->rows().next();
      if (row.empty()) continue;
      for (std::size_t k = 0; k < kWidth; ++k) row[k] = static_cast<float>(i);
      server_->rows().commit();
    }
  }

  // Rows until one is the last that is awaited.
  static std::vector<float> times_until(SocketClient& client, float last) {
    std::vector<float> times;
    while (times.empty() || times.back() < last) {
      const auto frame = client.next();
      if (!frame || frame->opcode < 0) break;
      const std::vector<float> rows = rows_of(*frame);
      for (std::size_t i = 0; i < rows.size(); i += kWidth) times.push_back(rows[i]);
    }
    return times;
  }

  static std::string text_with(SocketClient& client, const std::string& what) {
    for (;;) {
      const auto frame = client.next();
      if (!frame || frame->opcode < 0) return {};
      if (frame->opcode == 1 && frame->payload.find(what) != std::string::npos)
        return frame->payload;
    }
  }

  template <typename Condition>
  static bool eventually(Condition condition) {
    for (int i = 0; i < 1500; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }

  static constexpr std::size_t kWidth = 100;
  std::unique_ptr<LiveServer> server_;
  std::string token_, host_;
};

long resident_kb() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmRSS:")) return std::stol(line.substr(6));
  return 0;
}

TEST_F(LiveServerTest, ShowsThePageToWhoHasTheAddress) {
  SocketClient client(server_->port());
  const std::string answer = client.get("/?token=" + token_, host_);
  EXPECT_THAT(answer, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(answer, HasSubstr("<p>the page</p>"));
  EXPECT_EQ(token_.size(), 32u);
}

TEST_F(LiveServerTest, RefusesWhatIsNotFromItsPage) {
  const auto status = [&](const std::string& target, const std::string& host,
                          const std::string& more = {}) {
    return SocketClient(server_->port()).get(target, host, more).substr(9, 3);
  };
  const std::string page = "/?token=" + token_;
  std::string wrong = token_;
  wrong[31] = wrong[31] == '0' ? '1' : '0';
  EXPECT_EQ(status("/?token=" + wrong, host_), "403");
  EXPECT_EQ(status("/?token=" + token_ + "0", host_), "403");
  EXPECT_EQ(status("/?token=", host_), "403");
  EXPECT_EQ(status("/", host_), "403");
  EXPECT_EQ(status(page, "evil.example"), "403");  // a name that was made to mean 127.0.0.1
  EXPECT_EQ(status(page, fmt::format("127.0.0.1:{}", server_->port() + 1)), "403");
  EXPECT_EQ(status(page, host_, "Origin: http://evil.example\r\n"), "403");
  EXPECT_EQ(status("/etc/passwd?token=" + token_, host_), "404");
  EXPECT_EQ(status("/../run.h5?token=" + token_, host_), "404");
  EXPECT_EQ(status(page, host_, "X-Long: " + std::string(9000, 'x') + "\r\n"), "431");

  const auto socket_status = [&](const std::string& target, const std::string& host,
                                 const std::string& origin) {
    return SocketClient(server_->port()).upgrade(target, host, origin);
  };
  const std::string here = "http://" + host_;
  EXPECT_EQ(socket_status("/live?token=" + wrong, host_, here), 403);
  EXPECT_EQ(socket_status(socket_target(), "evil.example", here), 403);
  EXPECT_EQ(socket_status(socket_target(), host_, "http://evil.example"), 403);
  EXPECT_EQ(socket_status(socket_target(), host_, "https://" + host_), 403);
  EXPECT_EQ(socket_status(socket_target(), host_, "null"), 403);
  EXPECT_EQ(socket_status(socket_target(), host_, ""), 403);
  EXPECT_EQ(socket_status(socket_target(), host_, here), 101);
}

TEST_F(LiveServerTest, APortInUseIsAnError) {
  LiveSettings same;
  same.port = server_->port();
  try {
    LiveServer second(same);
    FAIL() << "listens twice";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), StartsWith(fmt::format("--port {}: cannot be listened to on "
                                                     "127.0.0.1: ",
                                                     same.port)));
  }
}

TEST_F(LiveServerTest, TwoViewersSeeEachRowOnceAndInOrderWheneverTheyJoin) {
  SocketClient early(server_->port());
  ASSERT_EQ(join(early), 101);
  hand_over(0, 3000);
  const std::vector<float> seen = times_until(early, 2999.0f);
  SocketClient late(server_->port());
  ASSERT_EQ(join(late), 101);
  const std::vector<float> all = times_until(late, 2999.0f);
  ASSERT_EQ(all.size(), 3000u);
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_EQ(all[i], static_cast<float>(i));
  ASSERT_FALSE(seen.empty());
  for (std::size_t i = 1; i < seen.size(); ++i) ASSERT_GT(seen[i], seen[i - 1]);
  EXPECT_EQ(seen.back(), 2999.0f);
  EXPECT_EQ(server_->viewers(), 2u);

  // One that comes back names what it has.
  SocketClient again(server_->port());
  ASSERT_EQ(again.upgrade(socket_target() + "&since=2499.5", host_, "http://" + host_), 101);
  const std::vector<float> rest = times_until(again, 2999.0f);
  EXPECT_EQ(rest.size(), 500u);
  EXPECT_EQ(rest.front(), 2500.0f);
}

TEST_F(LiveServerTest, AViewerPausesResumesAndStopsForAll) {
  SocketClient one(server_->port()), other(server_->port());
  ASSERT_EQ(join(one), 101);
  ASSERT_EQ(join(other), 101);
  one.send_text("pause");
  EXPECT_THAT(text_with(other, "paused"), HasSubstr(R"("state": "paused")"));
  EXPECT_TRUE(server_->paused());
  other.send_text("resume");
  EXPECT_TRUE(eventually([&] { return !server_->paused(); }));
  one.send_text("explode");
  one.send_text("pause");
  EXPECT_TRUE(eventually([&] { return server_->paused(); }));
  EXPECT_FALSE(server_->stopped());
  one.send_text("stop");
  EXPECT_TRUE(eventually([&] { return server_->stopped() && !server_->paused(); }));
  EXPECT_THAT(text_with(other, R"("stopping": true)"), HasSubstr("running"));
}

TEST_F(LiveServerTest, AViewerStopsInAnEmergencyAndNobodyPausesAfterThat) {
  SocketClient one(server_->port()), other(server_->port());
  ASSERT_EQ(join(one), 101);
  ASSERT_EQ(join(other), 101);
  EXPECT_FALSE(server_->emergency());
  one.send_text("emergency");
  EXPECT_TRUE(eventually([&] { return server_->emergency(); }));
  other.send_text("pause");
  EXPECT_THAT(text_with(other, R"("stopping": true)"), HasSubstr("running"));
  EXPECT_FALSE(server_->paused());
}

TEST_F(LiveServerTest, TheReportReachesWhoWatches) {
  SocketClient client(server_->port());
  ASSERT_EQ(join(client), 101);
  hand_over(0, 10);
  std::string report;
  std::thread viewer([&] {
    while (const auto frame = client.next()) {
      if (frame->opcode < 0) break;
      if (frame->opcode != 2 || frame->payload[0] != 1) continue;
      report = frame->payload.substr(4);
      break;
    }
  });
  const std::string data(3'000'000, 'r');
  server_->finish(data, milliseconds(10000));
  server_.reset();
  viewer.join();
  EXPECT_EQ(report.size(), data.size());
  EXPECT_TRUE(report == data);  // not printed: it is long
}

// The run's hooks said so to nobody.
TEST(LiveView, TellsWhoWatchesThatTheReportIsBeingMade) {
  const Prepared e = prepared("bowl-sine");
  LiveView view({.show = true});
  view.begin(e, "");
  SocketClient client(view.server()->port());
  const std::string address = view.address(),
                    host = fmt::format("127.0.0.1:{}", view.server()->port());
  ASSERT_EQ(client.upgrade("/live?token=" + address.substr(address.find("token=") + 6), host,
                           "http://" + host),
            101);
  const RunHooks hooks = view.hooks();
  ASSERT_TRUE(hooks.ended);
  hooks.ended();
  bool told = false;
  for (int i = 0; i < 50 && !told; ++i) {
    const auto frame = client.next();
    if (!frame || frame->opcode < 0) break;
    told = frame->payload.find(R"("state": "ending")") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST_F(LiveServerTest, WhoLeavesChangesNothing) {
  {
    SocketClient client(server_->port());
    ASSERT_EQ(join(client), 101);
  }
  hand_over(0, 100);
  EXPECT_TRUE(eventually([&] { return server_->viewers() == 0; }));
  EXPECT_FALSE(server_->stopped());
  SocketClient next(server_->port());
  ASSERT_EQ(join(next), 101);
  EXPECT_EQ(times_until(next, 99.0f).size(), 100u);
}

TEST_F(LiveServerTest, AMessageTooLongEndsTheConnection) {
  LiveSettings hasty;
  hasty.request_time = milliseconds(500);  // also of a goodbye
  start(hasty);
  SocketClient client(server_->port());
  ASSERT_EQ(join(client), 101);
  client.send_text(std::string(100000, 'p'));
  EXPECT_TRUE(eventually([&] { return server_->viewers() == 0; }));
  // Its length alone is enough: none of it is waited for.
  SocketClient liar(server_->port());
  ASSERT_EQ(join(liar), 101);
  liar.send_bytes(std::string("\x81\xff\x00\x00\x7f\xff\xff\xff\xff\xff\0\0\0\0", 14));
  EXPECT_TRUE(eventually([&] { return server_->viewers() == 0; }));
  // What is not a frame at all.
  SocketClient noise(server_->port());
  ASSERT_EQ(join(noise), 101);
  noise.send_bytes(std::string(50, '\xf7'));
  EXPECT_TRUE(eventually([&] { return server_->viewers() == 0; }));
}

TEST_F(LiveServerTest, SoManyViewersAndNoMore) {
  std::vector<std::unique_ptr<SocketClient>> viewers;
  for (int i = 0; i < 8; ++i) {
    viewers.push_back(std::make_unique<SocketClient>(server_->port()));
    ASSERT_EQ(join(*viewers.back()), 101);
  }
  SocketClient ninth(server_->port());
  EXPECT_EQ(join(ninth), 503);
  viewers.pop_back();
  EXPECT_TRUE(eventually([&] { return server_->viewers() == 7; }));
  SocketClient next(server_->port());
  EXPECT_EQ(join(next), 101);
}

TEST_F(LiveServerTest, RequestsThatNeverEndAreGivenUp) {
  LiveSettings hasty;
  hasty.request_time = milliseconds(300);
  start(hasty);
  std::vector<std::unique_ptr<SocketClient>> silent;
  for (int i = 0; i < 60; ++i) {
    silent.push_back(std::make_unique<SocketClient>(server_->port()));
    silent.back()->send_bytes("GET / HTT");
  }
  EXPECT_TRUE(eventually([&] {
    SocketClient client(server_->port());
    return client.get("/?token=" + token_, host_).starts_with("HTTP/1.1 200");
  }));
}

// Rows are kept once, a viewer has one message under way, and silence ends it.
TEST_F(LiveServerTest, AViewerThatStopsReadingCostsNeitherMemoryNorTheOthersTime) {
  LiveSettings settings;
  settings.silence = milliseconds(2000);
  settings.kept_rows = 4000;
  start(settings);
  SocketClient stuck(server_->port(), 4096), quick(server_->port());
  ASSERT_EQ(join(stuck), 101);
  ASSERT_EQ(join(quick), 101);
  int rows = 0;
  const auto more = [&](int n) {
    hand_over(rows, rows + n);
    rows += n;
    std::this_thread::sleep_for(milliseconds(5));
  };
  for (int i = 0; i < 20; ++i) more(500);
  const long before = resident_kb();
  float last = 0.0f;
  for (int i = 0; i < 100; ++i) {  // 50,000 rows: 20 MB
    more(500);
    while (const auto frame = quick.next(milliseconds(1))) {
      ASSERT_GE(frame->opcode, 0);
      const std::vector<float> got = rows_of(*frame);
      if (!got.empty()) last = got[got.size() - kWidth];
    }
  }
  EXPECT_LT(resident_kb() - before, 8000);
  const float newest = static_cast<float>(rows - 1);
  if (last < newest)
    for (const float time : times_until(quick, newest)) last = time;
  EXPECT_EQ(last, newest);
  // Its pings are not answered: it is disconnected, the other is not.
  EXPECT_TRUE(eventually([&] {
    const auto frame = quick.next(milliseconds(1));
    return server_->viewers() == 1 && !(frame && frame->opcode < 0);
  }));
  EXPECT_EQ(server_->viewers(), 1u);
}

TEST(RowRing, DropsRowsRatherThanWaitAndAllocatesNothing) {
  RowRing ring(2, 4);
  int taken = 0;
  EXPECT_EQ(allocations_in([&] {
              for (int i = 0; i < 10; ++i) {
                const std::span<float> row = ring.next();
                if (row.empty()) continue;
                row[0] = static_cast<float>(i);
                ring.commit();
                ++taken;
              }
            }),
            0);
  EXPECT_EQ(taken, 4);
  EXPECT_EQ(ring.dropped(), 6u);
  for (int i = 0; i < 4; ++i) {
    ASSERT_FALSE(ring.oldest().empty());
    EXPECT_EQ(ring.oldest()[0], static_cast<float>(i));
    ring.pop();
  }
  EXPECT_TRUE(ring.oldest().empty());
  EXPECT_FALSE(ring.next().empty());
}

TEST(RowRing, HandsRowsFromThreadToThreadWhole) {
  RowRing ring(8, 16);
  constexpr int kRows = 200000;
  std::thread producer([&] {
    for (int i = 0; i < kRows; ++i) {
      std::span<float> row;
      while ((row = ring.next()).empty()) std::this_thread::yield();
      std::fill(row.begin(), row.end(), static_cast<float>(i));
      ring.commit();
    }
  });
  for (int i = 0; i < kRows; ++i) {
    std::span<const float> row;
    while ((row = ring.oldest()).empty()) std::this_thread::yield();
    for (const float x : row)
      if (x != static_cast<float>(i)) ADD_FAILURE() << "row " << i << " has " << x;
    ring.pop();
  }
  producer.join();
}

}  // namespace
}  // namespace impedraw
