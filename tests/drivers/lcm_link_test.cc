// The client of a broker against bytes on a socket, as liblcm 1.3 writes them.
#include "impedraw/drivers/lcm_link.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopback_server.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;

void put(std::string* to, std::uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) to->push_back(static_cast<char>(value >> shift));
}

std::string frame(const std::string& channel, const std::string& bytes, std::uint32_t kind = 1) {
  std::string all;
  put(&all, kind);
  put(&all, static_cast<std::uint32_t>(channel.size()));
  all += channel;
  put(&all, static_cast<std::uint32_t>(bytes.size()));
  return all + bytes;
}

std::string answer(std::uint32_t magic = 0x287617fa) {
  std::string all;
  put(&all, magic);
  put(&all, 0x0100);
  return all;
}

// Sends `bytes` in pieces of random sizes to the first client, then closes. Keeps what it was sent.
class Broker {
 public:
  explicit Broker(std::string bytes, unsigned seed = 1, std::size_t largest = 1 << 20) {
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
      char some[4096];
      for (ssize_t n = 0; (n = recv(peer, some, sizeof some, 0)) > 0;) got.append(some, n);
      close(peer);
    });
  }
  ~Broker() { join(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  std::string url, got;  // got: read after join()

 private:
  LoopbackServer server_;
  std::thread thread_;
};

std::string text(std::span<const std::uint8_t> bytes) { return {bytes.begin(), bytes.end()}; }

TEST(LcmLink, TakesMessagesHoweverTheyAreCut) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937 random(seed);
    std::string bytes = answer();
    std::vector<std::string> sent, taken;
    for (int i = 0; i < 200; ++i) {
      const std::string channel = i % 3 != 0 ? "OURS" : "OTHERS";
      const std::size_t largest = LcmLink::kLargest - 12 - channel.size();
      std::string payload(i % 50 == 7 ? largest : random() % 700, '\0');
      for (char& c : payload) c = static_cast<char>(random());
      bytes += frame(channel, payload);
      if (channel == "OURS") sent.push_back(payload);
    }
    Broker broker(bytes, seed, seed % 2 == 0 ? 5000 : 1 << 20);
    LcmLink link(broker.url);
    link.subscribe("OURS", [&](auto message) { taken.push_back(text(message)); });
    while (link.wait(5.0)) link.handle();
    EXPECT_FALSE(link.connected()) << "the broker left";
    EXPECT_TRUE(taken == sent) << taken.size() << " of " << sent.size() << " messages came";
  }
}

TEST(LcmLink, WritesWhatABrokerReads) {
  Broker broker(answer());
  {
    LcmLink link(broker.url);
    link.subscribe("IIWA_STATUS", [](auto) {});
    const std::vector<std::uint8_t> bytes{7, 0, 255};
    EXPECT_TRUE(link.publish("IIWA_COMMAND", bytes));
  }
  broker.join();
  std::string wanted;
  put(&wanted, 0x287617fb);
  put(&wanted, 0x0100);
  put(&wanted, 2);
  put(&wanted, 11);
  wanted += "IIWA_STATUS" + frame("IIWA_COMMAND", std::string("\7\0\377", 3));
  EXPECT_EQ(broker.got, wanted);
}

TEST(LcmLink, HalfAMessageDoesNotBlock) {
  LoopbackServer server;
  std::thread thread([&] {
    const int peer = server.take();
    const std::string bytes = answer() + frame("OURS", std::string(100, 'x')).substr(0, 60);
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
  std::string long_name;
  put(&long_name, 1);
  put(&long_name, 0xffffffff);
  for (const std::string& bytes :
       {frame("OURS", "x", 9), long_name, frame("OURS", std::string(LcmLink::kLargest, 'x'))}) {
    Broker broker(answer() + bytes);
    LcmLink link(broker.url);
    link.subscribe("OURS", [](auto) { ADD_FAILURE(); });
    EXPECT_FALSE(link.wait(5.0));
    EXPECT_FALSE(link.connected());
    EXPECT_FALSE(link.publish("OURS", {}));
  }
}

TEST(LcmLink, WhoIsNoBrokerIsNamed) {
  for (const std::string& bytes : {answer(0x12345678), std::string("HTTP/1.1 400 Bad Request\r\n"),
                                   std::string("SSH"), std::string()}) {
    Broker other(bytes);
    try {
      LcmLink link(other.url);
      ADD_FAILURE() << bytes;
    } catch (const std::runtime_error& error) {
      EXPECT_THAT(error.what(), HasSubstr("what listens there is no LCM broker"));
    }
  }
}

}  // namespace
}  // namespace impedraw
