// The client of a broker against bytes on a socket.
#include "impedraw/drivers/lcm_link.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "lcm_frames.h"
#include "loopback_server.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

// Sends `bytes` in pieces of random sizes to the first client, then closes. Keeps what it was sent.
class Broker {
 public:
  explicit Broker(Bytes bytes, unsigned seed = 1, std::size_t largest = 1 << 20) {
    url = "tcpq://" + server_.address();
    thread_ = std::thread([this, bytes = std::move(bytes), seed, largest] {
      const int peer = server_.take();
      std::mt19937 random(seed);
      for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t most = std::min(largest, bytes.size() - at);
        const std::size_t n = std::uniform_int_distribution<std::size_t>(1, most)(random);
        if (send(peer, bytes.data() + at, n, MSG_NOSIGNAL) != static_cast<ssize_t>(n)) break;
        at += n;
      }
      shutdown(peer, SHUT_WR);
      std::uint8_t some[4096];
      for (ssize_t n = 0; (n = recv(peer, some, sizeof some, 0)) > 0;)
        got.insert(got.end(), some, some + n);
      close(peer);
    });
  }
  ~Broker() { join(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  std::string url;
  Bytes got;  // read after join()

 private:
  LoopbackServer server_;
  std::thread thread_;
};

TEST(LcmLink, TakesMessagesHoweverTheyAreCut) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    Bytes bytes = lcm_greeting();
    std::vector<Bytes> sent, taken;
    for (int i = 0; i < 200; ++i) {
      const std::string channel = i % 3 != 0 ? "OURS" : "OTHERS";
      const std::size_t largest = LcmLink::kLargest - 12 - channel.size();
      Bytes payload(i % 50 == 7 ? largest : random() % 700);
      for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random());
      append(&bytes, lcm_frame(channel, payload));
      if (channel == "OURS") sent.push_back(payload);
    }
    Broker broker(bytes, seed, seed % 2 == 0 ? 5000 : 1 << 20);
    LcmLink link(broker.url);
    link.subscribe("OURS",
                   [&](auto message) { taken.emplace_back(message.begin(), message.end()); });
    while (link.wait(5.0)) link.handle();
    EXPECT_FALSE(link.connected()) << "the broker left";
    EXPECT_TRUE(taken == sent) << taken.size() << " of " << sent.size() << " messages came";
  }
}

TEST(LcmLink, WritesWhatABrokerReads) {
  Broker broker(lcm_greeting());
  {
    LcmLink link(broker.url);
    link.subscribe("IIWA_STATUS", [](auto) {});
    EXPECT_TRUE(link.publish("IIWA_COMMAND", Bytes{7, 0, 255}));
  }
  broker.join();
  Bytes wanted = lcm_greeting(0x287617fb);
  put_number(&wanted, 2, 4);
  put_number(&wanted, 11, 4);
  append(&wanted, std::string_view("IIWA_STATUS"));
  append(&wanted, lcm_frame("IIWA_COMMAND", {7, 0, 255}));
  EXPECT_EQ(broker.got, wanted);
}

TEST(LcmLink, HalfAMessageDoesNotBlock) {
  LoopbackServer server;
  std::thread thread([&] {
    const int peer = server.take();
    Bytes bytes = lcm_greeting();
    append(&bytes, lcm_frame("OURS", Bytes(100, 'x')));
    bytes.resize(68);
    send(peer, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    char some[64];
    while (recv(peer, some, sizeof some, 0) > 0) {
    }
    close(peer);
  });
  {
    LcmLink link("tcpq://" + server.address());
    EXPECT_FALSE(link.wait(0.05));
    EXPECT_TRUE(link.connected());
  }
  thread.join();
}

TEST(LcmLink, OtherBytesEndTheConnection) {
  Bytes long_name;
  put_number(&long_name, 1, 4);
  put_number(&long_name, 0xffffffff, 4);
  for (const Bytes& other :
       {lcm_frame("OURS", {'x'}, 9), long_name, lcm_frame("OURS", Bytes(LcmLink::kLargest, 'x'))}) {
    Bytes bytes = lcm_greeting();
    append(&bytes, other);
    Broker broker(bytes);
    LcmLink link(broker.url);
    link.subscribe("OURS", [](auto) { ADD_FAILURE(); });
    EXPECT_FALSE(link.wait(5.0));
    EXPECT_FALSE(link.connected());
    EXPECT_FALSE(link.publish("OURS", {}));
  }
}

TEST(LcmLink, WhoIsNoBrokerIsNamed) {
  Bytes http;
  append(&http, std::string_view("HTTP/1.1 400 Bad Request\r\n"));
  for (const Bytes& bytes : {lcm_greeting(0x12345678), http, Bytes{'S', 'S', 'H'}, Bytes()}) {
    Broker other(bytes);
    try {
      LcmLink link(other.url);
      ADD_FAILURE() << bytes.size() << " bytes";
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("what listens there is no LCM broker"));
    }
  }
}

}  // namespace
}  // namespace impedraw
